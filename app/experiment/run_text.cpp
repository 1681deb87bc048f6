#include "app/experiment/run_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/toml_edit.h"

namespace skein::app {
namespace {

bool is_gain(Event::Kind kind) {
  return kind == Event::Kind::gain || kind == Event::Kind::pair_gain;
}

/// The actions of the file itself, each of which explains one event.
class FileActions {
 public:
  explicit FileActions(const std::vector<OperatorAction>& actions) : left_(actions) {}

  bool explain(double t, const Event& event) {
    constexpr double latest = 1.0;  // ticks that were missed [s]
    const auto same = [&](const OperatorAction& a) {
      const Event& of = a.event;
      return t > a.t - 1e-9 && t < a.t + latest && of.kind == event.kind && of.robot == event.robot &&
             of.other == event.other && of.gain == event.gain && (is_gain(of.kind) || of.values == event.values);
    };
    const auto found = std::find_if(left_.begin(), left_.end(), same);
    if (found == left_.end()) return false;
    left_.erase(found);
    return true;
  }

 private:
  std::vector<OperatorAction> left_;
};

std::string table_of(double t, const Event& event) {
  return fmt::format("\n[[operator]]\nt = {}\ndoes = \"{}\"\n", t, describe(event));
}

/// Where robots stood at the start of the run, if that is not where the file has them.
std::string first_moves(const Experiment& experiment, const TickRecord& first) {
  constexpr double same_place = 1e-6;  // [m, rad]
  std::string text;
  const auto reference = make_reference(experiment);
  for (std::size_t i = 0; i < first.robots.size(); ++i) {
    const core::Pose& stood = first.robots[i].truth;
    const core::Pose start = experiment.robots[i].start.value_or(reference->at(i, 0.0).pose);
    const double away = std::max(core::distance(stood, start), std::abs(core::wrap_angle(stood.theta - start.theta)));
    if (experiment.robots[i].simulated() && away > same_place)
      text += table_of(0.0, {Event::Kind::move, static_cast<int>(i), {}, {stood.x, stood.y, stood.theta}});
  }
  return text;
}

std::string literal(const core::PairTable& table, std::size_t robots) {
  std::string pairs;
  bool same = true;
  for (std::size_t i = 0; i < robots; ++i)
    for (std::size_t j = i + 1; j < robots; ++j) {
      same = same && table(i, j) == table.largest();
      pairs += fmt::format("{}[{}, {}, {}]", pairs.empty() ? "" : ", ", i + 1, j + 1, table(i, j));
    }
  return same ? fmt::format("{}", table.largest()) : "[" + pairs + "]";
}

}  // namespace

std::string text_as_done(const Experiment& experiment, const std::vector<const TickRecord*>& rows) {
  std::string text = experiment.source;
  FileActions file(experiment.actions);
  bool first = true;
  for (const TickRecord* row : rows) {
    if (row->phase == Phase::staging || row->phase == Phase::ready) continue;
    if (first) text += first_moves(experiment, *row);
    for (const Event& event : row->events) {
      const bool link_lost = event.kind == Event::Kind::hold && row->events.contains(Event::Kind::link, event.robot);
      const bool known = first && event.kind == Event::Kind::move;
      if (is_action(event.kind) && !link_lost && !known && !file.explain(row->t, event))
        text += table_of(row->t, event);
    }
    first = false;
  }
  return text;
}

tl::expected<std::string, std::string> text_with_gains(std::string text, const core::CouplingGains& gains) {
  for (const core::GainName gain : core::gain_names) {
    const core::PairTable& table = core::table(gains, gain);
    auto changed =
        with_toml_value(text, fmt::format("controller.gains.{}", name(gain)), literal(table, table.robots()));
    if (!changed) return changed;
    text = std::move(*changed);
  }
  return text;
}

}  // namespace skein::app
