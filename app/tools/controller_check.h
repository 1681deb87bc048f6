#pragma once

#include <cstdint>
#include <string>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"

namespace skein::app {

/// Tests a law before it drives real robots: runs the whole experiment with simulated robots instead of real ones, and
/// counts how often its commands were limited or replaced.
struct ControllerCheck {
  bool own = false;        ///< a controller of the user's own, which has a deadline; else a built-in law
  std::int64_t ticks = 0;  ///< of the run
  double deadline = 0.0;   ///< [s]
  double wait_p50 = 0.0, wait_p99 = 0.0, wait_p999 = 0.0, wait_max = 0.0;  ///< from question to answer [s]
  std::int64_t late = 0;                                                   ///< ticks without an answer by the deadline
  std::int64_t commands = 0;                                               ///< one per robot and tick
  std::int64_t no_number = 0, limited = 0, shielded = 0;                   ///< of them
  std::int64_t collisions = 0;
  double min_distance = 0.0;  ///< [m]; NaN with one robot
  double outside = 0.0;       ///< farthest that a body was over the arena's edge [m]
  double final_error = 0.0;   ///< [m]
  std::string failure;        ///< why the run failed, if it did

  /// It keeps its deadline at p99.9, its outputs are numbers, and limits and shield prevented every collision.
  bool fit() const noexcept;
};

/// Replaces everything real by its simulation, on a clock that waits for the controller. The error says why it cannot
/// be started.
tl::expected<ControllerCheck, std::string> check_controller(const Experiment& experiment,
                                                            const std::string& program = {});

/// As `key: value` lines, the last of them the verdict.
std::string as_lines(const ControllerCheck& check);

}  // namespace skein::app
