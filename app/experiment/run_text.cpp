#include "app/experiment/run_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/toml_edit.h"
#include "app/experiment/toml_places.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

/// Whether `happened` is what the action `asked` for does: it says the same, but for what a gain or parameter comes
/// from and how far (18) lets a gain go.
bool does(const Event& asked, const Event& happened) {
  if (const auto* const gain = std::get_if<events::Gain>(&asked)) {
    const auto* const other = std::get_if<events::Gain>(&happened);
    return other && other->gain == gain->gain;
  }
  if (const auto* const gain = std::get_if<events::PairGain>(&asked)) {
    const auto* const other = std::get_if<events::PairGain>(&happened);
    return other && other->gain == gain->gain && other->i == gain->i && other->j == gain->j;
  }
  if (const auto* const parameter = std::get_if<events::Parameter>(&asked)) {
    const auto* const other = std::get_if<events::Parameter>(&happened);
    return other && other->name == parameter->name && other->to == parameter->to;
  }
  return describe(asked) == describe(happened);
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

/// The text of the experiment without those [[operator]] tables whose actions it no longer has.
std::string text_without_dropped_actions(const Experiment& experiment) {
  std::string text = experiment.source;
  const auto document = parsed_toml(text);
  const toml::array* const tables = document ? document->get_as<toml::array>("operator") : nullptr;
  for (std::size_t k = tables ? tables->size() : 0; k-- > 0;) {  // the last one first: the places of the others hold
    const toml::table* const table = tables->get(k)->as_table();
    if (!table || table->is_inline()) continue;
    const auto event = parse_action((*table)["does"].value_or(std::string()));
    const double t = (*table)["t"].value_or(0.0);
    const auto is_this = [&](const OperatorAction& a) { return a.t == t && describe(a.event) == describe(*event); };
    if (!event || std::any_of(experiment.actions.begin(), experiment.actions.end(), is_this)) continue;
    const std::size_t begin = offset_of(text, table->source().begin);
    text.erase(begin, end_of_table(text, *table, false) - begin);
  }
  return text;
}

}  // namespace

ActionsDone::ActionsDone(const Experiment& experiment) : experiment_(experiment), of_file_(experiment.actions) {}

bool ActionsDone::file_does(double t, const Event& event) {
  constexpr double latest = 1.0;  // ticks that were missed [s]
  const auto same = [&](const OperatorAction& a) { return t > a.t - 1e-9 && t < a.t + latest && does(a.event, event); };
  const auto found = std::find_if(of_file_.begin(), of_file_.end(), same);
  if (found == of_file_.end()) return false;
  of_file_.erase(found);
  return true;
}

/// Where robots stood at the start of the run, if that is not where the file has them.
void ActionsDone::note_first_places(const TickRecord& first) {
  constexpr double same_place = 1e-6;  // [m, rad]
  const auto reference = make_reference(experiment_);
  for (std::size_t i = 0; i < first.robots.size(); ++i) {
    const core::Pose& stood = first.robots[i].truth;
    const core::Pose start = experiment_.robots[i].start.value_or(reference->at(i, 0.0).pose);
    const double away = std::max(core::distance(stood, start), std::abs(core::wrap_angle(stood.theta - start.theta)));
    if (experiment_.robots[i].simulated() && away > same_place) done_.push_back({0.0, events::Move{i, stood}});
  }
}

void ActionsDone::note_places(const TickRecord& row) {
  stands_ = !first_ && row.t <= t_;
  if (stands_) return;
  t_ = row.t;
  std::swap(earlier_, places_);
  places_.clear();
  for (const RobotRecord& robot : row.robots) places_.push_back(robot.truth);
}

/// A robot that is moved during a pause stays where it is put. The repeated run does not pause there: the robot still
/// drives to the end of that tick, and is therefore put where that drive begins.
Event ActionsDone::repeatable(const TickRecord& row, const Event& event) const {
  const auto* const move = std::get_if<events::Move>(&event);
  if (!move || !stands_ || earlier_.size() != row.robots.size()) return event;
  const core::Pose &from = earlier_[move->robot], &to = places_[move->robot];
  const double turn = core::wrap_angle(to.theta - from.theta), theta = core::wrap_angle(move->pose.theta - turn);
  const double turned = theta - from.theta, c = core::math::cos(turned), s = core::math::sin(turned);
  const double dx = to.x - from.x, dy = to.y - from.y;
  return events::Move{move->robot, {move->pose.x - (c * dx - s * dy), move->pose.y - (s * dx + c * dy), theta}};
}

void ActionsDone::note(const TickRecord& row) {
  if (row.phase == Phase::staging || row.phase == Phase::ready) return;
  note_places(row);
  if (first_) note_first_places(row);
  for (const Event& event : row.events) {
    const auto* const hold = std::get_if<events::Hold>(&event);
    const bool link_lost = hold && row.events.contains<events::Link>(hold->robot);
    const bool known = first_ && is<events::Move>(event);
    if (is_action(event) && !link_lost && !known && !file_does(row.t, event))
      done_.push_back({row.t, repeatable(row, event)});
  }
  first_ = false;
}

std::string text_as_done(const Experiment& experiment, const std::vector<const TickRecord*>& rows) {
  ActionsDone done(experiment);
  for (const TickRecord* row : rows) done.note(*row);
  std::string text = text_without_dropped_actions(experiment);
  for (const OperatorAction& action : done.all())
    text += fmt::format("\n[[operator]]\nt = {}\ndoes = \"{}\"\n", action.t, describe(action.event));
  return text;
}

tl::expected<std::string, std::string> text_with_gains(std::string text, const core::CouplingGains& gains) {
  for (const core::GainName gain : core::gain_names) {
    const core::PairTable& table = core::table(gains, gain);
    auto changed =
        with_toml_value(text, fmt::format("controller.gains.{}", word(gain)), literal(table, table.robots()));
    if (!changed) return changed;
    text = std::move(*changed);
  }
  return text;
}

}  // namespace skein::app
