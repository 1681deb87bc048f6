#pragma once

#include <optional>
#include <string>

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// A robot as [robot_defaults] or [[robot]] have it so far.
struct RobotKeys {
  RobotSpec spec;
  std::optional<core::MotorModel> model;
  std::string model_key;  ///< where it came from
};

/// The keys that [robot_defaults], [[robot]] and a file of robots have in common: link, adapter, model, wheels.
void read_robot(TomlTable& table, RobotKeys& robot, Problems& problems);
/// Those of [[robot]] and of a file of robots.
void read_name_and_tag(TomlTable& table, RobotSpec& robot);

/// What is left to say once all tables are read.
RobotSpec finished(const RobotKeys& keys, Problems& problems);

/// [robot_defaults] and every [[robot]] of an experiment.
void read_robots(TomlTable& document, Experiment& experiment, Problems& problems);

}  // namespace skein::app
