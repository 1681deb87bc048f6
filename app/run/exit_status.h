#pragma once

namespace skein::app {

/// Exit statuses that scripts rely on.
enum ExitStatus {
  done = 0,                ///< and the file's [expect] held
  expectation_failed = 1,  ///< which, and by how much, is on stderr
  wrong_input = 2,         ///< the command line or a file
  device_failed = 3,       ///< a camera or a robot
};

}  // namespace skein::app
