#pragma once

#include <functional>

namespace skein::app {

/// Exit statuses that scripts rely on.
enum ExitStatus {
  done = 0,                ///< and the file's [expect] held
  expectation_failed = 1,  ///< which, and by how much, is on stderr
  wrong_input = 2,         ///< the command line or a file
  device_failed = 3,       ///< a camera or a robot
};

/// Runs a whole program, from its first to its last output: what it returns is its exit status. An exception is
/// reported, and so is lost output (a full disk): both give device_failed unless something worse is known. At its end
/// it waits for readers that are slow, seconds at most.
int exit_status_of(const std::function<int()>& program) noexcept;

}  // namespace skein::app
