#include "app/runs/machine.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>
#include <iterator>
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

std::string text_of(const char* path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// What stands behind the colon in the first line of a key.
std::string_view value_of(std::string_view cpuinfo, std::string_view key) {
  while (!cpuinfo.empty()) {
    const std::string_view line = cpuinfo.substr(0, cpuinfo.find('\n'));
    cpuinfo.remove_prefix(std::min(cpuinfo.size(), line.size() + 1));
    const std::size_t colon = line.find(": ");
    if (line.starts_with(key) && colon != std::string_view::npos) return line.substr(colon + 2);
  }
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

std::string cpu_name(std::string_view cpuinfo, std::string_view model) {
  if (const std::string_view name = value_of(cpuinfo, "model name"); !name.empty()) return std::string(name);
  if (model = model.substr(0, model.find('\0')); !model.empty()) return std::string(model);
  const std::string_view maker = value_of(cpuinfo, "CPU implementer"), part = value_of(cpuinfo, "CPU part");
  return maker.empty() ? std::string() : fmt::format("ARM, implementer {}, part {}", maker, part);
}

MachineDescription describe_machine() {
  MachineDescription machine;
  utsname names{};
  if (::uname(&names) == 0) {
    machine.host = names.nodename;
    machine.kernel = fmt::format("{} {}", names.release, names.version);
    machine.architecture = names.machine;
  }
  machine.cpu = cpu_name(text_of("/proc/cpuinfo"), text_of("/proc/device-tree/model"));
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
