#include "app/doctor/checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <set>
#include <sstream>
#include <utility>

namespace skein::app::detail {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;

Finding throttling(const Machine& machine) {
  const char* const subject = "real-time share";
  if (const char* const settings = "/proc/sys/kernel"; !is_there(machine, settings))
    return not_known(subject, settings);
  // Below zero: no limit.
  const double runtime = kernel_setting(machine, "/proc/sys/kernel/sched_rt_runtime_us", -1.0);
  const double period = kernel_setting(machine, "/proc/sys/kernel/sched_rt_period_us", 1e6);
  constexpr double least = 0.5;
  if (runtime < 0.0 || runtime >= least * period) return well(subject, "threads with real-time priority may run");
  return {State::ill,
          subject,
          runtime == 0.0
              ? std::string("kernel.sched_rt_runtime_us is 0: no thread with real-time priority may run")
              : fmt::format("kernel.sched_rt_runtime_us is {:g} of {:g}: threads with real-time priority stand "
                            "for the rest of the time",
                            runtime, period),
          "as root: sysctl kernel.sched_rt_runtime_us=950000",
          {{"sysctl", "kernel.sched_rt_runtime_us=950000"}}};
}

Finding governor(const Machine& machine) {
  const char* const subject = "CPU frequency";
  const char* const processors = "/sys/devices/system/cpu";
  if (!is_there(machine, processors)) return not_known(subject, processors);
  std::set<std::string> slow;
  for (const fs::path& policy : entries(below(machine, "/sys/devices/system/cpu/cpufreq"), "policy")) {
    const std::string governor = read(policy / "scaling_governor"), driver = read(policy / "scaling_driver");
    // The drivers of newer processors choose the frequency themselves: their "powersave" is what others call automatic.
    const bool automatic = governor == "powersave" && (driver == "intel_pstate" || driver == "amd-pstate-epp");
    if (!governor.empty() && governor != "performance" && !automatic) slow.insert(governor);
  }
  if (slow.empty()) return well(subject, "no governor slows the processor down");
  return {
      slow.contains("powersave") ? State::ill : State::note,
      subject,
      fmt::format("governor {}: the processor wakes slowly", fmt::join(slow, ", ")),
      "as root: for g in /sys/devices/system/cpu/cpufreq/policy*/scaling_governor; do echo performance > $g; done",
      {{"sh", "-c",
        "for g in /sys/devices/system/cpu/cpufreq/policy*/scaling_governor; do echo performance > $g || exit; done"}}};
}

Finding idle_states(const Machine& machine) {
  const char* const subject = "idle states";
  const char* const device = "/dev/cpu_dma_latency";
  const char* const rules = "/etc/udev/rules.d/60-skein-latency.rules";
  if (machine.usable(device)) return well(subject, "a run may keep the processors from deep ones");
  std::string found = fmt::format("{} cannot be written: an idle processor may wake 0.05 to 0.5 ms late", device);
  if ((is_there(machine, rules) || is_there(machine, rules_of_the_package)) && is_in_after_login(machine, "skein"))
    return {State::note, subject, std::move(found), in_the_next_session};
  return {State::note,
          subject,
          std::move(found),
          fmt::format("install skein-permissions, then as root: adduser {} skein; then log in again", machine.user),
          {{"addgroup", "--quiet", "--system", "skein"},
           {"sh", "-c", fmt::format("echo 'KERNEL==\"cpu_dma_latency\", GROUP=\"skein\", MODE=\"0660\"' > {}", rules)},
           {"udevadm", "control", "--reload"},
           {"udevadm", "trigger", "--sysname-match=cpu_dma_latency"},
           {"adduser", machine.user, "skein"}}};
}

Finding load(const Machine& machine) {
  const char* const subject = "load";
  const char* const file = "/proc/loadavg";
  std::istringstream text(read(below(machine, file)));
  double last_minute = 0.0;
  if (!(text >> last_minute)) return not_known(subject, file);
  const auto folders = entries(below(machine, "/sys/devices/system/cpu"), "cpu");
  const auto cores = std::max<std::ptrdiff_t>(
      1, std::count_if(folders.begin(), folders.end(), [](const fs::path& folder) {
        return std::isdigit(static_cast<unsigned char>(folder.filename().string().back())) != 0 &&
               read(folder / "online") != "0";  // the first has no such file
      }));
  const std::string found =
      fmt::format("{:.1f} threads at work on {} core{}", last_minute, cores, cores == 1 ? "" : "s");
  if (last_minute <= 0.75 * static_cast<double>(cores)) return well(subject, found);
  return {State::ill, subject, found, "close other programs; top says which"};
}

Finding memory(const Machine& machine) {
  const char* const subject = "memory";
  const char* const file = "/proc/meminfo";
  std::istringstream text(read(below(machine, file)));
  double available = -1.0;  // [kB]
  for (std::string line; std::getline(text, line);)
    if (line.starts_with("MemAvailable:")) available = std::stod(line.substr(13));
  if (available < 0.0) return not_known(subject, file);
  const std::string found = fmt::format("{:.0f} MB available", available / 1024.0);
  if (available >= 300.0 * 1024.0) return well(subject, found);
  return {State::ill, subject, found + ": swapped-out memory is slow to return", "close other programs"};
}

Finding clock_source(const Machine& machine) {
  const char* const subject = "clock";
  const char* const file = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  const std::string source = read(below(machine, file));
  if (source.empty()) return not_known(subject, file);
  const bool slow = source == "hpet" || source == "acpi_pm" || source == "jiffies" || source.starts_with("refined");
  if (!slow) return well(subject, source);
  return {State::note, subject, fmt::format("{}: reading the time is slow", source),
          "boot with tsc=reliable if the processor's counter can be relied on"};
}

std::string milliseconds(double seconds) {
  return fmt::format("{:.2f}", 1e3 * seconds);
}

}  // namespace

Findings check_computer(const Machine& machine) {
  return {throttling(machine),   governor(machine), idle_states(machine),
          clock_source(machine), load(machine),     memory(machine)};
}

Finding check_timing(const Machine& machine, double seconds) {
  const char* const subject = "keeping time";
  const Timing timing = machine.keep_time(seconds);
  constexpr double most = 2e-3;  // a twentieth of a period of 40 ms [s]
  const auto words = [](const Histogram& late) {
    return fmt::format("{} / {} / {} / {} ms", milliseconds(late.quantile(0.5)), milliseconds(late.quantile(0.99)),
                       milliseconds(late.quantile(0.999)), milliseconds(late.largest()));
  };
  std::string found =
      fmt::format("latency of bare threads (p50 / p99 / p99.9 / largest): ordinary {}", words(timing.bare));
  if (timing.priority > 0) found += fmt::format(", at real-time priority {}", words(timing.tick));
  if (timing.priority <= 0 && !timing.no_priority.empty() && (machine.rtprio < 0 || machine.rtprio >= control_priority))
    return {State::ill, subject,
            fmt::format("{}; real-time priority is granted, and yet a thread does not get it: {}", found,
                        timing.no_priority.substr(0, timing.no_priority.find(';'))),
            "the control group or the container of this session withholds it: start in another session, or outside it"};
  const Histogram& best = timing.priority > 0 ? timing.tick : timing.bare;
  if (best.quantile(0.99) <= most && best.largest() <= 10.0 * most) return well(subject, found);
  return {State::ill, subject, found,
          "a tick has 40 ms: fix the problems above; a virtual machine or power-saving firmware may be the cause"};
}

}  // namespace skein::app::detail
