#pragma once

#include <cstdint>
#include <string>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"

namespace skein::app {

/// What can be said of a law before it drives real robots: the whole experiment with simulated robots in the place of
/// real ones, and what had to be taken from the law or done instead of it.
struct ControllerCheck {
  bool own = false;        ///< a controller of the user's own, which has a deadline; else a law that is built in
  std::int64_t ticks = 0;  ///< that the run has had
  double deadline = 0.0;   ///< [s]
  double wait_p50 = 0.0, wait_p99 = 0.0, wait_p999 = 0.0, wait_max = 0.0;  ///< from question to answer [s]
  std::int64_t late = 0;                                                   ///< ticks without an answer by the deadline
  std::int64_t commands = 0;                                               ///< one a robot and tick
  std::int64_t no_number = 0, limited = 0, shielded = 0;                   ///< of them
  std::int64_t collisions = 0;
  double min_distance = 0.0;  ///< [m]; NaN with one robot
  double outside = 0.0;       ///< farthest that a body was over the arena's edge [m]
  double final_error = 0.0;   ///< [m]
  std::string failure;        ///< why the run has failed, where it has

  /// It keeps its deadline at p99.9, asks for numbers, and nothing that comes after it had to fail.
  bool fit() const noexcept;
};

/// With everything real replaced by its simulation, on a clock that waits for the controller. The error says why it
/// cannot be started.
tl::expected<ControllerCheck, std::string> check_controller(const Experiment& experiment,
                                                            const std::string& program = {});

/// As `key: value` lines, the last of them the verdict.
std::string as_lines(const ControllerCheck& check);

}  // namespace skein::app
