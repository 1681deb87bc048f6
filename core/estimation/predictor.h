#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/estimation/measurement.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// Propagates a measured pose to the time at which the next command acts, along the arcs commanded since. One for each
/// robot. A measurement taken at the command's time is returned unchanged, bit for bit.
class Predictor {
 public:
  /// Records that the robot drives with `twist` from time `acts_at` on. Times must not decrease. [s]
  void command(double acts_at, const Twist& twist) noexcept;

  /// The pose at `time`, from the measurement and the recorded commands. Before the oldest recorded command (10 s at
  /// 25 Hz, 0.25 s at 1000 Hz), the robot counts as standing still; to predict over a longer time, use `forgets_next`
  /// before each command.
  Pose predict(const Measurement& measurement, double time) const noexcept {
    return predict(measurement.pose, measurement.captured_at, time);
  }
  Pose predict(const Pose& pose, double captured_at, double time) const noexcept;

  /// The commanded distance and rotation between two times, in either direction.
  struct Way {
    double driven = 0.0;  ///< [m]
    double turned = 0.0;  ///< [rad]
    friend Way operator+(const Way& a, const Way& b) noexcept { return {a.driven + b.driven, a.turned + b.turned}; }
  };
  Way way(double from, double to) const noexcept;

  /// A command and the time while it was in force. [s]
  struct Leg {
    Twist twist;
    double from = 0.0, to = 0.0;
  };
  /// The command that the next call of command() drops from the record, if any.
  std::optional<Leg> forgets_next() const noexcept;
  /// Whether every command that was in force since `time` is recorded. [s]
  bool remembers(double time) const noexcept;

 private:
  /// Calls use(twist, seconds) for every command that was in force between two times, in their order.
  template <typename Use>
  void between(double from, double to, Use&& use) const noexcept;

  struct Entry {
    double from = 0.0;
    Twist twist;
  };
  static constexpr std::size_t memory = 256;

  std::array<Entry, memory> entries_{};
  std::size_t count_ = 0;  // of all ever recorded; entry k is at k % memory
};

}  // namespace skein::core
