#include "comms/device_holder.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

namespace skein::comms {
namespace {

namespace fs = std::filesystem;

constexpr const char* lock_files = "/var/lock";
constexpr std::string_view lock_file_prefix = "LCK..";

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::optional<pid_t> number_in(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  pid_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || number <= 0) return {};
  return number;
}

/// Ten digits, in old programs the bytes of an int.
std::optional<pid_t> process_in(const fs::path& lock_file) {
  const std::string text = first_line(lock_file);
  if (const auto number = number_in(text)) return number;
  pid_t number = 0;
  if (text.size() != sizeof number) return {};
  std::memcpy(&number, text.data(), sizeof number);
  return number > 0 ? std::optional(number) : std::nullopt;
}

std::string named(pid_t process) {
  const std::string name = first_line(fmt::format("/proc/{}/comm", process));
  return fmt::format("{} (process {})", name.empty() ? "another program" : name, process);
}

enum class Opened { yes, no, hidden };
Opened has_open(pid_t process, const fs::path& device) {
  std::error_code error;
  fs::directory_iterator entry(fmt::format("/proc/{}/fd", process), error);
  if (error) return Opened::hidden;
  for (const fs::directory_iterator end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (fs::read_symlink(entry->path(), gone) == device) return Opened::yes;
  }
  return Opened::no;
}

/// "/dev/pts/3" has the lock file LCK..pts_3, a path outside /dev that of its last part.
std::string lock_file_of(const fs::path& device) {
  constexpr std::string_view devices = "/dev/";
  std::string name = device.string();
  name = name.starts_with(devices) ? name.substr(devices.size()) : device.filename().string();
  std::replace(name.begin(), name.end(), '/', '_');
  return std::string(lock_file_prefix) + name;
}

fs::path resolved(const std::string& device) {
  std::error_code error;
  const fs::path path = fs::canonical(device, error);
  return error ? fs::path(device) : path;
}

}  // namespace

std::string holder_by_lock_file(const std::string& device) {
  const fs::path path = resolved(device);
  std::error_code error;
  fs::directory_iterator entry(lock_files, error);
  for (const fs::directory_iterator end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(lock_file_prefix)) continue;
    const auto process = process_in(entry->path());
    if (!process || *process == ::getpid() || (::kill(*process, 0) != 0 && errno == ESRCH)) continue;
    switch (has_open(*process, path)) {
      case Opened::yes:  // under whatever name: a device has several
        return named(*process);
      case Opened::no:  // a later process with the number of one that left its file behind
        continue;
      case Opened::hidden:
        if (name == lock_file_of(path) || name == lock_file_of(device)) return named(*process);
    }
  }
  return {};
}

std::string holder_by_flock(int descriptor) {
  struct stat device {};
  if (::fstat(descriptor, &device) != 0) return {};
  const std::string place =
      fmt::format(" {:02x}:{:02x}:{} ", major(device.st_dev), minor(device.st_dev), device.st_ino);
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    // "1: FLOCK  ADVISORY  WRITE 8760 00:1a:3 0 EOF"
    const auto at = line.find(place);
    if (at == std::string::npos || line.find("FLOCK") == std::string::npos) continue;
    const auto process = number_in(std::string_view(line).substr(line.rfind(' ', at - 1) + 1));
    if (process && *process != ::getpid()) return named(*process);
  }
  return {};
}

std::string holder_by_opening(const std::string& device) {
  const fs::path path = resolved(device);
  std::error_code error;
  fs::directory_iterator entry("/proc", error);
  for (const fs::directory_iterator end; !error && entry != end; entry.increment(error)) {
    const auto process = number_in(entry->path().filename().string());
    if (process && *process != ::getpid() && has_open(*process, path) == Opened::yes) return named(*process);
  }
  return {};
}

}  // namespace skein::comms
