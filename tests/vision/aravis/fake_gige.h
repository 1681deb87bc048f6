#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "tests/places.h"
#include "vision/synthetic/synthetic_camera.h"

extern char** environ;

namespace skein::test {

inline constexpr const char* fake_gige_serial = "SKEIN1";

/// What the fake's pictures show in column u, in every format.
inline std::uint8_t fake_gige_grey(int u) {
  return static_cast<std::uint8_t>(40 + u / 8);
}

/// What it shows with --tags.
inline std::vector<vision::SyntheticTag> fake_gige_tags() {
  return {{1, {0.3, 0.2, 0.5}}, {2, {-0.5, 0.4, -2.0}}, {3, {0.6, -0.5, 1.5}}, {4, {-0.7, -0.3, 3.0}}};
}

/// Cameras share one port of the machine: one camera at a time, in whatever process.
class PortLock {
 public:
  explicit PortLock(const char* lock_file = "/tmp/skein_fake_gige.lock") : file_(open_lock(lock_file)) {
    if (file_ < 0 || ::flock(file_, LOCK_EX) != 0) throw std::system_error(errno, std::generic_category(), lock_file);
  }
  /// One test at a time: also while its camera is gone, since another test's would be taken for it.
  static std::shared_ptr<PortLock> turn() {
    static std::weak_ptr<PortLock> of_this_process;
    auto turn = of_this_process.lock();
    if (!turn) of_this_process = turn = std::make_shared<PortLock>("/tmp/skein_fake_gige_turn.lock");
    return turn;
  }
  ~PortLock() { ::close(file_); }
  PortLock(const PortLock&) = delete;
  PortLock& operator=(const PortLock&) = delete;

 private:
  /// Another user's, where there is one: in /tmp nobody may create what is there, nor write to it.
  static int open_lock(const char* lock_file) {
    const int there = ::open(lock_file, O_RDONLY | O_CLOEXEC);
    return there >= 0 ? there : ::open(lock_file, O_CREAT | O_RDONLY | O_CLOEXEC, 0644);
  }

  int file_;
};

/// The program skein_fake_gige, running.
class FakeGige {
 public:
  explicit FakeGige(std::vector<std::string> words = {}) {
    int pipe[2];
    if (::pipe2(pipe, O_CLOEXEC) != 0) return;
    words.insert(words.begin(), fake_gige());
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, pipe[1], 1);
    if (posix_spawn(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ) != 0) pid_ = 0;
    posix_spawn_file_actions_destroy(&actions);
    ::close(pipe[1]);
    char ready = 0;
    running_ = pid_ != 0 && ::read(pipe[0], &ready, 1) == 1;
    ::close(pipe[0]);
  }
  ~FakeGige() { kill(); }
  FakeGige(const FakeGige&) = delete;
  FakeGige& operator=(const FakeGige&) = delete;

  bool running() const { return running_; }
  /// Answers no more, until it is killed or goes on.
  void hang() { ::kill(pid_, SIGSTOP); }
  void go_on() { ::kill(pid_, SIGCONT); }
  /// Gone, as a camera whose cable was pulled.
  void kill() {
    if (pid_ != 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    pid_ = 0;
    running_ = false;
  }

 private:
  std::shared_ptr<PortLock> turn_ = PortLock::turn();
  pid_t pid_ = 0;
  bool running_ = false;
};

}  // namespace skein::test
