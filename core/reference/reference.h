#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/control/gain_schedule.h"
#include "core/control/tracking_error.h"
#include "core/reference/path.h"

namespace skein::core {

/// The pose and velocities that every robot should have (2, 3), at any time. Velocities are derived from the motion
/// itself, not from differences of poses, so that heading and turning rate are known through a stop.
class Reference {
 public:
  virtual ~Reference() = default;
  virtual std::size_t robots() const noexcept = 0;
  /// The reference of robot i (from 0) at time t. [s]
  virtual ReferencePoint at(std::size_t i, double t) const noexcept = 0;
  /// Its largest velocities over the whole course, or slightly more, with the law's k_y [rad/m].
  virtual ReferenceDemand demand(double k_y) const noexcept = 0;
  /// Whether every omega_ref is continuous.
  virtual bool smooth() const noexcept = 0;
  /// Its paths as lines to draw and to check: one for all robots, or one for each.
  virtual std::vector<std::vector<Pose>> lines() const = 0;

  /// All robots' references.
  virtual void at(double t, std::span<ReferencePoint> points) const noexcept {
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = at(i, t);
  }
};

}  // namespace skein::core
