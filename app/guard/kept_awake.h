#pragma once

#include <optional>
#include <string>
#include <utility>

#include "comms/system_services.h"

namespace skein::app {

/// Keeps the machine awake, and its screen unlocked, while a run or a tool drives real robots. Reports where the
/// machine may suspend nevertheless; many desktops without a screen lock do not know of the other. Any thread, except
/// alarm(): one thread.
class KeptAwake {
 public:
  /// `what`: the experiment, for `systemd-inhibit --list`.
  explicit KeptAwake(const std::string& what)
      : sleep_(comms::inhibit_sleep, what), screen_lock_(comms::inhibit_screen_lock, what) {}

  void hold(bool on) noexcept {
    sleep_.hold(on);
    screen_lock_.hold(on);
  }
  bool held() const { return sleep_.held() || screen_lock_.held(); }
  /// The sentence that the operator must see, once: the machine may suspend nevertheless.
  std::optional<std::string> alarm();

 private:
  comms::Inhibitor sleep_, screen_lock_;
  bool told_ = false;
};

}  // namespace skein::app
