#pragma once

#include <optional>
#include <string>

#include "app/run/histogram.h"

namespace skein::app {

/// The timing certificate of a run on the wall clock.
struct Timing {
  Histogram tick;                  ///< how late each tick began, after its deadline or the frame that it waited for [s]
  Histogram bare;                  ///< how late an otherwise idle thread woke, at the same rate and priority [s]
  int priority = 0;                ///< real-time priority (SCHED_FIFO) of both; 0: none
  std::string no_priority;         ///< why there is none
  std::optional<int> cpu_latency;  ///< the limit that the kernel was asked for, see CpuLatencyLimit [us]
  std::string no_cpu_latency;      ///< why there is none
  bool memory_locked = false;      ///< the program is kept in memory, see MemoryLock
  std::string no_memory_lock;      ///< why not, though it was asked for
};

/// The priority of the control thread; links and guard have higher ones, the threads that turn frames into poses a
/// lower one, so that other programs do not delay poses and the tick never waits for a picture.
inline constexpr int control_priority = 20;
inline constexpr int camera_priority = 10;

/// Requests real-time priority for the calling thread. Empty: granted; otherwise the reason, and where to find the
/// remedy.
std::string ask_for_priority(int priority);

/// Limits how long a processor may take to wake: the CPU latency request of the kernel's PM QoS interface, in force as
/// long as this object lives. Otherwise a processor that was idle between two ticks wakes 50 to 500 us late. It costs
/// power, so that only a run with links, a camera or a controller of the user's holds one.
class CpuLatencyLimit {
 public:
  struct Interface {
    const char* device = "/dev/cpu_dma_latency";
    const char* driver = "/sys/devices/system/cpu/cpuidle/current_driver";
  };
  CpuLatencyLimit() : CpuLatencyLimit(Interface{}) {}
  explicit CpuLatencyLimit(const Interface& kernel);
  ~CpuLatencyLimit();
  CpuLatencyLimit(const CpuLatencyLimit&) = delete;
  CpuLatencyLimit& operator=(const CpuLatencyLimit&) = delete;

  /// [us]; none: the kernel refused, for this reason.
  std::optional<int> granted() const { return granted_; }
  const std::string& refused() const { return refused_; }

 private:
  int device_ = -1;
  std::optional<int> granted_;
  std::string refused_;
};

}  // namespace skein::app
