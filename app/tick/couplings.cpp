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

double largest(const std::vector<double>& values) noexcept {
  return *std::max_element(values.begin(), values.end());
}

template <typename Visit>
void for_each_pair(std::size_t robots, Visit&& visit) noexcept {
  for (std::size_t i = 0; i < robots; ++i)
    for (std::size_t j = i + 1; j < robots; ++j) visit(i, j);
}

}  // namespace

Couplings::Couplings(const Experiment& experiment, const core::Gains& gains, const core::ReferenceDemand& demand)
    : changes_(experiment.gain_changes),
      file_(experiment.controller.gains),
      limits_(gains),
      file_limits_(gains),
      demand_(demand),
      schedule_(file_),
      tracking_(make_tracking(experiment)),
      wanted_(file_),
      off_(experiment.robots.size()),
      scratch_(experiment.robots.size()) {
  for (const GainChange& change : changes_) {
    for (const GainName name : core::pair_names)
      shapes_change_ = shapes_change_ || (name > gain_names.back() && change[name]);
    for (const core::TrackingGain name : core::tracking_names)
      tracking_changes_ = tracking_changes_ || !change.tracking[name].empty();
  }
}

/// Slopes and weights are the file's, and only different robots are a pair.
bool Couplings::is_pair(std::size_t i, std::size_t j) const noexcept {
  return i != j && i < off_.robots() && j < off_.robots();
}

double Couplings::rate(GainName name, bool ready) const noexcept {
  if (ready) return std::numeric_limits<double>::infinity();
  double authority = std::numeric_limits<double>::infinity();
  switch (name) {
    case GainName::k_xx:
      authority = limits_.v_max[0];
      break;
    case GainName::k_tt:
    case GainName::k_yy:
      authority = limits_.omega_max[0];
      break;
    case GainName::c_xx:
    case GainName::c_tt:
    case GainName::c_yy:
    case GainName::l_xx:
    case GainName::l_tt:
      break;  // the file's ramps alone move them
  }
  return authority / static_cast<double>(std::max<std::size_t>(1, off_.robots() - 1)) / operator_ramp;
}

void Couplings::go(GainName name, std::size_t i, std::size_t j, double value, bool ready, double seconds) noexcept {
  const double way = std::abs(value - table(schedule_.now(), name)(i, j)), fastest = rate(name, ready);
  schedule_.move(name, i, j, value, seconds > 0.0 ? std::min(fastest, way / seconds) : fastest);
  if (ready) schedule_.step(1.0);
}

void Couplings::finish_ramps() noexcept {
  constexpr double longest = 1e6;  // [s]
  schedule_.step(longest);
}

void Couplings::set(const commands::SetGain& command, bool ready, bool recorded, EventList& events) noexcept {
  const GainName name = command.gain;
  if (name > gain_names.back()) return;  // slopes and weights are the file's
  asked_ = true;
  const double limit =
      recorded ? std::numeric_limits<double>::infinity() : core::gain_limit(name, limits_, schedule_.target(), demand_);
  const double value = std::clamp(command.value, 0.0, limit);
  const double from = table(wanted_, name).largest();
  if (command.value > limit) events.add(events::GainHeld{name, command.value, value});
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
  events.add(events::Gain{name, from, value, seconds});
}

double Couplings::held(const commands::SetPairGain& asked, bool recorded, EventList& events) const noexcept {
  const auto& [i, j, name, value, seconds] = asked;
  if (recorded) return value;
  const double limit = core::gain_limit(name, i, j, limits_, schedule_.target(), demand_);
  if (value > limit) events.add(events::PairGainHeld{i, j, name, value, limit});
  return std::min(value, limit);
}

void Couplings::set(const commands::SetPairGain& command, bool ready, bool recorded, EventList& events) noexcept {
  const GainName name = command.gain;
  if (name > gain_names.back() || !is_pair(command.i, command.j)) return;
  asked_ = true;
  const auto [i, j] = std::minmax(command.i, command.j);
  const double from = table(wanted_, name)(i, j);
  const double value = held({i, j, name, std::max(0.0, command.value)}, recorded, events);
  if (value == from) return;
  table(wanted_, name).set(i, j, value);
  const double seconds = ready ? 0.0 : command.seconds;
  if (coupled(i, j)) go(name, i, j, value, ready, seconds);
  events.add(events::PairGain{i, j, name, from, value, seconds});
}

void Couplings::couple(const commands::Couple& command, bool ready, bool recorded, EventList& events) noexcept {
  if (!is_pair(command.i, command.j)) return;
  asked_ = true;
  const auto [i, j] = std::minmax(command.i, command.j);
  if (coupled(i, j) == command.on) return;
  if (command.on)
    switch_on(i, j, ready, recorded, events);
  else
    switch_off(i, j, ready, events);
}

