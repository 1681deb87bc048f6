#pragma once

#include <memory>
#include <vector>

#include "core/reference/reference.h"

namespace skein::core {

/// From time t on, the spacing of a platoon becomes another one within `duration`, smoothly. [s, m]
struct SpacingChange {
  double t = 0.0;
  double duration = 0.0;
  double spacing = 0.0;
};

/// All robots on one path, each `spacing` of arc length behind the next, robot 1 at one constant speed: the formation
/// of section V. While the spacing changes, those behind drive slower or faster than robot 1.
class Platoon final : public Reference {
 public:
  /// spacing [m], speed [m/s]; `start` is the arc length at which robot 1 begins [m]. `changes` in order of time, each
  /// ending before the next begins.
  Platoon(std::shared_ptr<const Path> path, std::size_t robots, double spacing, double speed, double start,
          std::vector<SpacingChange> changes = {}) noexcept
      : path_(std::move(path)),
        robots_(robots),
        spacing_(spacing),
        speed_(speed),
        start_(start),
        changes_(std::move(changes)) {}

  std::size_t robots() const noexcept override { return robots_; }
  bool smooth() const noexcept override { return path_->smooth(); }
  std::vector<std::vector<Pose>> lines() const override { return {sampled(*path_, line_parts)}; }

  using Reference::at;
  /// Velocities from the path's own curvature, so that (3) needs no division.
  ReferencePoint at(std::size_t i, double t) const noexcept override;
  ReferenceDemand demand(double k_y) const noexcept override;

 private:
  /// The spacing at a time, and how fast it grows. [m, m/s]
  struct Gap {
    double spacing, rate;
  };
  Gap gap(double t) const noexcept;

  std::shared_ptr<const Path> path_;
  std::size_t robots_;
  double spacing_, speed_, start_;
  std::vector<SpacingChange> changes_;
};

}  // namespace skein::core
