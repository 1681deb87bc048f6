#pragma once

#include <string>

namespace skein::app {

/// Keeps this process in memory as long as the object lives. Otherwise, on a machine that runs out of memory, the
/// kernel takes pages away, of the program's code as well, and a tick or a STOP waits for the disk that holds them,
/// which may stall. Pages are kept from their first use on; the program's own code is read in at once, that of
/// libraries is not. One object at a time.
class MemoryLock {
 public:
  MemoryLock();
  ~MemoryLock();
  MemoryLock(const MemoryLock&) = delete;
  MemoryLock& operator=(const MemoryLock&) = delete;

  bool granted() const { return refused_.empty(); }
  /// Why there is no lock; empty: there is one.
  const std::string& refused() const { return refused_; }

 private:
  std::string refused_;
};

/// How much memory this process may lock [bytes]; -1: no limit.
long memory_lock_limit();

}  // namespace skein::app
