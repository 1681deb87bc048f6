#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/run/status.h"
#include "comms/link_supervisor.h"
#include "core/kinematics/robot_type.h"

namespace skein::app {

/// The command to a single wheel, and its duration: 80 steps of an e-puck, about 10 mm. [steps/s, s]
inline constexpr int one_wheel_speed = 200;
inline constexpr double one_wheel_time = 0.4;

/// Converts e-puck steps to the same distance, or speed, in steps of this robot type.
double steps_of(const core::RobotType& type, double epuck_steps) noexcept;

/// Counts of both wheels while one of them was commanded alone [steps], and for how long it was [s].
struct OneWheelTurn {
  double left = 0.0, right = 0.0;
  double seconds = one_wheel_time;

  /// Whether a wheel turned so much farther than at `speed` in this time that only a fault explains it: then the turn
  /// ends.
  bool too_far(double speed) const noexcept;
};

/// How far both wheels turned, forward, while one of them was commanded alone; all in one unit.
struct WheelMotion {
  double its_own, other;
  double expected;  ///< of the commanded wheel
  double most;      ///< the farthest possible in that time: `expected`, or more if the machine is late
  const char* unit;
};
/// The fault of the wheel that was commanded, "left" or "right"; empty: none. `still` is the text for a wheel without
/// motion: "'s encoder is silent".
std::string wheel_fault(const char* wheel, const WheelMotion& motion, const char* still);
/// The same for both wheels from their encoders, which were commanded this speed [steps/s].
std::vector<std::string> encoder_faults(const OneWheelTurn& left, const OneWheelTurn& right, double speed);
/// How often the robot reported speeds other than those sent, as a fault; empty: never.
std::string speed_fault(std::uint64_t times);

/// Turns each wheel of a robot about 10 mm forward and compares the counters with the command: wheels that are swapped
/// or turn backwards or too far, counters that are silent, speeds that are not those sent. A wheel that has turned
/// twice as far as it should is stopped. The robot's link must be up, without other commands meanwhile;
/// afterwards it stands. `keep_on` is called before every command: a sentence ends the check, as its error. Blocks for
/// some seconds.
tl::expected<WheelCheck, std::string> check_wheels(comms::LinkSupervisor& links, std::size_t link,
                                                   const core::RobotType& type,
                                                   const std::function<std::string()>& keep_on);

}  // namespace skein::app
