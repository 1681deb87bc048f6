#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/estimation/measurement.h"
#include "core/estimation/pose_filter.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// Sees from one robot's poses whether it does what it is commanded to. One that drives or turns otherwise, three times
/// in a row, disobeys, until it is seen to stand three times. One that stands although it is commanded to drive is
/// stuck, or was switched off. Does not allocate.
class ObedienceWatch {
 public:
  /// A measured speed below this is noise [m/s].
  static constexpr double too_slow = 0.02;

  /// What is known of the robot at a tick.
  struct Robot {
    double now;         ///< [s]
    double to_wheel;    ///< from its middle to one of its wheels [m]
    double kidnap;      ///< a jump by more than its noise and this is a move by hand [m]
    double blind_way;   ///< how far it may have driven since on commands that its link has not confirmed [m]
    bool lost = false;  ///< has not been seen for too long: nothing can be said of its motion
    bool judged;        ///< it is being driven: its motion is compared with its commands
  };
  /// A tick, with the robot's newest measurement, and the filter that knows its commands. True: whether it disobeys has
  /// changed.
  bool see(const Robot& robot, const PoseFilter& filter, const Measurement& newest) noexcept;

  bool disobeys() const noexcept { return disobeys_; }
  bool stuck() const noexcept { return stuck_; }
  /// Its motion by its first and its newest sight within a fifth of a second; nullopt: it was not seen often enough.
  const std::optional<Twist>& motion() const noexcept { return motion_; }
  /// These two sights, if there is a motion.
  const Measurement& first_sight() const noexcept { return seen_[count_ % frames]; }
  const Measurement& newest_sight() const noexcept { return seen_[(count_ + frames - 1) % frames]; }

  /// It is known to be moved by hand until this time. [s]
  void excuse(double until) noexcept { excused_until_ = until; }
  /// Discards what was measured, not what followed from it.
  void forget() noexcept;

 private:
  static constexpr std::size_t frames = 6;  // a fifth of a second: noise of 1 mm gives 7 mm/s

  bool add(const Robot& robot, const PoseFilter& filter, const Measurement& newest) noexcept;
  bool judge(const Robot& robot, const PoseFilter& filter, const Measurement& first, const Measurement& newest,
             double v) noexcept;

  std::array<Measurement, frames> seen_{};
  std::array<double, frames> blind_{};  // how far it may have driven by then on unconfirmed commands [m]
  std::size_t count_ = 0;
  int stood_ = 0;                              // times in a row that it was seen to stand though commanded to drive
  int still_ = 0;                              // and not to turn though commanded to turn
  int contradicted_ = 0;                       // times in a row that its motion contradicted its assumed state
  double excused_until_ = Measurement::never;  // until then, because it was moved by hand [s]
  bool disobeys_ = false, stuck_ = false;
  std::optional<Twist> motion_;
};

}  // namespace skein::core
