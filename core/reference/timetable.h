#pragma once

#include <vector>

#include "core/reference/curve.h"
#include "core/reference/trajectory.h"

namespace skein::core {

/// The required position of a robot at one time. [s, m]
struct TimedPoint {
  double t = 0.0;
  Point place;
};

/// A trajectory through places at given times, from rest to rest: the cubic spline over time, so that velocities and
/// accelerations are continuous, with zero velocity at both ends. The heading is the direction of motion; at rest, the
/// direction of the next or the last motion.
class Timetable final : public Trajectory {
 public:
  /// Requires at least 2 points, their times increasing, no two neighbours at the same place.
  explicit Timetable(const std::vector<TimedPoint>& points);
  ReferencePoint at(double t) const noexcept override;
  /// The largest of many samples plus a hundredth.
  ReferenceDemand demand(double k_y) const noexcept override;
  bool smooth() const noexcept override { return true; }
  double end() const noexcept override { return times_.back(); }
  std::vector<Pose> line() const override;

 private:
  /// p(w) = a + b w + c w^2 + d w^3, w seconds after the piece begins.
  struct Piece {
    Point a, b, c, d;
  };
  std::vector<double> times_;
  std::vector<Piece> pieces_;
};

}  // namespace skein::core
