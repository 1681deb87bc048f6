#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>
#include <utility>

namespace skein::comms {

/// Another process, which has this terminal open until it is told to end. `before`: what it does with it.
class OtherProgram {
 public:
  template <typename Before>
  OtherProgram(const std::string& device, Before before) {
    std::array<int, 2> ready{};
    EXPECT_EQ(::pipe2(ready.data(), O_CLOEXEC), 0);
    process = ::fork();
    char byte = 0;
    if (process == 0) {
      before(::open(device.c_str(), O_RDWR | O_NOCTTY));
      (void)!::write(ready[1], &byte, 1);
      while (true) ::pause();
    }
    EXPECT_EQ(::read(ready[0], &byte, 1), 1);
    ::close(ready[0]);
    ::close(ready[1]);
  }
  OtherProgram(const OtherProgram&) = delete;
  OtherProgram& operator=(const OtherProgram&) = delete;
  ~OtherProgram() { end(); }
  void end() {
    if (process <= 0) return;
    ::kill(process, SIGKILL);
    ::waitpid(std::exchange(process, -1), nullptr, 0);
  }
  std::string sentence() const { return fmt::format("(process {}) is using the device", process); }
  pid_t process = -1;
};

}  // namespace skein::comms
