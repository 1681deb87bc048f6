#pragma once

#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "app/experiment/experiment.h"

namespace skein::app {

/// The floor with the simulated robots of an experiment (those behind an emulated e-puck included). Shared by the
/// control thread, the camera's and the emulator's: every call is short and holds the one mutex. Robots that are not
/// simulated have no pose (NaN) and ignore everything.
class SimulatedWorld {
 public:
  explicit SimulatedWorld(const Experiment& experiment);

  /// Copies the present state of `other`, the floor of the same experiment.
  void go_on_from(const SimulatedWorld& other);

  /// Advances all robots to `now` [s]. Times in the past change nothing.
  void advance(double now);
  /// Wheel speeds as commanded [steps/s], from now on.
  void command(std::size_t robot, const core::WheelSpeeds& wheels);
  /// The command of an emulated robot's firmware to its motors at time `now` [steps/s].
  void turn(std::size_t robot, double now, const core::WheelSpeeds& commanded);
  void stop();

  void place(std::size_t robot, const core::Pose& pose);
  void kick(std::size_t robot, double vx, double vy);
  core::Pose pose(std::size_t robot) const;
  void poses(std::span<core::Pose> all) const;
  /// From now on poses_at() reaches this far back; it already covers the experiment's largest camera.stamps_late. [s]
  void remember_for(double seconds);
  /// Where they were at a time in the past.
  void poses_at(double t, std::span<core::Pose> all) const;
  core::Measurement measure(std::size_t robot, double now);

 private:
  void advance_locked(double now);
  void run_away(double now);
  void remember();

  mutable std::mutex mutex_;
  std::vector<core::SimulatedRobot> robots_;
  std::vector<bool> simulated_;
  struct Runaway {
    double at;  // [s]
    std::size_t robot;
    std::optional<core::WheelSpeeds> speeds;
  };
  std::vector<Runaway> runaways_;  // still to come
  double now_ = 0.0;
  struct Moment {
    double t;  // [s]
    std::vector<core::Pose> poses;
  };
  double memory_ = 0.0;      // how far back [s]
  std::deque<Moment> past_;  // up to now; empty: nothing is to be remembered
};

}  // namespace skein::app
