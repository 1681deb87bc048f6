#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "core/reference/reference.h"
#include "core/reference/travel.h"

namespace skein::core {

/// The reference of one robot.
class Trajectory {
 public:
  virtual ~Trajectory() = default;
  virtual ReferencePoint at(double t) const noexcept = 0;  ///< t [s]
  /// Its largest velocities over the whole course, or slightly more, with the law's k_y [rad/m].
  virtual ReferenceDemand demand(double k_y) const noexcept = 0;
  virtual bool smooth() const noexcept = 0;  ///< whether omega_ref is continuous
  /// From when on it rests; infinite if it never does. [s]
  virtual double end() const noexcept = 0;
  virtual std::vector<Pose> line() const = 0;
};

/// Along a closed path for ever, at constant speed.
class Rounds final : public Trajectory {
 public:
  /// Requires a closed path. speed [m/s]; `start`: arc length at t = 0 [m].
  Rounds(std::shared_ptr<const Path> path, double speed, double start) noexcept
      : path_(std::move(path)), speed_(speed), start_(start) {}
  ReferencePoint at(double t) const noexcept override;
  ReferenceDemand demand(double k_y) const noexcept override;
  bool smooth() const noexcept override { return path_->smooth(); }
  double end() const noexcept override { return speed_ > 0.0 ? std::numeric_limits<double>::infinity() : 0.0; }
  std::vector<Pose> line() const override { return sampled(*path_, line_parts); }

 private:
  std::shared_ptr<const Path> path_;
  double speed_, start_;
};

/// A drive along a path from rest to rest, then, if requested, turning on the spot for ever. Position, heading, v_ref
/// and its derivative are continuous; omega_ref is as continuous as the path's curvature. Heading and curvature are
/// known at rest, since the path is one by arc length.
class Drive final : public Trajectory {
 public:
  /// Sets off at time t0 [s] from arc length `start` [m]; `turn_rate`: after the arrival [rad/s].
  Drive(std::shared_ptr<const Path> path, double start, double t0, const Travel& travel, double turn_rate) noexcept;
  ReferencePoint at(double t) const noexcept override;
  ReferenceDemand demand(double k_y) const noexcept override;
  bool smooth() const noexcept override { return path_->smooth(); }
  double end() const noexcept override;
  std::vector<Pose> line() const override;

 private:
  std::shared_ptr<const Path> path_;
  double start_, t0_;
  Travel travel_;
  SmoothStep turn_;
};

/// Every robot on a trajectory of its own.
class Independent final : public Reference {
 public:
  explicit Independent(std::vector<std::unique_ptr<const Trajectory>> trajectories) noexcept
      : trajectories_(std::move(trajectories)) {}

  std::size_t robots() const noexcept override { return trajectories_.size(); }
  const Trajectory& trajectory(std::size_t i) const noexcept { return *trajectories_[i]; }

  using Reference::at;
  ReferencePoint at(std::size_t i, double t) const noexcept override { return trajectories_[i]->at(t); }
  ReferenceDemand demand(double k_y) const noexcept override;
  bool smooth() const noexcept override;
  std::vector<std::vector<Pose>> lines() const override;

 private:
  std::vector<std::unique_ptr<const Trajectory>> trajectories_;
};

}  // namespace skein::core
