#include "app/tick/couplings.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein::app {
namespace {

using core::gain_names;
using core::GainName;
using core::table;

/// An operator's change of a gain takes at least five seconds from nothing to all of the authority there is: Theorem 1
/// wants gains that are continuous, and a hand on a slider is not.
constexpr double operator_ramp = 5.0;

/// Of the events of the tick at which a run starts, so many can tell of pairs that were changed before.
constexpr std::size_t most_pairs_before_start = EventList::capacity - 16;

template <typename Visit>
void for_each_pair(std::size_t robots, Visit&& visit) noexcept {
  for (std::size_t i = 0; i < robots; ++i)
    for (std::size_t j = i + 1; j < robots; ++j) visit(i, j);
}

Event of_pair(Event::Kind kind, std::size_t i, std::size_t j, GainName gain = GainName::k_xx, double from = 0.0,
              double to = 0.0, double seconds = 0.0) noexcept {
  return {kind, static_cast<int>(i), gain, {from, to, seconds}, static_cast<int>(j)};
}

}  // namespace

Couplings::Couplings(const Experiment& experiment, const core::Gains& gains, const core::ReferenceDemand& demand)
    : changes_(experiment.gain_changes),
      file_(experiment.controller.gains),
      limits_(gains),
      demand_(demand),
      schedule_(file_),
      wanted_(file_),
      off_(experiment.robots.size()),
      scratch_(experiment.robots.size()) {
  for (const GainChange& change : changes_)
    for (const GainName name : core::pair_names)
      shapes_change_ = shapes_change_ || (name > gain_names.back() && change[name]);
}

void Couplings::obey(const OperatorCommand& command, bool ready, EventList& events) noexcept {
  using Kind = OperatorCommand::Kind;
  if (command.gain > gain_names.back()) return;  // slopes and weights are the file's
  asked_ = true;
  if (command.kind == Kind::gain) return set_all(command, ready, events);
  const std::size_t n = off_.robots();
  if (command.i == command.j || command.i >= n || command.j >= n) return;
  if (command.kind == Kind::pair_gain) set_pair(command, ready, events);
  if (command.kind == Kind::couple) couple(command, ready, events);
  if (command.kind == Kind::uncouple) uncouple(command, ready, events);
}

double Couplings::rate(GainName name, bool ready) const noexcept {
  if (ready) return std::numeric_limits<double>::infinity();
  const double authority = name == GainName::k_xx ? limits_.v_max[0] : limits_.omega_max[0];
  return authority / static_cast<double>(std::max<std::size_t>(1, off_.robots() - 1)) / operator_ramp;
}

void Couplings::go(GainName name, std::size_t i, std::size_t j, double value, bool ready, double seconds) noexcept {
  const double way = std::abs(value - table(schedule_.now(), name)(i, j)), fastest = rate(name, ready);
  schedule_.move(name, i, j, value, seconds > 0.0 ? std::min(fastest, way / seconds) : fastest);
  if (ready) schedule_.step(1.0);
}

void Couplings::set_all(const OperatorCommand& command, bool ready, EventList& events) noexcept {
  const GainName name = command.gain;
  const double border = command.recorded ? std::numeric_limits<double>::infinity()
                                         : core::gain_border(name, limits_, schedule_.target(), demand_);
  const double value = std::clamp(command.value, 0.0, border);
  const double from = table(wanted_, name).largest();
  if (command.value > border) events.add({Event::Kind::gain_held, -1, name, {command.value, value, 0.0}});
  bool same = true;
  for_each_pair(off_.robots(),
                [&](std::size_t i, std::size_t j) { same = same && table(wanted_, name)(i, j) == value; });
  if (same) return;
  table(wanted_, name).fill(value);
  schedule_.move(name, value, rate(name, ready));
  const double seconds = ready ? 0.0 : command.seconds;
  if (any_off_ || seconds > 0.0) {
    for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) {
      if (!coupled(i, j))
        schedule_.move(name, i, j, 0.0, rate(name, ready));
      else if (seconds > 0.0)
        go(name, i, j, value, ready, seconds);
    });
  }
  if (ready) {
    schedule_.step(1.0);
    all_before_start_[static_cast<std::size_t>(name)] = value;
  }
  events.add({Event::Kind::gain, -1, name, {from, value, seconds}});
}

double Couplings::held(const OperatorCommand& command, GainName name, double value, EventList& events) const noexcept {
  if (command.recorded) return value;
  const double border = core::gain_border(name, command.i, command.j, limits_, schedule_.target(), demand_);
  if (value > border) events.add(of_pair(Event::Kind::pair_gain_held, command.i, command.j, name, value, border));
  return std::min(value, border);
}

void Couplings::set_pair(const OperatorCommand& command, bool ready, EventList& events) noexcept {
  const auto [i, j] = std::minmax(command.i, command.j);
  const double from = table(wanted_, command.gain)(i, j);
  if (ready && from == base(command.gain, i, j) && changed_pairs() >= most_pairs_before_start) {
    events.add(of_pair(Event::Kind::pair_gain_held, i, j, command.gain, command.value, from));
    return;
  }
  const double value = held(command, command.gain, std::max(0.0, command.value), events);
  if (value == from) return;
  table(wanted_, command.gain).set(i, j, value);
  const double seconds = ready ? 0.0 : command.seconds;
  if (coupled(i, j)) go(command.gain, i, j, value, ready, seconds);
  events.add(of_pair(Event::Kind::pair_gain, i, j, command.gain, from, value, seconds));
}

