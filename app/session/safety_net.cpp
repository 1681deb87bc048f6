#include "app/session/safety_net.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <utility>

#include "app/run/exit_status.h"
#include "comms/link_supervisor.h"

extern char** environ;

namespace skein::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view first_line = "skein run ";
constexpr std::string_view prefix = "run-";
constexpr char all_is_well = 'q';
constexpr double reach_timeout = 15.0;  // a Bluetooth connection takes a few seconds, and may meet a busy robot [s]
constexpr double stop_timeout = 2.0;    // [s]

fs::path state_directory() {
  if (const char* const state = std::getenv("XDG_STATE_HOME"); state && *state == '/') return fs::path(state) / "skein";
  const char* const home = std::getenv("HOME");
  return fs::path(home && *home ? home : "/tmp") / ".local/state/skein";
}

std::string marker_text(const std::string& name, const std::vector<comms::LinkAddress>& robots) {
  std::string text = fmt::format("{}{}\n", first_line, name);
  for (const comms::LinkAddress& robot : robots)
    text += fmt::format("{}\t{}\t{}\n", comms::to_text(robot), robot.adapter, robot.name);
  return text;
}

/// A new, locked marker file; its descriptor.
tl::expected<int, std::string> write_marker(const fs::path& path, const std::string& text) {
  const auto failed = [&] {
    return tl::unexpected(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
  };
  std::error_code ignored;
  fs::create_directories(path.parent_path(), ignored);  // what is wrong with it, open() says
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0) return failed();
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 ||
      ::write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size()) || ::fsync(file) != 0) {
    auto error = failed();
    ::close(file);
    ::unlink(path.c_str());
    return error;
  }
  return file;
}

/// Whether the run that wrote it is still there.
bool alive(const std::string& marker) {
  const int file = ::open(marker.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool locked = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return locked;
}

/// Connects, stops, and says how that went; empty: the robot has acknowledged.
std::string stop_one(const comms::LinkAddress& address) {
  comms::LinkSupervisor link({address}, {.close_timeout = stop_timeout});  // one each: none waits for another
  const auto started = link.start(reach_timeout);
  const comms::LinkStatus status = link.close(stop_timeout).at(0);
  if (status.stop_acknowledged) return {};
  return started || !status.reason.empty() ? status.reason : started.error();
}

}  // namespace

tl::expected<RunMarker, std::string> RunMarker::read(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line) || !line.starts_with(first_line))
    return tl::unexpected(fmt::format("{}: is no record of a run", path));
  RunMarker marker{path, line.substr(first_line.size()), {}};
  while (std::getline(in, line)) {
    const std::size_t tab = std::min(line.find('\t'), line.size()),
                      second = std::min(line.find('\t', tab + 1), line.size());
    auto address = comms::parse_link_address(line.substr(0, tab));
    if (!address) return tl::unexpected(fmt::format("{}: {}", path, address.error()));
    if (tab < line.size()) address->adapter = line.substr(tab + 1, second - tab - 1);
    if (second < line.size()) address->name = line.substr(second + 1);
    marker.robots.push_back(std::move(*address));
  }
  return marker;
}

std::string RunMarker::names() const {
  std::vector<std::string> names;
  for (const comms::LinkAddress& robot : robots) names.push_back(comms::to_text(robot));
  return fmt::format("{}", fmt::join(names, ", "));
}

bool stop_left_behind(const std::vector<RunMarker>& runs) {
  bool all_stand = true;
  for (const RunMarker& run : runs) {
    const bool stand = stop_all(run.robots);
    std::error_code gone;  // the guard may have forgotten the run meanwhile
    if (stand) fs::remove(run.path, gone);
    all_stand = all_stand && stand;
  }
  return all_stand;
}

std::vector<RunMarker> bad_ends() {
  std::vector<std::pair<fs::file_time_type, RunMarker>> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(state_directory(), error)) {
    const std::string path = entry.path().string();
    if (!entry.path().filename().string().starts_with(prefix) || alive(path)) continue;
    if (auto marker = RunMarker::read(path)) found.emplace_back(entry.last_write_time(error), std::move(*marker));
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<RunMarker> markers;
  for (auto& [when, marker] : found) markers.push_back(std::move(marker));
  return markers;
}

tl::expected<SafetyNet, std::string> SafetyNet::spread(const Experiment& experiment, const std::string& program) {
  const auto robots = real_robots(experiment);
  if (!robots) return tl::unexpected(robots.error());
  return spread(experiment.name, *robots, program);
}

