#include "app/session/link_watch.h"

#include <fmt/format.h>

namespace skein::app {
namespace {

/// No patience helps: nothing can be sent.
bool is_gone(comms::LinkState state) noexcept {
  switch (state) {
    case comms::LinkState::down:
    case comms::LinkState::connecting:
    case comms::LinkState::failed:
    case comms::LinkState::closed:
      return true;
    case comms::LinkState::synchronising:
    case comms::LinkState::up:
    case comms::LinkState::stale:
      return false;
  }
  return false;
}

}  // namespace

LinkState state_of(comms::LinkState state) noexcept {
  switch (state) {
    case comms::LinkState::down:
      return LinkState::down;
    case comms::LinkState::connecting:
      return LinkState::connecting;
    case comms::LinkState::synchronising:
      return LinkState::synchronising;
    case comms::LinkState::up:
      return LinkState::up;
    case comms::LinkState::stale:
      return LinkState::stale;
    case comms::LinkState::failed:
      return LinkState::failed;
    case comms::LinkState::closed:
      return LinkState::closed;
  }
  return LinkState::failed;
}

LinkWatch::LinkWatch(const std::vector<std::size_t>& robots, double bridge, bool wall) : bridge_(bridge), wall_(wall) {
  for (const std::size_t robot : robots) cells_.emplace_back(robot);
}

std::optional<std::string> LinkWatch::update(const std::vector<comms::LinkStatus>& links) {
  std::optional<std::string> lost;
  for (std::size_t k = 0; k < links.size() && k < cells_.size(); ++k) {
    const comms::LinkStatus& link = links[k];
    Cell& cell = cells_[k];
    const LinkState state = state_of(link.state);
    cell.state.store(state, std::memory_order_relaxed);
    // It was opened again since the last update, which may be late: then it was lost in between.
    const bool reopened = static_cast<double>(link.reconnects) > cell.reconnects.load(std::memory_order_relaxed);
    cell.left.store(static_cast<double>(link.left_steps), std::memory_order_relaxed);
    cell.right.store(static_cast<double>(link.right_steps), std::memory_order_relaxed);
    if (wall_) {  // what the machine's speed decides is no part of a run that repeats to the bit
      if (link.exchanges > 0) {
        cell.round_trip.store(link.rtt_median, std::memory_order_relaxed);
        cell.round_trip_p99.store(link.rtt_p99, std::memory_order_relaxed);
      }
      cell.bytes.store(static_cast<double>(link.bytes_sent + link.bytes_received), std::memory_order_relaxed);
      cell.losses.store(static_cast<double>(link.timeouts), std::memory_order_relaxed);
      cell.reconnects.store(static_cast<double>(link.reconnects), std::memory_order_relaxed);
      cell.battery.store(link.battery.volts, std::memory_order_relaxed);
    }
    const bool up = state == LinkState::up;
    const bool known = cell.reported.load(std::memory_order_relaxed) != LinkState::up;
    if ((!up && (link.out_for > bridge_ || is_gone(link.state))) || (reopened && !known)) {
      const LinkState was = up ? LinkState::down : state;
      cell.reported.store(was, std::memory_order_release);
      if (known && lost) continue;
      const std::string sentence = fmt::format("robot {}: the link {} {}{}{}", cell.robot + 1, up ? "was" : "is",
                                               word(was), link.reason.empty() ? "" : ": ", link.reason);
      if (!known) losses_.push_back({cell.robot, sentence});
      if (!lost) lost = sentence;
    } else if (up && known && cell.told.load(std::memory_order_acquire) != LinkState::up) {
      cell.reported.store(LinkState::up, std::memory_order_release);
    }
  }
  return lost;
}

void LinkWatch::tell(EventList& events) noexcept {
  for (Cell& cell : cells_) {
    const LinkState reported = cell.reported.load(std::memory_order_acquire);
    const bool told_up = cell.told.load(std::memory_order_relaxed) == LinkState::up;
    if ((reported == LinkState::up) == told_up || events.full()) continue;
    events.add(events::Link{cell.robot, reported});
    cell.told.store(reported, std::memory_order_release);
  }
}

void LinkWatch::fill(std::vector<RobotRecord>& robots) const noexcept {
  for (const Cell& cell : cells_) {
    LinkRecord& link = robots[cell.robot].link;
    link.state = cell.state.load(std::memory_order_relaxed);
    link.round_trip = cell.round_trip.load(std::memory_order_relaxed);
    link.battery = cell.battery.load(std::memory_order_relaxed);
    link.left_steps = cell.left.load(std::memory_order_relaxed);
    link.right_steps = cell.right.load(std::memory_order_relaxed);
    link.round_trip_p99 = cell.round_trip_p99.load(std::memory_order_relaxed);
    link.bytes = cell.bytes.load(std::memory_order_relaxed);
    link.losses = cell.losses.load(std::memory_order_relaxed);
    link.reconnects = cell.reconnects.load(std::memory_order_relaxed);
  }
}

}  // namespace skein::app
