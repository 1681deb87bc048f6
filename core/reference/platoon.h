#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "core/control/gain_schedule.h"
#include "core/control/tracking_error.h"
#include "core/reference/path.h"

namespace skein::core {

/// All robots on one path, each `spacing` of arc length behind the next, at one constant speed: the formation of
/// section V.
class Platoon {
 public:
  /// spacing [m], speed [m/s]; `start` is the arc length at which robot 1 begins [m].
  Platoon(std::shared_ptr<const Path> path, std::size_t robots, double spacing, double speed, double start) noexcept
      : path_(std::move(path)), robots_(robots), spacing_(spacing), speed_(speed), start_(start) {}

  std::size_t robots() const noexcept { return robots_; }
  const Path& path() const noexcept { return *path_; }

  /// The reference of robot i (from 0) at time t; velocities from the path's own curvature, so that (3) needs no
  /// division.
  ReferencePoint at(std::size_t i, double t) const noexcept;
  /// The same for all robots.
  void at(double t, std::span<ReferencePoint> points) const noexcept;

  /// The most that it asks for over its whole course, beside the law's k_y [rad/m].
  ReferenceDemand demand(double k_y) const noexcept;

 private:
  std::shared_ptr<const Path> path_;
  std::size_t robots_;
  double spacing_, speed_, start_;
};

}  // namespace skein::core
