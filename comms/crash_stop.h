#pragma once

#include "comms/protocol.h"

/// Stops the robots when the program crashes: the descriptors of open links and the bytes of a stop are always ready
/// for the signal handler.
namespace skein::comms {

/// SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGQUIT and SIGSYS, in whatever thread, stop every robot before they end
/// the program: every link thread gets the emergency stop, every open link the bytes at once, again every 100 ms, until
/// each robot is known to stand, at most for a second. Then the signal has its previous effect. A stack overflow is
/// handled only in the thread that called this.
void stop_robots_on_crash();

/// SIGTSTP (Ctrl-Z) stops every robot before it suspends the program: every link thread gets the emergency stop, which
/// stays. Waits until every robot is known to stand, at most a second, and calls `stopped` (async-signal-safe) if a
/// line was open.
void stop_robots_on_suspend(void (*stopped)() noexcept);

// --- For links -------------------------------------------------------------------------------------------------------

/// Registers an open descriptor to a robot with the handler during its lifetime. Move-only. All calls are lock-free.
class CrashEntry {
 public:
  CrashEntry() noexcept = default;
  CrashEntry(int descriptor, const Protocol& protocol) noexcept;  ///< beyond 128 links: not registered
  CrashEntry(CrashEntry&& other) noexcept;
  CrashEntry& operator=(CrashEntry&& other) noexcept;
  ~CrashEntry();

  void set_stands(bool stands) noexcept;  ///< the robot has acknowledged its stop

 private:
  int place_ = -1;
};

/// Registers a link thread with the handler during its lifetime: `stop(who)` is called there, and must be
/// async-signal-safe.
class CrashThread {
 public:
  CrashThread(void (*stop)(void* who) noexcept, void* who) noexcept;
  ~CrashThread();
  CrashThread(const CrashThread&) = delete;
  CrashThread& operator=(const CrashThread&) = delete;

  void runs_here() noexcept;  ///< the calling thread is the one that reads the links

 private:
  int place_ = -1;
};

}  // namespace skein::comms
