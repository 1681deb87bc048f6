#include "app/record/report.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "app/embedded/embedded.h"

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Done = tl::expected<void, std::string>;

constexpr const char* missing_gnuplot =
    "gnuplot, which draws the figures, cannot be run ({}): install the package gnuplot-nox";

/// Runs gnuplot in a directory and waits for its end. The error is what it wrote to stderr.
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
  pid_t child = 0;
  const int failed = posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
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
  const std::string end = WIFEXITED(status) ? fmt::format("ended with status {}", WEXITSTATUS(status))
                                            : fmt::format("was killed by signal {}", WTERMSIG(status));
  return tl::unexpected(fmt::format("gnuplot {}{}{}", end, said.empty() ? "" : ": ", said));
}

Done write_file(const fs::path& path, std::string_view text) {
  errno = 0;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (out) return {};
  return tl::unexpected(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
}

/// What a figure's script needs to know of this run, as gnuplot's variables.
std::string script_head(const char* figure, const Experiment& experiment, const Statistics::Summary& summary) {
  std::string perturbed, settled;
  for (const PerturbationResult& p : summary.perturbations) {
    perturbed += fmt::format("{}{:.6g}", perturbed.empty() ? "" : " ", p.t);
    if (p.settling.formation_1cm)
      settled += fmt::format("{}{:.6g}", settled.empty() ? "" : " ", p.t + *p.settling.formation_1cm);
  }
  return fmt::format(
      "# Experiment \"{}\", drawn by skein {} from run.csv. To draw it again, edit this and run: gnuplot {}.gp\n"
      "n = {}  # robots\n"
      "perturbed = \"{}\"  # when a robot was put elsewhere [s]\n"
      "settled = \"{}\"  # when the largest formation error had come back to 1 cm for good [s]\n\n",
      experiment.name, SKEIN_VERSION, figure, experiment.robots.size(), perturbed, settled);
}

}  // namespace

Done check_report(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) return tl::unexpected(fmt::format("{}: cannot be made: {}", directory, error.message()));
  const fs::path probe = fs::path(directory) / ".skein-can-write-here";
  if (Done written = write_file(probe, ""); !written)
    return tl::unexpected(fmt::format("{}: cannot be written to: {}", directory, std::strerror(errno)));
  fs::remove(probe, error);
  return gnuplot(directory, "--version");
}

Done write_report(const std::string& directory, const Experiment& experiment, const Statistics::Summary& summary) {
  const fs::path folder(directory);
  if (Done written = write_file(folder / "summary.json", as_json(summary) + '\n'); !written) return written;
  for (const auto& [figure, body] : {std::pair("figure3", embedded::figure3_gp), {"figure4", embedded::figure4_gp}}) {
    const std::string script = fmt::format("{}.gp", figure);
    Done done = write_file(folder / script, script_head(figure, experiment, summary) + std::string(body));
    if (done) done = gnuplot(directory, script.c_str());
    if (!done) return tl::unexpected(fmt::format("{}: {}", (folder / script).string(), done.error()));
  }
  return {};
}

}  // namespace skein::app
