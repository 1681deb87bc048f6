#pragma once

#include <optional>
#include <string>
#include <utility>

#include "comms/sleep_inhibitor.h"

namespace skein::app {

/// Keeps the machine awake while a run or a tool drives real robots, and says so where that is not possible. Any
/// thread but alarm(): one thread.
class KeptAwake {
 public:
  /// `what`: the experiment, for `systemd-inhibit --list`.
  explicit KeptAwake(std::string what) : inhibitor_(std::move(what)) {}

  void hold(bool on) noexcept { inhibitor_.hold(on); }
  bool held() const { return inhibitor_.held(); }
  /// What the operator must know, once: the machine may suspend all the same.
  std::optional<std::string> alarm();

 private:
  comms::SleepInhibitor inhibitor_;
  bool told_ = false;
};

}  // namespace skein::app
