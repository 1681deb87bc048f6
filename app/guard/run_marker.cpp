#include "app/guard/run_marker.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <utility>

namespace skein::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view first_line = "skein run ";
constexpr std::string_view prefix = "run-";
constexpr std::string_view socket_end = ".stop";
constexpr std::size_t longest_marker = 64 * 1024;

bool owned(const struct stat& what) noexcept {
  return what.st_uid == ::geteuid() && (what.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Whether markers there are this user's alone. If the directory cannot be made, writing the marker will report why.
bool trustworthy(const fs::path& directory) {
  std::error_code ignored;
  if (!fs::exists(directory, ignored)) {
    fs::create_directories(directory.parent_path(), ignored);
    ::mkdir(directory.c_str(), 0700);
  }
  struct stat found {};
  if (::lstat(directory.c_str(), &found) != 0) return errno == ENOENT || errno == ENOTDIR;
  return S_ISDIR(found.st_mode) && owned(found);
}

/// Where markers go, and are looked for, beside the state directory: when its disk is full or read-only a run must be
/// guarded all the same. The names depend on the state directory, so that who has another sees other runs.
std::vector<fs::path> spare_directories(const std::string& state) {
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : state) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  const auto user = ::geteuid();
  std::vector<fs::path> bases{fmt::format("/run/user/{}", user), "/dev/shm", "/tmp"};
  if (const char* const runtime = std::getenv("XDG_RUNTIME_DIR"); runtime && *runtime == '/')
    bases.insert(bases.begin(), runtime);
  std::vector<fs::path> spare;
  for (const fs::path& base : bases)
    if (fs::path there = base / fmt::format("skein-{}-{:016x}", user, hash);
        fs::is_directory(base) && std::find(spare.begin(), spare.end(), there) == spare.end())
      spare.push_back(std::move(there));
  return spare;
}

std::string marker_text(const RunMarker& marker) {
  std::string text = fmt::format("{}{}\n", first_line, marker.experiment);
  for (const comms::LinkAddress& robot : marker.robots) {
    const auto resolved = comms::resolve(robot);
    text += fmt::format("{}\t{}\t{}\n", comms::to_text(resolved ? *resolved : robot), robot.adapter, robot.name);
  }
  return text;
}

}  // namespace

std::string state_directory() {
  std::vector<fs::path> candidates;
  const auto from = [&](const char* variable, const char* below) {
    if (const char* const value = std::getenv(variable); value && *value == '/')
      candidates.push_back(fs::path(value) / below);
  };
  from("XDG_STATE_HOME", "skein");
  from("HOME", ".local/state/skein");
  from("XDG_RUNTIME_DIR", "skein");
  const auto user = ::geteuid();
  if (fs::path runtime = fmt::format("/run/user/{}", user); fs::is_directory(runtime))
    candidates.push_back(runtime / "skein");
  candidates.push_back(fmt::format("/tmp/skein-{}", user));
  const auto found = std::find_if(candidates.begin(), candidates.end(), trustworthy);
  return (found == candidates.end() ? candidates.back() : *found).string();
}

std::string RunMarker::names() const {
  std::string names;
  for (const comms::LinkAddress& robot : robots) names += (names.empty() ? "" : ", ") + comms::to_text(robot);
  return names;
}

bool RunMarker::alive() const {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return false;
  const bool locked = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return locked;
}

void RunMarker::forget() const {
  ::unlink(socket().c_str());
  ::unlink(path.c_str());
}

void RunMarker::dismiss() const {
  if (const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK); file >= 0) {
    [[maybe_unused]] const auto written = ::pwrite(file, dismissal.data(), dismissal.size(), 0);
    ::close(file);
  }
  forget();
}

tl::expected<RunMarker, std::string> RunMarker::read(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  struct stat found {};
  std::string text(longest_marker, '\0');
  ssize_t size = -1;
  const bool ours = file >= 0 && ::fstat(file, &found) == 0 && S_ISREG(found.st_mode) && owned(found);
  if (ours) size = ::read(file, text.data(), text.size());
  if (file >= 0) ::close(file);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, size)));
  if (!text.starts_with(first_line)) return tl::unexpected(fmt::format("{}: is not the marker of a run", path));
  RunMarker marker{path, {}, {}};
  std::string_view rest = text;
  const auto next = [&rest](char end) {
    const std::size_t at = std::min(rest.find(end), rest.size());
    const std::string_view part = rest.substr(0, at);
    rest.remove_prefix(std::min(at + 1, rest.size()));
    return part;
  };
  marker.experiment = next('\n').substr(first_line.size());
  std::string problem;
  while (!rest.empty()) {
    std::string_view line = next('\n'), all = rest;
    rest = std::exchange(line, {});
    const std::string_view link = next('\t'), adapter = next('\t'), name = rest;
    rest = all;
    auto address = comms::parse_link_address(link);
    if (!address) {
      problem = fmt::format("{}: {}", path, address.error());  // the others are stopped all the same
      continue;
    }
    address->adapter = adapter;
    address->name = name;
    marker.robots.push_back(std::move(*address));
  }
  if (!problem.empty() && marker.robots.empty()) return tl::unexpected(problem);
  return marker;
}

