#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/link_address.h"

namespace skein::app {

// Of every program that talks to an experiment's robots. [s]
inline constexpr double link_close_timeout = 1.0;    ///< for the stops to be acknowledged
inline constexpr double link_heartbeat = 0.05;       ///< at a slow rate a lost link is noticed as soon as at 25 Hz
inline constexpr double link_battery_period = 10.0;  ///< from one question for the battery to the next

/// The lines to those robots of an experiment that have one.
struct RobotLines {
  std::vector<std::size_t> robots;               ///< of the experiment
  std::vector<comms::LinkAddress> addresses;     ///< in the order of `robots`
  std::unique_ptr<comms::PtyEmulator> emulator;  ///< at the other end of the emulated ones' lines; null: none is
};

/// Finds the addresses of the real robots and begins to emulate the emulated ones. `on_wheels`: gets the speeds that
/// the firmware of an emulated robot of the experiment sends to its wheels, on the emulator's thread. `faults`: see
/// SessionOptions.
tl::expected<RobotLines, std::string> open_lines(
    const Experiment& experiment,
    const std::function<void(std::size_t robot, const core::WheelSpeeds& told)>& on_wheels,
    const std::function<double()>& clock, const std::vector<comms::Fault>& faults = {});

}  // namespace skein::app
