#include "app/record/gnuplot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Done = tl::expected<void, std::string>;

constexpr const char* missing_gnuplot =
    "gnuplot, which draws the figures, cannot be run ({}): install the package gnuplot-nox";

/// Whether a figure has what every file of its kind ends with.
bool has_its_end(const fs::path& file, std::string_view end) {
  constexpr std::streamoff longest = 32;
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = in.tellg();
  in.seekg(std::max<std::streamoff>(0, size - longest));
  std::string last(longest, '\0');
  in.read(last.data(), longest);
  return size > 0 && last.find(end) != std::string::npos;
}

}  // namespace

Done gnuplot(const std::string& directory, const char* argument) {
  std::array<int, 2> errors{};
  if (pipe2(errors.data(), O_CLOEXEC) != 0) return tl::unexpected(fmt::format("no pipe: {}", std::strerror(errno)));

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, errors[1], STDERR_FILENO);
  std::string program = "gnuplot", script = argument;
  std::array<char*, 3> arguments{program.data(), script.data(), nullptr};
  posix_spawnattr_t attributes;  // Ctrl-C ends it also where this thread has blocked signals
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(errors[1]);

  std::string said;
  std::array<char, 4096> buffer{};
  for (ssize_t size = 0; failed == 0; said.append(buffer.data(), static_cast<std::size_t>(size))) {
    do size = read(errors[0], buffer.data(), buffer.size());
    while (size < 0 && errno == EINTR);
    if (size <= 0) break;
  }
  close(errors[0]);
  if (failed != 0) return tl::unexpected(fmt::format(missing_gnuplot, std::strerror(failed)));

  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  said.erase(0, std::min(said.find_first_not_of(" \n"), said.size()));
  said.erase(said.find_last_not_of(" \n") + 1);
  std::replace(said.begin(), said.end(), '\n', ' ');
  const std::string end = WIFEXITED(status) ? fmt::format("ended with status {}", WEXITSTATUS(status))
                                            : fmt::format("was killed by signal {}", WTERMSIG(status));
  return tl::unexpected(fmt::format("gnuplot {}{}{}", end, said.empty() ? "" : ": ", said));
}

Done draw_figure(const std::string& directory, const std::string& name) {
  if (Done drawn = gnuplot(directory, (name + ".gp").c_str()); !drawn) return drawn;
  for (const auto& [kind, end] : {std::pair(".pdf", "%%EOF"), {".svg", "</svg>"}, {".png", "IEND"}})
    if (!has_its_end(fs::path(directory) / (name + kind), end))
      return tl::unexpected(fmt::format("gnuplot did not write all of {}{}: is the disk full?", name, kind));
  return {};
}

void remove_figure(const std::string& directory, const std::string& name) {
  for (const char* const kind : {".gp", ".pdf", ".svg", ".png"}) {
    std::error_code not_there;
    fs::remove(fs::path(directory) / (name + kind), not_there);
  }
}

}  // namespace skein::app
