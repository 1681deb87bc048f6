#pragma once

#include <cstddef>
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

/// The fault of a wheel that was commanded alone, from the motion of both; empty: none. `still` is the text for a wheel
/// without motion: "'s encoder is silent".
std::string wheel_fault(const char* wheel, double its_own, double other, double expected, const char* still,
                        const char* unit);
/// The same for both wheels from their encoders [steps]: the left one commanded alone, then the right one.
std::vector<std::string> encoder_faults(double left, double right_with_left, double right, double left_with_right,
                                        double expected);

/// Turns each wheel of a robot about 10 mm forward and compares the counters with the command: wheels that are swapped
/// or turn backwards, counters that are silent. The robot's link must be up, without other commands meanwhile;
/// afterwards it stands. `keep_on` is called before every command: a sentence ends the check, as its error. Blocks for
/// some seconds.
tl::expected<WheelCheck, std::string> check_wheels(comms::LinkSupervisor& links, std::size_t link,
                                                   const core::RobotType& type,
                                                   const std::function<std::string()>& keep_on);

}  // namespace skein::app
