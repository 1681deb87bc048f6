#include "app/runs/machine.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <array>
#include <ctime>
#include <fstream>
#include <thread>

#include "app/run/privileges.h"

namespace skein::app {
namespace {

std::string first_line(const char* path) {
  std::string line;
  std::ifstream file(path);
  std::getline(file, line);
  return line;
}

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const std::size_t colon = line.find(": "); colon != std::string::npos) return line.substr(colon + 2);
  return {};
}

std::string formatted(const std::tm& time, const char* format) {
  std::array<char, 64> text{};
  return std::string(text.data(), std::strftime(text.data(), text.size(), format, &time));
}

std::tm local(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm result{};
  ::localtime_r(&seconds, &result);
  return result;
}

}  // namespace

MachineDescription describe_machine() {
  MachineDescription machine;
  utsname names{};
  if (::uname(&names) == 0) {
    machine.host = names.nodename;
    machine.kernel = fmt::format("{} {}", names.release, names.version);
    machine.architecture = names.machine;
  }
  machine.cpu = cpu_name();
  machine.cores = std::thread::hardware_concurrency();
  machine.governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  machine.realtime_kernel = first_line("/sys/kernel/realtime") == "1";
  constexpr std::int64_t highest = 99;
  const long limit = real_time_priority_limit();
  machine.realtime_priority = limit < 0 ? highest : limit;
  return machine;
}

std::string local_time(std::chrono::system_clock::time_point time) {
  using std::chrono::milliseconds;
  const auto since = std::chrono::floor<milliseconds>(time.time_since_epoch());
  const std::tm parts = local(time);
  std::string zone = formatted(parts, "%z");  // +0100
  if (zone.size() == 5) zone.insert(3, ":");
  return formatted(parts, "%Y-%m-%dT%H:%M:%S") + fmt::format(".{:03}{}", (since.count() % 1000 + 1000) % 1000, zone);
}

std::string time_for_name(std::chrono::system_clock::time_point time) {
  return formatted(local(time), "%Y-%m-%d_%H%M%S");
}

}  // namespace skein::app
