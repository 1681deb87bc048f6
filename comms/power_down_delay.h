#pragma once

#include <memory>
#include <string>

namespace skein::comms {

/// Learns from systemd's logind that the machine is about to be suspended or shut down, also by somebody who overrides
/// `inhibit_sleep`, and delays that while this exists, for as long as logind allows (InhibitDelayMaxSec, 5 s unless it
/// is configured). Without it bluetoothd may switch the adapters off before the robots are stopped. One thread.
class PowerDownDelay {
 public:
  /// `what`: the activity, for `systemd-inhibit --list`. Where there is no logind, nothing is ever announced.
  explicit PowerDownDelay(const std::string& what);
  ~PowerDownDelay();
  PowerDownDelay(const PowerDownDelay&) = delete;
  PowerDownDelay& operator=(const PowerDownDelay&) = delete;

  enum class Announced { nothing, suspend, shutdown };
  /// What has been announced since the last call. Never blocks; to be called at least every 0.1 s.
  Announced turn() noexcept;

 private:
  struct Bus;
  std::unique_ptr<Bus> bus_;
};

}  // namespace skein::comms
