#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "comms/link_address.h"
#include "comms/link_options.h"
#include "comms/link_status.h"
#include "comms/round_trips.h"

namespace skein::comms {

/// Keeps the links to a group of robots, on one thread of its own for all of them.
///
/// Every robot has a slot for its newest command and at most one pending question. A link that is opened or that lost a
/// reply sends the stop sequence first. A reconnected robot stays stopped until a new command comes. The thread updates
/// a Heart (watchdog.h): if it stalls for 0.3 s, or for the time that a robot may go without a command if that is
/// longer, the guard stops the robots.
/// Robots are counted from 0 here and from 1 in every sentence, unless their addresses name them. Only the constructor
/// throws, bad_alloc.
class LinkSupervisor {
 public:
  /// Resolves the names of WiFi robots; blocks meanwhile.
  explicit LinkSupervisor(std::vector<LinkAddress> robots, LinkOptions options = {});
  ~LinkSupervisor();  ///< close() with options.close_timeout
  LinkSupervisor(const LinkSupervisor&) = delete;
  LinkSupervisor& operator=(const LinkSupervisor&) = delete;

  /// Opens every link and stops every robot; returns when all are up. Otherwise the sentence names the robot and why,
  /// and all links are closed again: a supervisor is started once. `keep_on` is called several times per second
  /// meanwhile; false ends it likewise.
  tl::expected<void, std::string> start(double timeout_s, const std::function<bool()>& keep_on = {});
  /// The same, but a robot that does not answer is no error: returns when each is up or given up, or when the time is
  /// over. The supervisor keeps trying the others, and status() has the reason.
  tl::expected<void, std::string> start_who_answers(double timeout_s, const std::function<bool()>& keep_on = {});

  /// Puts the newest wheel speeds [steps/s] into a robot's slot (clamped, see asercom.h); older ones not yet sent are
  /// forgotten. Lock-free and wait-free: atomics and one write to an eventfd. Ignored while stopped by emergency_stop()
  /// and for a robot that does not exist. One thread at a time per robot.
  void command(std::size_t robot, int left, int right) noexcept;

  /// Stops every robot and keeps it stopped: each link sends the stop sequence at once, even with a reply outstanding,
  /// and repeats it until the robot answers; commands given before, or from now until release_stop(), are void. Any
  /// thread; async-signal-safe.
  void emergency_stop() noexcept;
  /// Accepts commands again. Robots stay stopped until the next command.
  void release_stop() noexcept;
  bool stopped() const noexcept;  ///< between emergency_stop() and release_stop()

  /// How long the program's stall lasted that caused an emergency stop, see LinkOptions::standstill [s]; 0: there was
  /// none. Any thread.
  double stood_still() const noexcept;

  /// Blocks until every robot has answered its newest command (commands voided by an emergency stop need no answer);
  /// false: not within `timeout_s`. For runs in lock-step. Any thread.
  bool wait_acknowledged(double timeout_s);

  /// Sends a robot nothing for this long, unless it must be stopped: to test its watchdog. Any thread.
  void hush(std::size_t robot, double seconds);

  /// When this robot's newest command was written and its newest answer arrived. Any thread; wait-free.
  CommandTimes times(std::size_t robot) const noexcept;

  /// A snapshot, in the order of the robots. Any thread; waits at most for one turn of the link thread (microseconds).
  std::vector<LinkStatus> status() const;

  /// The round trips of a robot's link. Any thread; waits as status() does.
  RoundTrips round_trips(std::size_t robot) const;

  /// Stops every robot, repeating until each has acknowledged or the time is over (a lost link is reconnected to do so;
  /// an attempt under way at the end of the time is awaited, at most for options.connect_timeout and a second); then
  /// closes the links and ends the thread. The final status: `stop_acknowledged` says for each robot whether it is
  /// known to stand. Idempotent: a second call returns the same.
  std::vector<LinkStatus> close(double timeout_s);

  std::size_t size() const noexcept;

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

/// How long it may take until each of these robots has been reached once [s]: an adapter pages one robot at a time, up
/// to 5.12 s each, and the others wait in a queue.
double reach_patience(const std::vector<LinkAddress>& robots);

/// How long an attempt to reach one of them may take before it is restarted [s], including its wait in the queue; at
/// least `alone`, which suffices for a robot alone on its adapter.
double connect_patience(const std::vector<LinkAddress>& robots, std::size_t robot, double alone);

}  // namespace skein::comms
