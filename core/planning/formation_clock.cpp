#include "core/planning/formation_clock.h"

#include <algorithm>
#include <limits>

#include "core/avoidance/steering.h"

namespace skein::core {

double FormationClock::hurry(const Gains& gains, const ReferenceDemand& demand) noexcept {
  constexpr double share = 0.7;
  if (!(demand.v > 0.0) || !(demand.turning > 0.0)) return 0.0;
  double room = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < gains.v_max.size(); ++i) {
    const ReferenceBounds bounds = reference_bounds(gains, i);
    room = std::min({room, bounds.v / demand.v, bounds.omega / demand.turning});
  }
  return std::max(0.0, share * (room - 1.0));
}

void FormationClock::step(double t, bool away, double hurry, double slope) noexcept {
  const Delay::Moment now{t, behind(t), 1.0 - rate(t)};
  if (away && !waits_ && hurry >= least_hurry && now.behind < most_behind) {
    waits_ = true;
    delay_ = Delay(now, 1.0 - slowly, longest_wait, hurry_ = hurry, slope);
  } else if (!away && waits_) {
    waits_ = false;
    delay_ = Delay(now, now.falls, 0.0, hurry_ = hurry, slope);
  } else if (!waits_ && now.behind > 0.0 && hurry < hurry_ && hurry >= least_hurry) {  // couplings have grown
    delay_ = Delay(now, now.falls, 0.0, hurry_ = hurry, slope);
  }
}

ReferencePoint WaitingReference::at(std::size_t i, double t) const noexcept {
  const double behind = clock_->behind(t);
  if (behind == 0.0 && clock_->rate(t) == 1.0) return on_time_->at(i, t);
  ReferencePoint point = on_time_->at(i, t - behind);
  const double rate = clock_->rate(t);
  point.twist = {rate * point.twist.v, rate * point.twist.omega};
  return point;
}

}  // namespace skein::core
