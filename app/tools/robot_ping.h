#pragma once

#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/experiment/experiment.h"
#include "comms/link_status.h"
#include "comms/round_trips.h"

namespace skein::app {

/// Measurements of an experiment's links under its own traffic.
struct RobotPing {
  struct Robot {
    std::size_t robot = 0;  ///< of the experiment
    std::string name;
    std::string adapter;       ///< as the file says; empty: the system's choice, or no Bluetooth
    comms::LinkStatus status;  ///< before the links were closed
    comms::RoundTrips times;
    bool stop_acknowledged = false;
    bool answered() const noexcept { return status.exchanges > 0; }
  };
  std::vector<Robot> robots;  ///< that have a link, real and emulated
  double seconds = 0.0;       ///< that were measured
};

struct PingOptions {
  double seconds = 60.0;
  bool all = true;                                    ///< it is an error if one of the robots does not answer
  std::function<bool()> keep_on = {};                 ///< called in every tick; false ends it
  std::function<void(const std::string&)> warn = {};  ///< gets what the operator must see at once; may be empty
};

/// Connects to every robot that has a link and sends it speeds of 0 at the experiment's rate, just as a run sends
/// speeds, and asks for version and battery as a run does. The guard watches over real ones, and STOP from outside ends
/// it. The error: a robot cannot be reached.
tl::expected<RobotPing, std::string> ping_robots(const Experiment& experiment, const PingOptions& options);

/// What [links] should be for a robot at `speed` [m/s] over a radio whose round trips have this 99.9th percentile: the
/// blind distance covers twice the sum of two of them and a tick, so that a robot is not slowed within that sum; a
/// reply counts as lost after three of them.
LinksSpec proposed_links(double rtt_p999, double speed, double period);

/// Histogram of the round trips, a line per bin: " 20 .. 50 ms ######## 61.2 %". Empty bins at the ends are
/// omitted.
std::vector<std::string> histogram(const comms::RoundTrips& times);

}  // namespace skein::app
