#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace skein::comms {

/// Keeps the machine awake (systemd's logind, inhibitors "sleep" and "handle-lid-switch") while robots drive: they have
/// no watchdog, and a suspended machine cannot stop them. Without logind it only reports the problem. Any thread.
class SleepInhibitor {
 public:
  /// `what`: the activity, for `systemd-inhibit --list`.
  explicit SleepInhibitor(std::string what);
  ~SleepInhibitor();  ///< releases the inhibitor
  SleepInhibitor(const SleepInhibitor&) = delete;
  SleepInhibitor& operator=(const SleepInhibitor&) = delete;

  void hold(bool on) noexcept;  ///< never blocks: a separate thread calls logind
  bool held() const;            ///< the inhibitor is held now
  std::string problem() const;  ///< why it cannot be held; empty: no problem known

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
