#include "core/control/gain_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein::core {
namespace {

/// result(i, j) = function(a(i, j), b(i, j), c(i, j)) for all pairs; once for all of them where every pair is the same,
/// so that a uniform table stays one. result may be a, b or c.
template <typename Function>
void for_each_pair(PairTable& result, const PairTable& a, const PairTable& b, const PairTable& c,
                   Function&& function) noexcept {
  if (result.robots() < 2) return;
  if (a.uniform() && b.uniform() && c.uniform()) return result.fill(function(a(0, 1), b(0, 1), c(0, 1)));
  for (std::size_t i = 0; i < result.robots(); ++i)
    for (std::size_t j = i + 1; j < result.robots(); ++j) result.set(i, j, function(a(i, j), b(i, j), c(i, j)));
}

/// The constant rate that leads from `start` to `end` within `seconds`.
double rate_within(double start, double end, double seconds) noexcept {
  return seconds > 0.0 ? std::abs(end - start) / seconds : std::numeric_limits<double>::infinity();
}

double stepped(double value, double target, double rate, double dt) noexcept {
  const double change = target - value;
  const double most = rate * dt;
  return std::abs(change) <= most ? target : value + std::copysign(most, change);
}

}  // namespace

const PairTable& table(const CouplingGains& gains, GainName name) noexcept {
  switch (name) {
    case GainName::k_xx:
      return gains.k_xx;
    case GainName::k_tt:
      return gains.k_tt;
    case GainName::k_yy:
      return gains.k_yy;
    case GainName::c_xx:
      return gains.c_xx;
    case GainName::c_tt:
      return gains.c_tt;
    case GainName::c_yy:
      return gains.c_yy;
    case GainName::l_xx:
      return gains.l_xx;
    case GainName::l_tt:
      break;
  }
  return gains.l_tt;
}

PairTable& table(CouplingGains& gains, GainName name) noexcept {
  return const_cast<PairTable&>(table(static_cast<const CouplingGains&>(gains), name));
}

double row_limit(GainName name, std::size_t i, const Gains& gains, const CouplingGains& couplings,
                 const ReferenceDemand& demand) noexcept {
  switch (name) {
    case GainName::k_xx:
      return free_v(gains, i) - demand.v;
    case GainName::k_tt:
      return free_omega(gains, i) - demand.turning - couplings.k_yy.row_sum(i);
    case GainName::k_yy:
      return free_omega(gains, i) - demand.turning - couplings.k_tt.row_sum(i);
    case GainName::c_xx:
    case GainName::c_tt:
    case GainName::c_yy:
    case GainName::l_xx:
    case GainName::l_tt:
      break;
  }
  return std::numeric_limits<double>::infinity();  // slopes and weights have no part in (18f, g)
}

double gain_limit(GainName name, const Gains& gains, const CouplingGains& others,
                  const ReferenceDemand& demand) noexcept {
  if (gains.robots() < 2) return 0.0;
  const auto partners = static_cast<double>(gains.robots() - 1);
  double limit = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < gains.robots(); ++i) {
    const double left = row_limit(name, i, gains, others, demand);
    limit = std::min(limit, left / partners);
  }
  return std::max(0.0, limit);
}

double gain_limit(GainName name, std::size_t i, std::size_t j, const Gains& gains, const CouplingGains& others,
                  const ReferenceDemand& demand) noexcept {
  const double own = table(others, name)(i, j);
  double limit = std::numeric_limits<double>::infinity();
  for (const std::size_t robot : {i, j}) {
    double taken = 0.0, free = std::numeric_limits<double>::infinity();
    switch (name) {
      case GainName::k_xx:
        taken = others.k_xx.row_sum(robot);
        free = free_v(gains, robot) - demand.v;
        break;
      case GainName::k_tt:
      case GainName::k_yy:
        taken = others.k_tt.row_sum(robot) + others.k_yy.row_sum(robot);
        free = free_omega(gains, robot) - demand.turning;
        break;
      case GainName::c_xx:
      case GainName::c_tt:
      case GainName::c_yy:
      case GainName::l_xx:
      case GainName::l_tt:
        break;  // slopes and weights have no part in (18f, g)
    }
    limit = std::min(limit, free - (taken - own));
  }
  return std::max(0.0, limit);
}

double held_share(GainName name, const Gains& gains, const CouplingGains& couplings,
                  const ReferenceDemand& demand) noexcept {
  constexpr double rounding = 1e-12;
  double share = 1.0;
  for (std::size_t i = 0; i < gains.robots(); ++i) {
    const double taken = table(couplings, name).row_sum(i);
    const double left = row_limit(name, i, gains, couplings, demand);
    if (taken > left + rounding) share = std::min(share, std::max(0.0, left) / taken);
  }
  return share;
}

void GainSchedule::ramp(GainName name, const PairTable& target, double seconds) noexcept {
  const PairTable& from = table(now_, name);
  PairTable& rate = table(rate_, name);
  table(target_, name) = target;
  for_each_pair(rate, from, target, target,
                [seconds](double start, double end, double) { return rate_within(start, end, seconds); });
}

void GainSchedule::move(GainName name, double value, double rate) noexcept {
  table(target_, name).fill(value);
  table(rate_, name).fill(rate);
}

void GainSchedule::move(GainName name, std::size_t i, std::size_t j, double value, double rate) noexcept {
  table(target_, name).set(i, j, value);
  table(rate_, name).set(i, j, rate);
}

void GainSchedule::step(double dt) noexcept {
  if (!(dt > 0.0)) return;  // an instant rate times no time is not a number
  for (const GainName name : pair_names) {
    PairTable& now = table(now_, name);
    for_each_pair(now, now, table(target_, name), table(rate_, name),
                  [dt](double value, double target, double rate) { return stepped(value, target, rate, dt); });
  }
}

void TrackingSchedule::ramp(const TrackingChange& change, double seconds) noexcept {
  for (const TrackingGain name : tracking_names)
    for (std::size_t i = 0; i < change[name].size(); ++i) {
      if (!change[name][i]) continue;
      target_[name][i] = *change[name][i];
      rate_[name][i] = rate_within(now_[name][i], target_[name][i], seconds);
    }
}

void TrackingSchedule::step(double dt) noexcept {
  if (!(dt > 0.0)) return;  // an instant rate times no time is not a number
  for (const TrackingGain name : tracking_names)
    for (std::size_t i = 0; i < now_[name].size(); ++i)
      now_[name][i] = stepped(now_[name][i], target_[name][i], rate_[name][i], dt);
}

}  // namespace skein::core