tl::expected<SafetyNet, std::string> SafetyNet::spread(const std::string& name,
                                                       const std::vector<comms::LinkAddress>& robots,
                                                       const std::string& program) {
  SafetyNet net;
  if (robots.empty()) return net;
  const fs::path path = state_directory() / fmt::format("{}{}", prefix, ::getpid());
  const auto file = write_marker(path, marker_text(name, robots));
  if (!file) return tl::unexpected(file.error());
  net.marker_ = *file;
  net.path_ = path.string();

  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return tl::unexpected(fmt::format("no guard: {}", std::strerror(errno)));
  net.pipe_ = ends[1];
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);  // Ctrl-C is for the run, not for its guard
  const std::string executable = program.empty() ? "/proc/self/exe" : program;
  std::string zero = "skein", word = "guard";
  char* const arguments[] = {zero.data(), word.data(), net.path_.data(), nullptr};
  const int error = ::posix_spawn(&net.guard_, executable.c_str(), &files, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  ::close(ends[0]);
  if (error != 0) {
    net.guard_ = -1;
    return tl::unexpected(fmt::format("no guard: {}", std::strerror(error)));
  }
  return net;
}

SafetyNet::SafetyNet(SafetyNet&& other) noexcept
    : path_(std::move(other.path_)),
      marker_(std::exchange(other.marker_, -1)),
      pipe_(std::exchange(other.pipe_, -1)),
      guard_(std::exchange(other.guard_, -1)) {}
SafetyNet& SafetyNet::operator=(SafetyNet&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(marker_, other.marker_);
  std::swap(pipe_, other.pipe_);
  std::swap(guard_, other.guard_);
  return *this;
}
SafetyNet::~SafetyNet() {
  if (marker_ >= 0) ::close(marker_);
  if (pipe_ >= 0) ::close(pipe_);
}

void SafetyNet::done(const std::vector<RobotStatus>& robots) {
  if (marker_ < 0) return;
  const bool stand =
      std::all_of(robots.begin(), robots.end(), [](const RobotStatus& r) { return r.stop_acknowledged; });
  if (stand) {
    [[maybe_unused]] const auto written = ::write(pipe_, &all_is_well, 1);
    ::unlink(path_.c_str());
  }
  ::close(std::exchange(pipe_, -1));
  ::close(std::exchange(marker_, -1));
  if (stand && guard_ > 0) ::waitpid(guard_, nullptr, 0);
  guard_ = -1;
}

int guard(const std::string& marker, int descriptor) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_IGN);
  const auto run = RunMarker::read(marker);  // now: it must not depend on a disk later
  char said = 0;
  ssize_t count;
  while ((count = ::read(descriptor, &said, 1)) < 0 && errno == EINTR) {
  }
  if (count == 1 && said == all_is_well) return done;
  if (!run) {
    fmt::print(stderr, "skein guard: {}\n", run.error());
    return wrong_input;
  }
  fmt::print(stderr, "skein guard: the run \"{}\" ended without stopping its robots; stopping them\n", run->experiment);
  if (!stop_all(run->robots)) return device_failed;
  ::unlink(marker.c_str());
  return done;
}

tl::expected<comms::LinkAddress, std::string> link_of(const Experiment& experiment, std::size_t robot) {
  const RobotSpec& spec = experiment.robots[robot];
  auto address = comms::parse_link_address(spec.address);
  if (!address) return tl::unexpected(fmt::format("{}: {}", robot_name(experiment, robot), address.error()));
  address->adapter = spec.adapter;
  address->name = robot_name(experiment, robot);
  return address;
}

tl::expected<std::vector<comms::LinkAddress>, std::string> real_robots(const Experiment& experiment) {
  std::vector<comms::LinkAddress> addresses;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    if (experiment.robots[i].simulated()) continue;
    auto address = link_of(experiment, i);
    if (!address) return tl::unexpected(address.error());
    addresses.push_back(std::move(*address));
  }
  return addresses;
}

bool stop_all(const std::vector<comms::LinkAddress>& robots) {
  std::vector<std::future<std::string>> stops;
  for (const comms::LinkAddress& address : robots)
    stops.push_back(std::async(std::launch::async, [&address] { return stop_one(address); }));
  bool all = true;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const std::string failure = stops[i].get();
    const std::string name = comms::to_text(robots[i]);
    if (failure.empty()) {
      fmt::print("{}: stopped\n", name);
    } else {
      fmt::print(stderr, "skein: {}: NOT known to be stopped: {}\n", name, failure);
      all = false;
    }
  }
  std::fflush(stdout);
  return all;
}

}  // namespace skein::app
