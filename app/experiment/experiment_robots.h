#pragma once

#include <optional>
#include <string>

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"
#include "comms/link_address.h"

namespace skein::app {

/// Of a drive's measures, those that a table says.
struct DriveKeys {
  std::optional<double> wheel_diameter, wheel_ratio, track;

  /// `drive` with what was said.
  core::DifferentialDrive over(core::DifferentialDrive drive) const noexcept {
    drive.wheel_diameter = wheel_diameter.value_or(drive.wheel_diameter);
    drive.wheel_ratio = wheel_ratio.value_or(drive.wheel_ratio);
    drive.track = track.value_or(drive.track);
    return drive;
  }
};

/// A robot as [robot_defaults] or [[robot]] have it so far.
struct RobotKeys {
  RobotSpec spec;
  const core::RobotType* model = nullptr;  ///< null: not said
  std::optional<double> radius;
  DriveKeys drive;
  /// [robot.truth]: of what is not said, the truth is what is believed.
  struct Truth {
    DriveKeys drive;
    double actuation_delay = 0.0;
  };
  std::optional<Truth> truth;
  std::string model_key;  ///< where it came from
};

/// The keys that [robot_defaults], [[robot]] and a file of robots have in common: link, adapter, model, measures,
/// limits and gains of its own.
void read_robot(TomlTable& table, RobotKeys& robot, Problems& problems);
/// Those of [[robot]] and of a file of robots.
void read_name_and_tag(TomlTable& table, RobotSpec& robot);

/// What is left to say once all tables are read.
RobotSpec finished(const RobotKeys& keys, Problems& problems);

/// Makes it one of this type, with the type's measures.
void become(RobotSpec& robot, const core::RobotType& type);

/// The type of a robot of which nothing is known but its address.
const core::RobotType& type_spoken(const comms::LinkAddress& address);

/// [robot_defaults] and every [[robot]] of an experiment.
void read_robots(TomlTable& document, Experiment& experiment, Problems& problems);

}  // namespace skein::app
