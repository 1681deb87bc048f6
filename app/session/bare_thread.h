#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "app/run/histogram.h"

namespace skein::app {

/// A thread that only waits for absolute deadlines and notes how late it wakes: what the machine can do, beside what
/// the tick makes of it.
class BareThread {
 public:
  /// Starts it. `priority`: real-time priority, where the system grants it; 0: none. The first deadline is in one and a
  /// half periods [s], so that one beside a control loop of the same rate is not in its way.
  BareThread(double period, int priority);

  /// The priority that it got; 0: none, and why. Waits until the thread knows.
  int priority() const;
  std::string no_priority() const;

  /// Ends it, within a period. How late it woke.
  Histogram end();

 private:
  void wait_for_deadlines(const std::stop_token& stop, double period, int priority);

  Histogram late_;
  std::string no_priority_;
  int priority_ = 0;
  std::atomic<bool> knows_{false};
  std::jthread thread_;
};

}  // namespace skein::app
