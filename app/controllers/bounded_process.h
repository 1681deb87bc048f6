#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <tl/expected.hpp>

namespace skein::app {

/// Resource limits of a foreign process. docs/controllers.md lists what is not limited.
struct ProcessBounds {
  std::int64_t memory = 2048;      ///< address space of each process [MB]
  std::int64_t processes = 16;     ///< processes and threads beside those that the user has; 0: none but threads
  std::int64_t cpu_seconds = 600;  ///< of each process
  std::int64_t file = 1024;        ///< size of the largest file that it may write [MB]
};

/// A foreign process in a group of its own, which ends with this one. It cannot leave its group, so `end` kills every
/// process that it has started. Unless it is started otherwise, the first 64 kB of its output go to stderr.
class BoundedProcess {
 public:
  struct Setup {
    std::vector<std::string> words;        ///< the program, found as a shell finds it, and its arguments
    std::string directory;                 ///< in which it runs; empty: this one's
    std::vector<std::string> environment;  ///< NAME=VALUE, on top of this process's
    std::vector<int> files;                ///< its descriptors 3, 4, ...; the caller closes its own copies
    ProcessBounds bounds;
    bool prints = true;  ///< its output goes to stderr
  };
  /// The error names the program and the reason why it cannot be started.
  static tl::expected<std::unique_ptr<BoundedProcess>, std::string> start(const Setup& setup);
  ~BoundedProcess();

  /// Kills the whole group. Any thread; neither blocks nor allocates.
  void end() noexcept;
  /// How it ended, and the last line that it printed: "exit status 1: NameError: ..."; empty: it has not ended. Waits
  /// at most `patience` for that. Not for the control thread. [s]
  std::string how_it_ended(double patience);

 private:
  BoundedProcess() = default;
  tl::expected<void, std::string> spawn(const Setup& setup);
  void drain(const std::stop_token& stop, bool prints);
  bool reap(double patience);

  pid_t process_ = -1;
  int output_ = -1;
  std::mutex mutex_;
  std::string last_line_;  // guarded by mutex_
  bool reaped_ = false;    // guarded by mutex_, like the next
  int status_ = 0;
  std::atomic<bool> gone_{false};
  std::jthread drainer_;  // also its parent: the kernel kills a process when the thread that started it ends
};

}  // namespace skein::app
