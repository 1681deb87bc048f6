#include "ui/bench/bench_display.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <QByteArray>
#include <QtGlobal>
#include <array>
#include <csignal>
#include <string>

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace skein::ui {
namespace {

constexpr int patience_ms = 30000;

/// The line that the server writes once it is ready: its number; empty: none came.
std::string line_of(int from) {
  std::string line;
  pollfd ready{from, POLLIN, 0};
  for (char c = 0; poll(&ready, 1, patience_ms) == 1 && read(from, &c, 1) == 1;) {
    if (c == '\n') return line;
    line += c;
  }
  return {};
}

}  // namespace

BenchDisplay::BenchDisplay() {
  for (const char* chosen : {"QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY"})
    if (!qEnvironmentVariableIsEmpty(chosen)) return;
  std::array<int, 2> number{};
  if (pipe2(number.data(), O_CLOEXEC) != 0) return;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  constexpr int told_to = 3;
  posix_spawn_file_actions_adddup2(&actions, number[1], told_to);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::array words{std::string("Xvfb"),      std::string("-displayfd"), std::string("3"),
                   std::string("-screen"),   std::string("0"),          std::string("1600x1000x24"),
                   std::string("-nolisten"), std::string("tcp"),        std::string("-noreset")};
  std::array<char*, words.size() + 1> arguments{};
  for (std::size_t k = 0; k < words.size(); ++k) arguments[k] = words[k].data();
  const bool runs = posix_spawnp(&server_, "Xvfb", &actions, nullptr, arguments.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  close(number[1]);
  const std::string display = runs ? line_of(number[0]) : std::string();
  close(number[0]);
  if (display.empty()) {
    qputenv("QT_QPA_PLATFORM", "offscreen");
    return;
  }
  qputenv("DISPLAY", QByteArray::fromStdString(":" + display));
  qputenv("QT_QPA_PLATFORM", "xcb");
}

BenchDisplay::~BenchDisplay() {
  if (server_ <= 0) return;
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
}

}  // namespace skein::ui
