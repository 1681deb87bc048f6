#pragma once

#include <memory>

#include "core/reference/reference.h"

namespace skein::core {

/// All robots on one path, each `spacing` of arc length behind the next, at one constant speed: the formation of
/// section V.
class Platoon final : public Reference {
 public:
  /// spacing [m], speed [m/s]; `start` is the arc length at which robot 1 begins [m].
  Platoon(std::shared_ptr<const Path> path, std::size_t robots, double spacing, double speed, double start) noexcept
      : path_(std::move(path)), robots_(robots), spacing_(spacing), speed_(speed), start_(start) {}

  std::size_t robots() const noexcept override { return robots_; }
  bool smooth() const noexcept override { return path_->smooth(); }
  std::vector<std::vector<Pose>> lines() const override { return {sampled(*path_, line_parts)}; }

  using Reference::at;
  /// Velocities from the path's own curvature, so that (3) needs no division.
  ReferencePoint at(std::size_t i, double t) const noexcept override;
  ReferenceDemand demand(double k_y) const noexcept override;

 private:
  std::shared_ptr<const Path> path_;
  std::size_t robots_;
  double spacing_, speed_, start_;
};

}  // namespace skein::core
