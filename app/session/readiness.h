#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/experiment/certificate.h"
#include "app/run/status.h"

namespace skein::app {

/// One of the things that are looked at before a start.
struct Check {
  enum class What { camera, tags, links, batteries, gains, reference, places };
  enum class State {
    holds,
    waits,  ///< not yet known
    fails,
  };
  What what;
  State state;
  std::string reason;  ///< why, in words; where it holds, what was found
  bool hard;           ///< nobody starts without it; what is soft, an operator may overrule

  bool holds() const noexcept {
    switch (state) {
      case State::holds:
        return true;
      case State::waits:
      case State::fails:
        return false;
    }
    return false;
  }
};

/// Whether an experiment can start, from what is known by now; empty pointers: not known yet. All checks, in the order
/// in which they are mended.
/// `camera_down`: why the camera does not deliver; empty: it does.
std::vector<Check> readiness(const Experiment& experiment, const Certificate* certificate, const TickRecord* record,
                             std::span<const RobotStatus> robots, const std::string& camera_down = {});

/// Every hard check holds.
bool may_start(std::span<const Check> checks) noexcept;
/// Every check holds.
bool all_hold(std::span<const Check> checks) noexcept;

}  // namespace skein::app
