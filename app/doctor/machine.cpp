#include "app/doctor/machine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <spawn.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <thread>

#include "app/controllers/own_controller.h"
#include "app/guard/run_marker.h"
#include "app/run/memory_lock.h"
#include "app/run/privileges.h"
#include "app/runs/run_folder.h"
#include "app/session/bare_thread.h"
#include "comms/bluez_bus.h"
#include "vision/sources/modules_present.h"
#include "vision/sources/open_source.h"

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace skein::app {
namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

std::vector<std::string> groups_of_this_process() {
  std::vector<gid_t> ids(static_cast<std::size_t>(std::max(0, ::getgroups(0, nullptr))));
  const int count = ::getgroups(static_cast<int>(ids.size()), ids.data());
  ids.resize(static_cast<std::size_t>(std::max(0, count)));
  ids.push_back(::getegid());
  std::vector<std::string> names;
  for (const gid_t id : ids)
    if (const ::group* const entry = ::getgrgid(id); entry != nullptr) names.emplace_back(entry->gr_name);
  return names;
}

tl::expected<std::vector<BluetoothAdapter>, std::string> ask_the_daemon() {
  auto bus = comms::BluezBus::open();
  if (!bus) return tl::unexpected(bus.error());
  const auto objects = bus->objects();
  if (!objects) return tl::unexpected(objects.error());
  std::vector<BluetoothAdapter> adapters;
  for (const comms::BluezAdapter& adapter : objects->adapters)
    adapters.push_back({adapter.name(), adapter.address, adapter.powered});
  return adapters;
}

/// Four megabytes, as fast as they are on the disk for good.
tl::expected<double, std::string> write_here() {
  constexpr std::size_t block = 1 << 18, blocks = 16;
  std::string name = ".skein-doctor-XXXXXX";
  const int file = ::mkostemp(name.data(), O_CLOEXEC);
  const auto failed = [&] {
    const std::string why = std::strerror(errno);
    std::error_code gone;
    const std::string here = std::filesystem::current_path(gone).string();
    return tl::unexpected(
        fmt::format("nothing can be written here ({}): {}", gone ? "a folder that was removed" : here, why));
  };
  if (file < 0) return failed();
  ::unlink(name.c_str());
  const std::vector<char> bytes(block, 'x');
  const auto began = std::chrono::steady_clock::now();
  bool well = true;
  for (std::size_t k = 0; k < blocks && well; ++k)
    well = ::write(file, bytes.data(), block) == static_cast<ssize_t>(block);
  well = well && ::fdatasync(file) == 0;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  if (!well) {
    auto error = failed();
    ::close(file);
    return error;
  }
  ::close(file);
  return static_cast<double>(block * blocks) / std::max(1e-6, took.count());
}

double free_in(const std::string& folder) {
  struct statvfs disk {};
  return ::statvfs(folder.c_str(), &disk) == 0 ? static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize)
                                               : 0.0;
}

Timing two_bare_threads(double seconds) {
  constexpr double period = 0.04;
  const CpuLatencyLimit awake;  // as in a run
  BareThread ordinary(period, 0), real_time(period, control_priority);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  Timing timing;
  timing.priority = real_time.priority();
  timing.no_priority = real_time.no_priority();
  timing.tick = real_time.end();
  timing.bare = ordinary.end();
  return timing;
}

/// Writes a marker as a run does, of no robot, and removes it.
tl::expected<std::string, std::string> try_the_guard() {
  RunMarker marker;
  marker.experiment = "skein doctor";
  const auto written = write_marker(marker);
  if (!written) return tl::unexpected(written.error());
  marker.forget();
  ::close(written->lock);
  if (::access("/proc/self/exe", X_OK) != 0)
    return tl::unexpected(std::string("/proc is not there: the guard cannot be started"));
  return written->problem;
}

/// Where it is, in the first of the folders that has it; empty: in none.
std::string found_in(const std::string& path, const std::string& program) {
  std::istringstream folders(path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (std::string file = fmt::format("{}/{}", folder, program); ::access(file.c_str(), X_OK) == 0) return file;
  return {};
}

bool on_the_path(const std::string& program) {
  return !found_in(variable("PATH"), program).empty();
}

tl::expected<void, std::string> execute(const std::vector<std::string>& command) {
  std::vector<std::string> words = command;
  if (::geteuid() != 0) words.insert(words.begin(), "sudo");
  // After `su` the path is still that of the user, without the folders of what only root needs.
  const std::string program = found_in(variable("PATH") + ":/usr/sbin:/sbin", words.front());
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error =
      program.empty() ? ENOENT : ::posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ);
  if (error != 0) return tl::unexpected(fmt::format("{} cannot be started: {}", words.front(), std::strerror(error)));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFSIGNALED(status)) return tl::unexpected(fmt::format("{} was ended by a signal", command.front()));
  if (WEXITSTATUS(status) != 0)
    return tl::unexpected(fmt::format("{} ended with status {}", command.front(), WEXITSTATUS(status)));
  return {};
}

}  // namespace

Machine this_machine() {
  Machine machine;
  const passwd* const entry = ::getpwuid(::getuid());
  machine.user = entry != nullptr ? entry->pw_name : std::to_string(::getuid());
  machine.superuser = ::geteuid() == 0;
  machine.groups = groups_of_this_process();
  machine.rtprio = real_time_priority_limit();
  machine.memlock = memory_lock_limit();
  machine.display = variable("DISPLAY").empty() ? variable("WAYLAND_DISPLAY") : variable("DISPLAY");
  machine.usable = [](const std::string& path) { return ::access(path.c_str(), R_OK | W_OK) == 0; };
  machine.adapters = ask_the_daemon;
  machine.keep_time = two_bare_threads;
  machine.disk_speed = write_here;
  machine.disk_free = [] { return free_in("."); };
  machine.runs_directory = [] { return runs_directory(""); };
  machine.free_in = free_in;
  machine.guard = try_the_guard;
  machine.bad_ends = [] {
    std::vector<std::string> names;
    for (const RunMarker& marker : bad_ends()) names.push_back(marker.experiment);
    return names;
  };
  machine.network_cameras = [](const vision::SourceKind& kind) {
    std::vector<std::string> names;
    const auto cameras = kind.connected();
    if (!cameras) return names;
    for (const vision::ConnectedCamera& camera : *cameras) {
      names.push_back(camera.where);
      names.push_back(camera.also);
    }
    return names;
  };
  machine.modules = vision::modules_present;
  machine.start_controller = [](const Experiment& experiment) -> tl::expected<void, std::string> {
    const auto own = OwnController::start(experiment, /*waits=*/true, {.prints = false});
    if (!own) return tl::unexpected(own.error());
    return {};
  };
  machine.has_program = on_the_path;
  machine.execute = execute;
  return machine;
}

}  // namespace skein::app
