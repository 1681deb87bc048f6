#pragma once

#include <string>

#include "app/run/histogram.h"

namespace skein::app {

/// How well a run kept time on the wall clock: its timing certificate.
struct Timing {
  Histogram tick;    ///< how late each tick began, after its deadline or the frame that it waited for [s]
  Histogram bare;    ///< how late a thread woke that does nothing else, at the same rate and priority beside it [s]
  int priority = 0;  ///< real-time priority (SCHED_FIFO) of both; 0: none
  std::string no_priority;  ///< why there is none
};

/// What the control thread asks for; links and guard stand above it.
inline constexpr int control_priority = 20;

/// Asks for real-time priority for the calling thread. Empty: granted; else why not, and who says what to do.
std::string ask_for_priority(int priority);

}  // namespace skein::app
