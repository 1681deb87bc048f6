#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/run/tick_record.h"
#include "comms/link_status.h"

namespace skein::app {

/// The state of a link in the vocabulary of app/run.
LinkState state_of(comms::LinkState state) noexcept;

/// Passes the links' status to the control thread without a lock, and detects lost links.
class LinkWatch {
 public:
  /// `robots`: the robot of each link. `bridge`: how long a link with a connection may be
  /// without an answer [s]; without a connection it is lost at once. `wall`: the run's clock.
  LinkWatch(const std::vector<std::size_t>& robots, double bridge, bool wall);

  /// Updates the links' status. Returns a sentence about the first lost link, if any. One thread. A link that is lost
  /// and back before the control thread asks is told like any other.
  std::optional<std::string> update(const std::vector<comms::LinkStatus>& links);

  /// A robot whose link was lost since the last call, and a sentence about it. The thread of `update`.
  struct Loss {
    std::size_t robot;
    std::string sentence;
  };
  std::vector<Loss> losses() { return std::exchange(losses_, {}); }

  /// Adds an event for every link that was lost or came back since the last call, as far as there is room. Control
  /// thread only.
  void tell(EventList& events) noexcept;
  /// Fills in the links' status. Control thread only.
  void fill(std::vector<RobotRecord>& robots) const noexcept;

 private:
  struct Cell {
    explicit Cell(std::size_t of) : robot(of) {}
    std::size_t robot;
    std::atomic<LinkState> state{LinkState::up};
    std::atomic<LinkState> reported{LinkState::up};  // "up" until it is lost
    std::atomic<LinkState> told{LinkState::up};      // by the control thread
    std::atomic<double> round_trip{none}, round_trip_p99{none}, battery{none}, left{none}, right{none}, bytes{none},
        losses{none}, reconnects{none};
  };

  std::deque<Cell> cells_;  // atomics cannot move
  std::vector<Loss> losses_;
  double bridge_;
  bool wall_;
};

}  // namespace skein::app
