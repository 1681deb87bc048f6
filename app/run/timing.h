#pragma once

#include <string>

#include "app/run/histogram.h"

namespace skein::app {

/// The timing certificate of a run on the wall clock.
struct Timing {
  Histogram tick;           ///< how late each tick began, after its deadline or the frame that it waited for [s]
  Histogram bare;           ///< how late an otherwise idle thread woke, at the same rate and priority [s]
  int priority = 0;         ///< real-time priority (SCHED_FIFO) of both; 0: none
  std::string no_priority;  ///< why there is none
};

/// The priority of the control thread; links and guard have higher ones.
inline constexpr int control_priority = 20;

/// Requests real-time priority for the calling thread. Empty: granted; else the reason, and where the remedy is.
std::string ask_for_priority(int priority);

}  // namespace skein::app
