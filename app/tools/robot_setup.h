#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/experiment/known_robots.h"
#include "app/tools/robot_test.h"
#include "comms/bluez.h"

namespace skein::app {

/// A robot that is being set up: one of an experiment, or one that a scan has found, and what is known of it by now.
struct RobotSetup {
  RobotSpec spec;
  std::string name;            ///< in messages: "robot 2 (anna)", "e-puck_1234"
  int number = -1;             ///< in the experiment, from 0; -1: it is not in it
  std::optional<bool> paired;  ///< with the PC; empty: not known

  bool pinged = false;                              ///< there was an attempt to reach it
  bool answers = false;                             ///< the last time
  std::string silence;                              ///< why it did not answer then
  double round_trip = none, round_trip_p99 = none;  ///< median and 99th percentile [s]
  std::uint64_t exchanges = 0, lost = 0;            ///< questions answered, and not answered in time
  std::string battery;                              ///< in words; empty: not known
  bool battery_low = false;
  std::string version;  ///< of its firmware, as reported; empty: not known

  std::optional<RobotTestResult> test;  ///< of its wheels and its tag
  std::string test_problem;             ///< why its last test did not finish; empty: it did, or there was none
  bool may_drive = false;               ///< it has not acknowledged its last stop

  bool is_bluetooth() const;
};

/// A robot that the Bluetooth daemon knows, as a file of robots has it.
KnownRobot known_robot(const comms::BluetoothRobot& robot);

/// Whether two descriptions are of one robot: same name, link and tag.
bool is_same_robot(const RobotSpec& a, const RobotSpec& b);

/// The robots of an experiment. What is known of those that `before` has already (same name, link and tag) is kept,
/// and so are its robots that are not in this experiment.
std::vector<RobotSetup> setups_of(const Experiment& experiment, const std::vector<RobotSetup>& before = {});

/// Enters the results of a scan: updates whether known robots are paired, and adds the others.
void add_found(std::vector<RobotSetup>& robots, const std::vector<comms::BluetoothRobot>& found);

struct SetupVerdict {
  enum class State {
    ready,
    missing,  ///< something has not been done yet
    wrong,    ///< something must be fixed
  };
  State state;
  std::string sentence;  ///< the next step that it needs, or "ready", without a full stop
};

/// `camera`: the experiment has one, so that tags can be tested.
SetupVerdict verdict_on(const RobotSetup& robot, bool camera);

/// Everything that was found about it, a sentence each.
std::vector<std::string> details_of(const RobotSetup& robot);

struct SavedSetups {
  std::string file;
  std::size_t added = 0;
  std::vector<std::string> problems;
};
/// Adds the real ones among these robots to the file of robots (known_robots_file), and writes what their tests have
/// measured. The error is a sentence.
tl::expected<SavedSetups, std::string> save(const std::vector<RobotSetup>& robots);

}  // namespace skein::app
