#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace skein::comms {

/// Keeps the machine or its desktop from something (systemd and freedesktop.org call that an inhibitor) while robots
/// drive. Where it is refused, it only reports the problem. Any thread.
class Inhibitor {
 public:
  struct Answer {
    std::shared_ptr<void> held;  ///< inhibits as long as it exists; null: refused
    std::string problem;         ///< why it is refused, also in part
  };
  /// `what`: the activity, for people.
  using Ask = std::function<Answer(const std::string& what)>;

  Inhibitor(Ask ask, std::string what);
  ~Inhibitor();  ///< releases what it holds
  Inhibitor(const Inhibitor&) = delete;
  Inhibitor& operator=(const Inhibitor&) = delete;

  void hold(bool on) noexcept;  ///< never blocks: a separate thread asks
  bool held() const;            ///< now
  std::string problem() const;  ///< empty: no problem known

 private:
  void run();

  Ask ask_;
  std::string what_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool wanted_ = false, ends_ = false, asked_ = false;  // guarded by mutex_
  std::shared_ptr<void> lock_;                          // guarded by mutex_
  std::string problem_;                                 // guarded by mutex_
  std::thread thread_;
};

}  // namespace skein::comms
