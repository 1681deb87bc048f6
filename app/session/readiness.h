#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/experiment/certificate.h"
#include "app/run/status.h"

namespace skein::app {

/// One check before a start.
struct Check {
  enum class What { camera, settings, tags, links, batteries, gains, reference, places };
  enum class State {
    holds,
    waits,  ///< not yet known
    fails,
  };
  What what;
  State state;
  std::string reason;  ///< the reason in words; if the check holds, the finding
  bool hard;           ///< required for a start; an operator may override soft checks
  bool button = true;  ///< if it fails, the window has a button that helps

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

/// The checks for a start, from what is known by now; empty pointers: not known yet. In the order in which problems
/// should be fixed.
std::vector<Check> readiness(const Experiment& experiment, const Certificate* certificate, const TickRecord* record,
                             std::span<const RobotStatus> robots, const CameraStatus& camera = {});

/// Whether a battery of this robot with this voltage [V] is low. False if the robot itself reports that
/// (comms::Protocol, `charge_below`), or the voltage is not known.
bool is_low(const RobotSpec& robot, double battery);

/// The value of [tags] size, in whole millimetres, with which robots would be seen whose tags are not accepted for
/// their size: none of the `robots` is seen now, and all tags that are there have this edge [m]. Empty: no such value.
std::optional<double> fitting_tag_size(std::size_t robots, std::span<const UnseenTag> unseen);

/// Every hard check holds.
bool may_start(std::span<const Check> checks) noexcept;
/// Every check holds.
bool all_hold(std::span<const Check> checks) noexcept;

}  // namespace skein::app
