#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "app/run/histogram.h"
#include "app/session/newest.h"

namespace skein::app {

/// A thread that only waits for absolute deadlines and records how late it wakes: the machine's latency, for comparison
/// with the tick's.
class BareThread {
 public:
  /// Starts it. `priority`: real-time priority, where the system grants it; 0: none. The first deadline is in one and a
  /// half periods [s], so that it does not disturb a control loop of the same rate.
  BareThread(double period, int priority);

  /// Its priority; 0: none, with the reason. Waits until the thread has set it.
  int priority() const;
  std::string no_priority() const;

  /// How late it has woken so far. One reading thread.
  const Histogram& so_far() noexcept;

  /// Ends it, within a period. Returns how late it woke.
  Histogram end();

 private:
  void wait_for_deadlines(const std::stop_token& stop, double period, int priority);

  Histogram late_;
  Newest<Histogram> newest_;
  std::string no_priority_;
  int priority_ = 0;
  std::atomic<bool> knows_{false};
  std::jthread thread_;
};

}  // namespace skein::app
