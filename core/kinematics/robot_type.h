#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/kinematics/differential_drive.h"
#include "core/kinematics/step_rate.h"

namespace skein::core {

/// A type of robot, named by the key `model` of a file. A file can override the dimensions of the type.
struct RobotType {
  std::string_view name;          ///< "epuck2"
  double radius = 0.035;          ///< of the body [m]
  DifferentialDrive wheels = {};  ///< its unit of speed, "steps/s", is that of the robot's commands
  MotorModel motor = MotorModel::servo;
  /// How long after the last command it stops by itself [s]; empty: it has no watchdog.
  std::optional<double> watchdog = {};
  /// Its protocol (comms/protocol.h); empty: the default protocol of its link.
  std::string_view protocol = {};
};

/// All types, one row each: the only source of a type's properties.
inline constexpr std::array robot_types{
    // Simulated only: an e-puck whose motors execute the law's commands exactly.
    RobotType{.name = "ideal", .motor = MotorModel::ideal},
    RobotType{.name = "epuck1", .motor = MotorModel::epuck1},
    RobotType{.name = "epuck2", .wheels = {.max_step_rate = 1100}, .motor = MotorModel::epuck2},
    // Wheels of 42 mm, 105.4 mm apart. The unit of speed is 100 encoder pulses per second, 0.6781 mm/s; the largest
    // speed is 1200 units, 0.81 m/s.
    RobotType{.name = "khepera4",
              .radius = 0.0704,
              .wheels = {.wheel_diameter = 0.042,
                         .track = 0.1054,
                         .steps_per_turn = pi * 42.0 / 0.6781,
                         .max_step_rate = 1200},
              .protocol = "khepera4"},
    // A home-made robot with the protocol of docs/open-protocol.md: speeds in 0.1 mm/s. The experiment file gives its
    // dimensions.
    RobotType{.name = "open",
              .radius = 0.06,
              .wheels = {.wheel_diameter = 0.065, .track = 0.1, .steps_per_turn = pi * 650.0, .max_step_rate = 5000},
              .watchdog = 0.2,
              .protocol = "open"},
};

/// The type of this name; null: there is none.
constexpr const RobotType* find_robot_type(std::string_view name) noexcept {
  for (const RobotType& type : robot_types)
    if (type.name == name) return &type;
  return nullptr;
}

/// All names in quotes, "a", "b", for messages.
inline std::string robot_type_names() {
  std::string names;
  for (const RobotType& type : robot_types) names += (names.empty() ? "\"" : ", \"") + std::string(type.name) + '"';
  return names;
}

}  // namespace skein::core