void Couplings::switch_on(std::size_t i, std::size_t j, bool ready, bool recorded, EventList& events) noexcept {
  off_.set(i, j, 0.0);
  for (const GainName name : gain_names) {
    const double asked = table(wanted_, name)(i, j), value = held({i, j, name, asked}, recorded, events);
    if (value != asked) {
      table(wanted_, name).set(i, j, value);
      events.add(events::PairGain{i, j, name, asked, value});
    }
    go(name, i, j, value, ready);
  }
  events.add(events::Couple{i, j});
}

void Couplings::switch_off(std::size_t i, std::size_t j, bool ready, EventList& events) noexcept {
  off_.set(i, j, 1.0);
  any_off_ = true;
  for (const GainName name : gain_names) go(name, i, j, 0.0, ready);
  events.add(events::Uncouple{i, j});
}

/// What the pair would have, had the operator changed nothing but gains of all pairs.
double Couplings::base(GainName name, std::size_t i, std::size_t j) const noexcept {
  return all_before_start_[static_cast<std::size_t>(name)].value_or(table(file_, name)(i, j));
}

void Couplings::note_changes_before_start(EventList& events) const noexcept {
  for (const GainName name : gain_names)
    if (const auto& value = all_before_start_[static_cast<std::size_t>(name)])
      events.add(events::Gain{name, table(file_, name).largest(), *value});
  for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) {
    for (const GainName name : gain_names)
      if (const double from = base(name, i, j), to = table(wanted_, name)(i, j); from != to)
        events.add(events::PairGain{i, j, name, from, to});
    if (!coupled(i, j)) events.add(events::Uncouple{i, j});
  });
}

void Couplings::follow_file(double t, EventList& events) noexcept {
  for (; next_change_ < changes_.size() && t >= changes_[next_change_].t; ++next_change_) {
    const GainChange& change = changes_[next_change_];
    for (const GainName name : core::pair_names) {
      const std::optional<core::PairTable>& target = change[name];
      if (!target) continue;
      events.add(events::Schedule{name, table(schedule_.target(), name).largest(), target->largest()});
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
    follow_tracking(change, events);
    if (asked_) hold_file(change, events);
  }
}

void Couplings::follow_tracking(const GainChange& change, EventList& events) noexcept {
  std::array<double, core::tracking_names.size()> before{};
  for (const core::TrackingGain name : core::tracking_names)
    before[static_cast<std::size_t>(name)] = largest(tracking_.target()[name]);
  tracking_.ramp(change.tracking, change.ramp);
  for (const core::TrackingGain name : core::tracking_names)
    if (!change.tracking[name].empty())
      events.add(
          events::ScheduleTracking{name, before[static_cast<std::size_t>(name)], largest(tracking_.target()[name])});
}

void Couplings::reserve_for_file(const core::TrackingGains& tracking) noexcept {
  if (!tracking_changes_) return;
  const auto copy = [](const std::vector<double>& from, std::vector<double>& to) {
    std::copy(from.begin(), from.end(), to.begin());
  };
  copy(tracking[core::TrackingGain::k_x], file_limits_.k_x_reserved);
  copy(tracking[core::TrackingGain::k_theta], file_limits_.k_theta_reserved);
}

void Couplings::hold_file(const GainChange& change, EventList& events) noexcept {
  reserve_for_file(tracking_.target());
  for (const GainName name : gain_names) {
    if (!change[name]) continue;
    const double share = core::held_share(name, file_limits_, schedule_.target(), demand_);
    if (share == 1.0) continue;
    const double asked = table(schedule_.target(), name).largest();
    scratch_ = table(schedule_.target(), name);
    for_each_pair(off_.robots(), [&](std::size_t i, std::size_t j) {
      scratch_.set(i, j, share * scratch_(i, j));
      if (coupled(i, j)) table(wanted_, name).set(i, j, scratch_(i, j));
    });
    schedule_.ramp(name, scratch_, change.ramp);
    events.add(events::GainHeld{name, asked, share * asked});
  }
}

void Couplings::step(double dt, core::Gains& gains) noexcept {
  schedule_.step(dt);
  if (tracking_changes_) {
    tracking_.step(dt);
    reserve_for_file(tracking_.now());
    gains.k_x = tracking_.now()[core::TrackingGain::k_x];  // of the same size: nothing is allocated
    gains.k_theta = tracking_.now()[core::TrackingGain::k_theta];
  }
  const core::CouplingGains& now = schedule_.now();
  gains.k_xx = now.k_xx;
  gains.k_tt = now.k_tt;
  gains.k_yy = now.k_yy;
  // Two ramps of different length may ask for more on the way than at either end.
  const double share = asked_ ? core::held_share(GainName::k_yy, file_limits_, now, demand_) : 1.0;
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
