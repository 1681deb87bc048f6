#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace skein::app {

/// The machine of a run.
struct MachineDescription {
  std::string host, kernel, architecture, cpu;
  std::int64_t cores = 0;
  std::string governor;                ///< of the first core; empty: not known
  bool realtime_kernel = false;        ///< PREEMPT_RT
  std::int64_t realtime_priority = 0;  ///< largest for this process; 0: none, so that its threads have normal priority
};
MachineDescription describe_machine();

/// The processor by the text of /proc/cpuinfo. Where that has no name of it, as on ARM: `model`, the computer's name in
/// its device tree, ended by 0; or else the numbers of its maker and part.
std::string cpu_name(std::string_view cpuinfo, std::string_view model);

/// "2026-11-20T20:15:01.123+01:00": local time with its distance from UTC.
std::string local_time(std::chrono::system_clock::time_point time);

/// "2026-11-20_201501", the same for a file's name.
std::string time_for_name(std::chrono::system_clock::time_point time);

}  // namespace skein::app
