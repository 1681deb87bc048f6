#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/estimation/measurement.h"
#include "core/estimation/pose_filter.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// The common motion of all robots' tags.
struct CommonMotion {
  std::size_t tags = 0;   ///< all visible tags, which all took part
  double distance = 0.0;  ///< their mean displacement [m]
  double turn = 0.0;      ///< counter-clockwise [rad]
};

/// Distinguishes a bumped camera from carried robots, one watch for each camera: after a bump every tag is displaced by
/// the same rigid motion of the plane, which the commanded motion does not explain. The motion must show in two
/// measurements of each tag, since a single torn frame looks the same. Tags that a bump has hidden may come back one
/// after the other, within 2 s. A motion below the robots' own motion plus 6 mm from frame to frame is not detected,
/// and with a single tag a moved robot and a moved camera look the same. Allocates in its constructor only.
class CameraWatch {
 public:
  static constexpr double lever = 0.1;  ///< a rotation counts as the displacement of a point this far out [m]

  explicit CameraWatch(std::size_t robots) : robots_(robots) {}

  /// Discards all evidence so far.
  void forget() noexcept;
  /// This robot is known to be moved by hand until this time: ignores its measurements. [s]
  void excuse(std::size_t robot, double until) noexcept { robots_[robot].excused_until = until; }

  /// How far a robot may be from its expected pose if the camera has not moved.
  struct Doubt {
    double way = 0.0;    ///< commanded distance since its previous measurement: the robot may not have moved at all [m]
    double turn = 0.0;   ///< the same for a rotation, times the lever [m]
    double noise = 0.0;  ///< uncertainty of both poses, a rotation times the lever [m]
  };
  /// A robot's newest measurement by this camera and the one `before` it; the filter has the commands between them.
  void see(std::size_t robot, const PoseFilter& filter, const FilterParameters& parameters, const Measurement& before,
           const Measurement& measurement) noexcept;
  /// The same, with the pose expected from its previous measurement and its commands. A measurement that is not newer
  /// changes nothing.
  void see(std::size_t robot, const Pose& expected, const Pose& measured, double captured_at,
           const Doubt& doubt) noexcept;

  /// After all measurements of a tick: the motion, once, if all visible robots took part in it and at least `least` of
  /// them moved.
  std::optional<CommonMotion> moved(std::size_t least = 2) noexcept;

 private:
  struct Robot {
    double seen_at = Measurement::never, excused_until = seen_at;  // [s]
    // The newest measured pose and its deviation from the expected one; once a motion is suspected, the sum of the
    // deviations.
    Pose measured, change;
    Doubt doubt;
    std::size_t sights = 0;

    bool displaced() const noexcept;
  };
  struct Motion {
    Pose from, to;  // of the centre of the tags, and the rotation about it

    Pose change_at(const Pose& before) const noexcept;
  };
  bool counts(const Robot& robot) const noexcept;  // seen again after something had moved
  Motion fit() const noexcept;
  bool explains(const Motion& motion, const Robot& robot) const noexcept;

  std::vector<Robot> robots_;
  bool suspects_ = false;
  double since_ = 0.0;     // of the suspected motion: the last moment at which nothing had moved [s]
  double began_at_ = 0.0;  // of its first measurement [s]
  double newest_ = 0.0;    // of all measurements [s]
};

}  // namespace skein::core
