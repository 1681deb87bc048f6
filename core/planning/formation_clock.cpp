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
  // Couplings that grow leave less again at the next tick, whose reference this step decides.
  const double less = std::max(0.0, left_ - hurry);
  left_ = hurry;
  hurry = std::max(0.0, hurry - 2.0 * less);
  const bool enough = hurry >= least_hurry, was_away = waits_;
  if (away && !waits_ && enough && now.behind < most_behind) {
    waits_ = true;
    until_ = t + longest_wait;
  } else if (!away) {
    waits_ = false;
  }
  const bool waiting = waits_ && t < until_;
  // What is left of a delay that is about to end is made up within its last slope.
  const bool ends = !waiting && now.behind <= 0.5 * now.falls * now.falls / slope;
  const bool changed = waits_ != was_away || (now.behind > 0.0 && !ends && (hurry < hurry_ || (stays_ && enough)));
  if (!changed) return;
  stays_ = !enough;
  hurry_ = enough ? hurry : 0.0;
  constexpr double for_ever = 1e6, hardly = 1e-9;  // until there is room again [s], and how fast it then catches up
  if (waiting)
    delay_ = Delay(now, 1.0 - slowly, until_ - t, enough ? hurry : hardly, slope);
  else if (stays_)
    delay_ = Delay(now, 0.0, for_ever, least_hurry, slope);
  else
    delay_ = Delay(now, now.falls, 0.0, hurry, slope);
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
