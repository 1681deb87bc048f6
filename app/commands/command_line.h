#pragma once

#include <functional>
#include <string>

#include "app/experiment/experiment.h"

namespace skein::app {

/// What the operator's window needs to open.
struct WindowRequest {
  Experiment experiment;
  std::string file;       ///< it was read from; empty: none was named, show the paper's experiment running
  std::string recording;  ///< a recorded run (CSV) to be played instead; empty: none
};

/// Opens the window and returns the program's exit status; empty in a program that was built without one.
using ShowWindow = std::function<int(const WindowRequest& request, int& argc, char** argv)>;

/// Measures the window, each time for so many seconds; empty in a program that was built without one.
using BenchWindow = std::function<int(double seconds, int& argc, char** argv)>;

/// Exit statuses that scripts rely on.
enum ExitStatus {
  done = 0,                ///< and the file's [expect] held
  expectation_failed = 1,  ///< which, and by how much, is on stderr
  wrong_input = 2,         ///< the command line or a file
  device_failed = 3,       ///< a camera or a robot
};

/// The program `skein`: reads the command line and does what it says. Never throws.
int command_line(int argc, char** argv, const ShowWindow& show_window, const BenchWindow& bench_window = {});

/// True from the first SIGINT or SIGTERM on; the handler is installed by `command_line`.
bool interrupted() noexcept;

}  // namespace skein::app
