#include "core/control/descent_watch.h"

#include <algorithm>
#include <cmath>

#include "core/control/lyapunov.h"
#include "core/kinematics/unicycle.h"

namespace skein::core {

double DescentWatch::step(const Gains& gains, std::span<const Pose> poses, std::span<const ReferencePoint> references,
                          std::span<const TrackingError> errors, double dt) noexcept {
  const double now = lyapunov(gains, errors), before = last_;
  last_ = now;
  const bool known = knows_;
  knows_ = true;
  if (!known) return 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool counts = !std::isnan(poses[i].x) && !std::isnan(poses_[i].x);
    expected_[i] = counts ? tracking_error(references[i].pose, advance(poses_[i], twists_[i], dt)) : TrackingError{};
  }
  sum_ = std::max(0.0, sum_ + now - std::max(before, lyapunov(gains, expected_)));
  if (sum_ <= tolerance_) return 0.0;
  const double risen = sum_;
  sum_ = 0.0;
  return risen;
}

}  // namespace skein::core
