#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/estimation/measurement.h"
#include "core/estimation/pose_filter.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// Gives the measurements of several cameras over one floor to one filter per robot, in the order of their capture. A
/// robot that another camera has just seen where it should be has not been carried: a jump is believed when every
/// camera that sees the robot reports it. Cameras that go on to differ have been moved. Smaller differences are those
/// of calibrations: a camera that joins the others is shifted to where they see the robot before it counts, and when
/// they no longer see it, the shift fades, so that no pose jumps at a seam. Two cameras that go on to see a robot more
/// than `slight` apart are named, though nobody contradicts anybody. With one camera, all measurements pass.
/// Allocates in its constructor only.
class CameraFusion {
 public:
  /// Calibrations, and clocks of cameras, agree better than this. [m]
  static constexpr double slight = 0.005;

  /// `bridge`: a measurement that is older than the newest one by more than this no longer counts [s].
  CameraFusion(std::size_t robots, std::size_t cameras, const FilterParameters& parameters, double bridge);

  /// The cameras with something new of this robot, by their times of capture. `measurements`: robot i by camera c at
  /// c * robots + i. Valid until the next call.
  std::span<const std::size_t> news(std::size_t robot, std::span<const Measurement> measurements) noexcept;
  /// What this camera has last measured of a robot.
  const Measurement& newest(std::size_t robot, std::size_t camera) const noexcept {
    return seen_[camera * robots_ + robot].newest;
  }
  /// The newest measurement of a robot that its filter has taken in, as the camera made it.
  const Measurement& believed(std::size_t robot) const noexcept { return believed_[robot]; }
  /// The same as the filter took it: shifted to where the cameras before have the robot. Only these show how it moves.
  const Measurement& fused(std::size_t robot) const noexcept { return fused_[robot]; }

  /// Another camera goes on to see the robot elsewhere.
  struct Disagreement {
    std::size_t other;  ///< that camera
    double distance;    ///< between the two positions [m]
  };
  struct Outcome {
    std::optional<Pose> expected;              ///< where the robot should be: it has been carried elsewhere
    std::optional<Disagreement> disagreement;  ///< only once, when it becomes certain
    std::optional<Disagreement> difference;    ///< more than `slight`, but none that contradicts; once for two cameras
  };
  /// What two cameras that see a robot say of each other. A start forgets it with everything else.
  struct Comparison {
    bool compared = false;                     ///< both have seen a robot at once
    std::size_t robot = 0;                     ///< whom they see `apart`
    double apart = 0.0;                        ///< if they go on to see it more than `slight` apart; 0: they do not [m]
    double at = Measurement::never;            ///< when they last did [s]
    bool told = false;                         ///< as Outcome::difference
    double undecided_at = Measurement::never;  ///< when it was last not known whether they go on to see one apart [s]
  };
  /// first < second.
  const Comparison& comparison(std::size_t first, std::size_t second) const noexcept {
    return comparisons_[pair(first, second)];
  }
  /// Takes in one of the news, at the time `now` [s].
  Outcome take(std::size_t robot, std::size_t camera, const Measurement& measurement, PoseFilter& filter,
               double now) noexcept;

  /// Discards all that was measured.
  void forget() noexcept;

 private:
  struct Seen {
    Measurement newest;
    Pose shift;            // that makes its poses agree with those of the cameras that saw the robot before
    double weight = 0.0;   // of the frames that it was learned from [1/m^2]
    int learned = 0;       // number of these frames
    int contradicted = 0;  // measurements in a row that other cameras contradict
  };
  struct Verdict {
    bool agrees;
    std::optional<Disagreement> disagreement = {};
  };
  struct Apart {                                        // two cameras that see a robot
    double since = Measurement::never, newest = since;  // of measurements that are more than slightly apart [s]
    Pose sum;                                           // of the vectors from the first camera's to the second's
    int count = 0;
  };
  std::size_t pair(std::size_t first, std::size_t second) const noexcept {
    return second * (second - 1) / 2 + first;  // first < second
  }
  std::optional<Disagreement> compare(std::size_t robot, std::size_t camera, const Measurement& m,
                                      const PoseFilter& filter) noexcept;
  Verdict reconcile(std::size_t robot, std::size_t camera, double seen_before_at, const PoseFilter& filter, double now,
                    Measurement& m) noexcept;
  bool align(Seen& seen, const PoseFilter& filter, const Measurement& m, double now) const noexcept;

  std::size_t robots_, cameras_;
  FilterParameters parameters_;
  double bridge_;                        // [s]
  std::vector<Seen> seen_;               // robot i by camera c at c * robots + i
  std::vector<Apart> apart_;             // of robot i: pair p at i * pairs + p
  std::vector<Comparison> comparisons_;  // by pair
  std::vector<Measurement> believed_, fused_;
  std::vector<std::size_t> in_order_;
};

}  // namespace skein::core
