#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/estimation/measurement.h"
#include "core/estimation/pose_filter.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// What the tags of all robots did at once.
struct CommonMotion {
  std::size_t tags = 0;   ///< that took part: all that were seen
  double distance = 0.0;  ///< by which they moved, their mean [m]
  double turn = 0.0;      ///< counter-clockwise [rad]
};

/// Tells a bumped camera from carried robots: after a bump every tag stands elsewhere by one and the same rigid motion
/// of the plane, which the commanded motion does not explain. The motion must be there in two sights of each tag, since
/// a torn frame shows the same for once. Tags that a bump has hidden may come back one after the other, within 2 s.
/// A motion that stays below the robots' own way and 6 mm from frame to frame is not seen, and of a single tag nobody
/// can know whether the robot or the camera was moved. Allocates in its constructor alone.
class CameraWatch {
 public:
  static constexpr double lever = 0.1;  ///< a turn counts as the way of a point so far out [m]

  explicit CameraWatch(std::size_t robots) : robots_(robots) {}

  /// What was seen until now is no evidence any more.
  void forget() noexcept;
  /// A hand is known to be at this robot until then: its sights say nothing about the camera. [s]
  void excuse(std::size_t robot, double until) noexcept { robots_[robot].excused_until = until; }

  /// How far a robot may be from where it is expected with the camera where it was.
  struct Doubt {
    double way = 0.0;    ///< it was told to drive, since its sight before: it may have stood all the while [m]
    double turn = 0.0;   ///< the same of a turn, by the lever [m]
    double noise = 0.0;  ///< what both poses leave open, a turn by its lever [m]
  };
  /// A robot's newest sight, before its filter takes it in.
  void see(std::size_t robot, const PoseFilter& filter, const FilterParameters& parameters,
           const Measurement& measurement) noexcept;
  /// The same: a robot's newest sight, and where its sight before and its commands say that it should be. One that is
  /// not newer changes nothing.
  void see(std::size_t robot, const Pose& expected, const Pose& measured, double captured_at,
           const Doubt& doubt) noexcept;

  /// After all sights of a tick: the motion, once, where all robots that were seen took part in it and at least `least`
  /// of them moved.
  std::optional<CommonMotion> moved(std::size_t least = 2) noexcept;

 private:
  struct Robot {
    double seen_at = Measurement{}.captured_at, excused_until = seen_at;  // [s]
    // Of the newest sight; since something moved, of all sights together.
    Pose measured, change;
    Doubt doubt;
    std::size_t sights = 0;

    bool displaced() const noexcept;
  };
  struct Motion {
    Pose from, to;  // of the middle of the tags, and by how much everything turns about it

    Pose change_at(const Pose& before) const noexcept;
  };
  bool counts(const Robot& robot) const noexcept;  // seen again after something had moved
  Motion fit() const noexcept;
  bool explains(const Motion& motion, const Robot& robot) const noexcept;

  std::vector<Robot> robots_;
  bool suspects_ = false;
  double since_ = 0.0;     // of what is suspected: the last moment at which nothing had moved [s]
  double began_at_ = 0.0;  // of the first sight of it [s]
  double newest_ = 0.0;    // of all sights [s]
};

}  // namespace skein::core
