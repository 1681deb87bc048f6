#include "app/event.h"

#include <fmt/format.h>

#include "comms/link_status.h"

namespace skein::app {
namespace {

const char* word(Event::Kind kind) noexcept {
  switch (kind) {
    case Event::Kind::start:
      return "start";
    case Event::Kind::pause:
      return "pause";
    case Event::Kind::resume:
      return "resume";
    case Event::Kind::stop:
      return "stop";
    case Event::Kind::perturb:
      return "perturb";
    case Event::Kind::move:
      return "move";
    case Event::Kind::gain:
      return "gain";
    case Event::Kind::gain_held:
      return "gain_held";
    case Event::Kind::lost:
      return "lost";
    case Event::Kind::found:
      return "found";
    case Event::Kind::avoid:
      return "avoid";
    case Event::Kind::clear:
      return "clear";
    case Event::Kind::deadline_missed:
      return "deadline_missed";
    case Event::Kind::link:
      return "link";
  }
  return "?";
}

}  // namespace

const char* name(core::GainName gain) noexcept {
  return gain == core::GainName::k_xx ? "k_xx" : gain == core::GainName::k_tt ? "k_tt" : "k_yy";
}

std::string describe(const Event& event) {
  const auto [a, b, c] = event.values;
  std::string text = word(event.kind);
  if (event.robot >= 0) text += fmt::format(" r{}", event.robot + 1);
  switch (event.kind) {
    case Event::Kind::perturb:
      return text + fmt::format(" dx={:.6g} dy={:.6g} dtheta={:.6g}", a, b, c);
    case Event::Kind::move:
      return text + fmt::format(" x={:.6g} y={:.6g} theta={:.6g}", a, b, c);
    case Event::Kind::gain:
    case Event::Kind::gain_held:
      return text + fmt::format(" {} {:.6g} -> {:.6g}", name(event.gain), a, b);
    case Event::Kind::deadline_missed:
      return text + fmt::format(" {:.0f}", a);
    case Event::Kind::link:
      return text + fmt::format(" {}", comms::to_text(static_cast<comms::LinkState>(static_cast<int>(a))));
    default:
      return text;
  }
}

std::string describe(const EventList& events) {
  std::string text;
  for (const Event& event : events) text += (text.empty() ? "" : "; ") + describe(event);
  if (events.dropped() > 0) text += fmt::format("; +{} more", events.dropped());
  return text;
}

}  // namespace skein::app
