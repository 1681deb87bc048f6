#pragma once

#include <optional>
#include <string>
#include <utility>

#include "comms/sleep_inhibitor.h"

namespace skein::app {

/// Keeps the machine awake while a run or a tool drives real robots, and reports when that is not possible. Any thread,
/// except alarm(): one thread.
class KeptAwake {
 public:
  /// `what`: the experiment, for `systemd-inhibit --list`.
  explicit KeptAwake(std::string what) : inhibitor_(std::move(what)) {}

  void hold(bool on) noexcept { inhibitor_.hold(on); }
  bool held() const { return inhibitor_.held(); }
  /// The sentence that the operator must see, once: the machine may suspend nevertheless.
  std::optional<std::string> alarm();

 private:
  comms::SleepInhibitor inhibitor_;
  bool told_ = false;
};

}  // namespace skein::app
