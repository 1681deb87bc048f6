#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace skein::comms {

/// Keeps the machine awake (systemd's logind, inhibitor "sleep") while robots drive: they have no watchdog, and nothing
/// can stop them from a machine that sleeps. Where there is no logind it says so and does nothing else. Any thread.
class SleepInhibitor {
 public:
  /// `what`: what is being done, for `systemd-inhibit --list`.
  explicit SleepInhibitor(std::string what);
  ~SleepInhibitor();  ///< lets the machine sleep
  SleepInhibitor(const SleepInhibitor&) = delete;
  SleepInhibitor& operator=(const SleepInhibitor&) = delete;

  void hold(bool on) noexcept;  ///< never waits: a thread of its own asks logind
  bool held() const;            ///< the machine stays awake now
  std::string problem() const;  ///< why it cannot be held; empty: nothing is known against it

 private:
  void run();

  std::string what_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool wanted_ = false, ends_ = false, asked_ = false;  // guarded by mutex_
  int lock_ = -1;                                       // guarded by mutex_; the descriptor that logind gave
  std::string problem_;                                 // guarded by mutex_
  std::thread thread_;
};

}  // namespace skein::comms