namespace {

std::string new_name() {
  std::uint64_t random = 0;
  if (::getrandom(&random, sizeof random, 0) != sizeof random) random = static_cast<std::uint64_t>(::getpid());
  return fmt::format("{}{:%Y%m%d-%H%M%S}-{:016x}", prefix, fmt::gmtime(std::time(nullptr)), random);
}

tl::expected<int, std::string> write_there(const RunMarker& marker) {
  const auto failed = [&] {
    return tl::unexpected(fmt::format("{}: cannot be written: {}", marker.path, std::strerror(errno)));
  };
  const std::string text = marker_text(marker);
  const int file = ::open(marker.path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) return failed();
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 ||
      ::write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size()) || ::fsync(file) != 0) {
    auto error = failed();
    ::close(file);
    ::unlink(marker.path.c_str());
    return error;
  }
  // The name as well: if a power cut removed the marker, its robots would be unknown.
  if (const int directory = ::open(fs::path(marker.path).parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      directory >= 0) {
    ::fsync(directory);
    ::close(directory);
  }
  return file;
}

}  // namespace

tl::expected<WrittenMarker, std::string> write_marker(RunMarker& marker) {
  const std::string state = state_directory(), name = new_name();
  marker.path = state + "/" + name;
  const auto lock = write_there(marker);
  if (lock) return WrittenMarker{*lock, {}};
  for (const fs::path& spare : spare_directories(state)) {
    if (!trustworthy(spare)) continue;
    marker.path = (spare / name).string();
    if (const auto other = write_there(marker))
      return WrittenMarker{*other,
                           fmt::format("{}; it is {}, which may not outlive the machine", lock.error(), marker.path)};
  }
  return tl::unexpected(lock.error());
}

void rewrite_marker(int descriptor, const RunMarker& marker) noexcept {
  try {
    const std::string text = marker_text(marker);
    // Shorter than what is there: it fits, and then the rest goes.
    if (::pwrite(descriptor, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()) &&
        ::ftruncate(descriptor, static_cast<off_t>(text.size())) == 0)
      ::fsync(descriptor);
  } catch (...) {  // it names more robots than it need
  }
}

namespace {

/// Why there may be a marker of this name that is not read, such as too many open files; 0: there is none.
int why_unreadable(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file >= 0) return ::close(file), 0;
  return errno == ENOENT || errno == ELOOP ? 0 : errno;
}

}  // namespace

FoundMarkers find_markers() {
  FoundMarkers markers;
  const auto cannot_read = [&](const fs::path& path, int why) {
    markers.unreadable = fmt::format("{}: cannot be read: {}; a run that is not found here is not stopped",
                                     path.string(), std::strerror(why));
  };
  std::vector<std::pair<fs::file_time_type, RunMarker>> found;
  const std::string state = state_directory();
  std::vector<fs::path> directories = spare_directories(state);
  std::erase_if(directories, [](const fs::path& spare) { return !fs::is_directory(spare) || !trustworthy(spare); });
  directories.insert(directories.begin(), state);
  for (const fs::path& directory : directories) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(directory, error)) {
      const std::string path = entry.path().string(), name = entry.path().filename().string();
      std::error_code ignored;
      if (!name.starts_with(prefix) || name.ends_with(socket_end)) continue;
      if (auto marker = RunMarker::read(path))
        found.emplace_back(entry.last_write_time(ignored), std::move(*marker));
      else if (const int why = why_unreadable(path); why != 0)
        cannot_read(path, why);
    }
    if (error && error != std::errc::no_such_file_or_directory) cannot_read(directory, error.value());
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  markers.runs.reserve(found.size());
  for (auto& [when, marker] : found) markers.runs.push_back(std::move(marker));
  return markers;
}

std::vector<RunMarker> all_markers() {
  return find_markers().runs;
}

std::vector<RunMarker> bad_ends() {
  std::vector<RunMarker> markers = all_markers();
  std::erase_if(markers, [](const RunMarker& marker) { return marker.alive(); });
  return markers;
}

}  // namespace skein::app
