#include "app/run/event.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "comms/link_status.h"

namespace skein::app {
namespace {

using Kind = Event::Kind;

constexpr std::array<std::pair<Kind, std::string_view>, 29> words{{{Kind::start, "start"},
                                                                   {Kind::pause, "pause"},
                                                                   {Kind::resume, "resume"},
                                                                   {Kind::stop, "stop"},
                                                                   {Kind::perturb, "perturb"},
                                                                   {Kind::kidnap, "kidnap"},
                                                                   {Kind::move, "move"},
                                                                   {Kind::hold, "hold"},
                                                                   {Kind::release, "release"},
                                                                   {Kind::kick, "kick"},
                                                                   {Kind::obstacle, "obstacle"},
                                                                   {Kind::gain, "gain"},
                                                                   {Kind::schedule, "schedule"},
                                                                   {Kind::gain_held, "gain_held"},
                                                                   {Kind::pair_gain, "pair_gain"},
                                                                   {Kind::pair_gain_held, "pair_gain_held"},
                                                                   {Kind::couple, "couple"},
                                                                   {Kind::uncouple, "uncouple"},

                                                                   {Kind::lost, "lost"},
                                                                   {Kind::found, "found"},
                                                                   {Kind::avoid, "avoid"},
                                                                   {Kind::clear, "clear"},
                                                                   {Kind::stage, "stage"},
                                                                   {Kind::staged, "staged"},
                                                                   {Kind::deadlock, "deadlock"},
                                                                   {Kind::deadline_missed, "deadline_missed"},
                                                                   {Kind::v_rise, "v_rise"},
                                                                   {Kind::link, "link"},
                                                                   {Kind::film_broken, "film_broken"}}};

std::string_view link_word(double state) {
  return comms::to_text(static_cast<comms::LinkState>(static_cast<int>(state)));
}

template <typename Number>
bool read(std::string_view text, Number& value) {
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && stop == text.data() + text.size();
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// What stands behind word and robot: numbers, bare or as name=number; the name of a gain; a link's state.
bool read_detail(std::string_view text, Event& event, std::size_t& values) {
  for (const core::GainName gain : core::pair_names)
    if (text == name(gain)) {
      event.gain = gain;
      return true;
    }
  if (event.kind == Kind::link)
    if (const auto state = comms::link_state(text)) {
      event.values[0] = static_cast<double>(*state);
      return true;
    }
  if (text == "->") return true;
  const std::size_t equals = text.find('=');
  if (equals != std::string_view::npos) text.remove_prefix(equals + 1);
  return values < event.values.size() && read(text, event.values[values++]);
}

}  // namespace

const char* name(core::GainName gain) noexcept {
  constexpr std::array names{"k_xx", "k_tt", "k_yy", "c_xx", "c_tt", "c_yy", "l_xx", "l_tt"};
  return names[static_cast<std::size_t>(gain)];
}

std::string describe(const Event& event) {
  const auto [a, b, c] = event.values;
  const auto word = std::find_if(words.begin(), words.end(), [&](const auto& w) { return w.first == event.kind; });
  std::string text(word->second);
  const char letter = event.kind == Kind::obstacle ? 'o' : 'r';
  for (const int number : {event.robot, event.other})
    if (number >= 0) text += fmt::format(" {}{}", letter, number + 1);
  switch (event.kind) {
    case Kind::perturb:
    case Kind::kidnap:
      return text + fmt::format(" dx={} dy={} dtheta={}", a, b, c);
    case Kind::move:
      return text + fmt::format(" x={} y={} theta={}", a, b, c);
    case Kind::kick:
      return text + fmt::format(" vx={} vy={}", a, b);
    case Kind::obstacle:
      return text + fmt::format(" x={} y={} radius={}", a, b, c);
    case Kind::gain:
    case Kind::pair_gain:
      return text + fmt::format(" {} {} -> {}", name(event.gain), a, b) + (c > 0.0 ? fmt::format(" ramp={}", c) : "");
    case Kind::schedule:
    case Kind::gain_held:
    case Kind::pair_gain_held:
      return text + fmt::format(" {} {} -> {}", name(event.gain), a, b);
    case Kind::deadline_missed:
    case Kind::v_rise:
      return text + fmt::format(" {}", a);
    case Kind::link:
      return text + fmt::format(" {}", link_word(a));
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

std::optional<Event> parse_event(std::string_view text) {
  const std::vector<std::string_view> parts = split(text);
  const auto word = std::find_if(words.begin(), words.end(),
                                 [&](const auto& w) { return !parts.empty() && w.second == parts.front(); });
  if (word == words.end()) return std::nullopt;
  Event event;
  event.kind = word->first;
  std::size_t values = 0;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    int robot = 0;
    if (i <= 2 && parts[i].starts_with(event.kind == Kind::obstacle ? 'o' : 'r') && read(parts[i].substr(1), robot))
      (i == 1 ? event.robot : event.other) = robot - 1;
    else if (!read_detail(parts[i], event, values))
      return std::nullopt;
  }
  return event;
}

bool is_action(Kind kind) noexcept {
  switch (kind) {
    case Kind::move:
    case Kind::hold:
    case Kind::release:
    case Kind::kick:
    case Kind::obstacle:
    case Kind::gain:
    case Kind::pair_gain:
    case Kind::couple:
    case Kind::uncouple:
      return true;
    default:
      return false;
  }
}

std::optional<Event> parse_action(std::string_view text) {
  const std::optional<Event> event = parse_event(text);
  if (!event || !is_action(event->kind)) return std::nullopt;
  // Written again it has the same words, but for how its numbers are written.
  const std::string again = describe(*event);
  const std::vector<std::string_view> parts = split(text), expected = split(again);
  if (parts.size() != expected.size()) return std::nullopt;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    double number = 0.0;
    const std::size_t equals = expected[i].find('=');
    const bool same = equals != std::string_view::npos
                          ? parts[i].substr(0, equals + 1) == expected[i].substr(0, equals + 1)
                      : read(expected[i], number) ? read(parts[i], number)
                                                  : parts[i] == expected[i];
    if (!same) return std::nullopt;
  }
  const bool finite =
      std::all_of(event->values.begin(), event->values.end(), [](double v) { return std::isfinite(v); });
  return finite ? event : std::nullopt;
}

}  // namespace skein::app