void Couplings::couple(const OperatorCommand& command, bool ready, EventList& events) noexcept {
  const auto [i, j] = std::minmax(command.i, command.j);
  if (coupled(i, j)) return;
  off_.set(i, j, 0.0);
  for (const GainName name : gain_names) {
    const double asked = table(wanted_, name)(i, j), value = held(command, name, asked, events);
    if (value != asked) {
      table(wanted_, name).set(i, j, value);
      events.add(of_pair(Event::Kind::pair_gain, i, j, name, asked, value));
    }
    go(name, i, j, value, ready);
  }
  events.add(of_pair(Event::Kind::couple, i, j));
}

void Couplings::uncouple(const OperatorCommand& command, bool ready, EventList& events) noexcept {
  const auto [i, j] = std::minmax(command.i, command.j);
  if (!coupled(i, j) || (ready && changed_pairs() >= most_pairs_before_start)) return;
  off_.set(i, j, 1.0);
  any_off_ = true;
  for (const GainName name : gain_names) go(name, i, j, 0.0, ready);
  events.add(of_pair(Event::Kind::uncouple, i, j));
}

/// What the pair would have, had the operator changed nothing but gains of all pairs.
double Couplings::base(GainName name, std::size_t i, std::size_t j) const noexcept {
  return all_before_start_[static_cast<std::size_t>(name)].value_or(table(file_, name)(i, j));
}

std::size_t Couplings::changed_pairs() const noexcept {
  std::size_t count = 0;
  for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) {
    count += !coupled(i, j);
    for (const GainName name : gain_names) count += table(wanted_, name)(i, j) != base(name, i, j);
  });
  return count;
}

void Couplings::note_changes_before_start(EventList& events) const noexcept {
  for (const GainName name : gain_names)
    if (const auto& value = all_before_start_[static_cast<std::size_t>(name)])
      events.add({Event::Kind::gain, -1, name, {table(file_, name).largest(), *value, 0.0}});
  for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) {
    for (const GainName name : gain_names)
      if (const double from = base(name, i, j), to = table(wanted_, name)(i, j); from != to)
        events.add(of_pair(Event::Kind::pair_gain, i, j, name, from, to));
    if (!coupled(i, j)) events.add(of_pair(Event::Kind::uncouple, i, j));
  });
}

void Couplings::follow_file(double t, EventList& events) noexcept {
  for (; next_change_ < changes_.size() && t >= changes_[next_change_].t; ++next_change_) {
    const GainChange& change = changes_[next_change_];
    for (const GainName name : core::pair_names) {
      const std::optional<core::PairTable>& target = change[name];
      if (!target) continue;
      events.add(
          {Event::Kind::schedule, -1, name, {table(schedule_.target(), name).largest(), target->largest(), 0.0}});
      table(wanted_, name) = *target;
      if (!any_off_ || name > gain_names.back()) {
        schedule_.ramp(name, *target, change.ramp);
        continue;
      }
      scratch_ = *target;
      for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) {
        if (!coupled(i, j)) scratch_.set(i, j, 0.0);
      });
      schedule_.ramp(name, scratch_, change.ramp);
    }
    if (asked_) hold_file(change, events);
  }
}

void Couplings::hold_file(const GainChange& change, EventList& events) noexcept {
  for (const GainName name : gain_names) {
    if (!change[name]) continue;
    const double share = core::held_share(name, limits_, schedule_.target(), demand_);
    if (share == 1.0) continue;
    const double asked = table(schedule_.target(), name).largest();
    scratch_ = table(schedule_.target(), name);
    for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) {
      scratch_.set(i, j, share * scratch_(i, j));
      if (coupled(i, j)) table(wanted_, name).set(i, j, scratch_(i, j));
    });
    schedule_.ramp(name, scratch_, change.ramp);
    events.add({Event::Kind::gain_held, -1, name, {asked, share * asked, 0.0}});
  }
}

void Couplings::step(double dt, core::Gains& gains) noexcept {
  schedule_.step(dt);
  const core::CouplingGains& now = schedule_.now();
  gains.k_xx = now.k_xx;
  gains.k_tt = now.k_tt;
  gains.k_yy = now.k_yy;
  // Two ramps of different length may ask for more on the way than at either end.
  const double share = asked_ ? core::held_share(GainName::k_yy, limits_, now, demand_) : 1.0;
  if (share < 1.0)
    for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) { gains.k_yy.set(i, j, share * now.k_yy(i, j)); });
  if (!shapes_change_) return;
  gains.c_xx = now.c_xx;
  gains.c_tt = now.c_tt;
  gains.c_yy = now.c_yy;
  gains.l_xx = now.l_xx;
  gains.l_tt = now.l_tt;
}

}  // namespace skein::app
