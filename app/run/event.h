#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/control/gain_schedule.h"

namespace skein::app {

/// Something that happened at a tick: small enough to be copied without allocating; `describe` makes the log's words of
/// it.
struct Event {
  enum class Kind : std::uint8_t {
    start,            // operator or program
    pause,            // operator
    resume,           // operator
    stop,             // operator's STOP, or a failure
    perturb,          // robot; values dx, dy, dtheta: a [[perturb]] of the file
    kidnap,           // robot; values dx, dy, dtheta: found this far from where it should be, put there by somebody
    move,             // robot; values x, y, theta: put there by the operator
    hold,             // robot: the operator made it stand, alone; or its link was lost
    release,          // robot: it may drive again
    kick,             // robot; values vx, vy: the operator sent it sliding
    obstacle,         // its number in `robot`; values x, y, radius: put there by the operator, radius 0: taken away
    gain,             // name; values from, to, ramp: the operator's new target for all pairs; 0 or [s]
    schedule,         // name; values from, to: a [[gain_change]] of the file begins
    gain_held,        // name; values asked for, held at: (18) forbids more
    pair_gain,        // robot, other, name; values from, to, ramp: the operator's new target for one pair
    pair_gain_held,   // robot, other, name; values asked for, held at
    couple,           // robot, other: coupled again
    uncouple,         // robot, other: not coupled any more
    lost,             // robot: no pose within the bridge time, it was stopped
    found,            // robot: its pose is back
    avoid,            // robot: entered a detection region
    clear,            // robot: back on the nominal reference
    stage,            // operator or program: to the starts
    staged,           // everybody stands at its start
    deadlock,         // robot: field or shield held it up and brought it no nearer to its place; it takes a way round
    deadline_missed,  // values[0]: how many ticks were skipped
    v_rise,           // values[0]: V has risen so much, and nothing that is known explains it
    link,             // robot; values[0]: comms::LinkState: lost for longer than the bridge time, or up again
    film_broken,      // the disk took no more of the camera's film; the run goes on without
  };
  Kind kind = Kind::start;
  int robot = -1;  ///< from 0; -1: none (of `obstacle`: the obstacle's number)
  core::GainName gain = core::GainName::k_xx;
  std::array<double, 3> values{};
  int other = -1;  ///< the second robot of a pair, from 0; -1: none
};

/// A bounded list that never allocates; what does not fit is counted.
class EventList {
 public:
  /// What is changed before a start comes with it, all in one tick: every gain, gains of pairs, a crowd of obstacles.
  static constexpr std::size_t capacity = 96;

  void add(const Event& event) noexcept {
    if (size_ < capacity)
      events_[size_++] = event;
    else
      ++dropped_;
  }
  bool contains(Event::Kind kind, int robot) const noexcept {
    for (const Event& event : *this)
      if (event.kind == kind && event.robot == robot) return true;
    return false;
  }
  void clear() noexcept { size_ = 0, dropped_ = 0; }
  const Event* begin() const noexcept { return events_.data(); }
  const Event* end() const noexcept { return events_.data() + size_; }
  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  std::size_t dropped() const noexcept { return dropped_; }

 private:
  std::array<Event, capacity> events_{};
  std::size_t size_ = 0, dropped_ = 0;
};

/// One event in words without commas, robots from 1, for the CSV, the log and the window: "perturb r2 dx=0.05 dy=0.15
/// dtheta=0", "gain k_xx 0.008 -> 0.01", "lost r3", "stop".
std::string describe(const Event& event);
/// The event that `describe` put into these words; none if they are not such words.
std::optional<Event> parse_event(std::string_view text);
/// Whether the operator does this to a run, so that an experiment file can as well: moves, kicks, holds, obstacles,
/// gains.
bool is_action(Event::Kind kind) noexcept;
/// As `parse_event`, but only what is an action, with all of its words and no others; none: the text is not that.
std::optional<Event> parse_action(std::string_view text);
/// All events of a tick, joined by "; ", "+N more" where some were dropped.
std::string describe(const EventList& events);

const char* name(core::GainName gain) noexcept;  ///< "k_xx", "k_tt", "k_yy"

}  // namespace skein::app
