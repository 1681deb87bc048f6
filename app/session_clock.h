#pragma once

#include <atomic>
#include <chrono>

namespace skein::app {

/// The session's clock: seconds since it was made, monotonic. Wall: runs by itself (CLOCK_MONOTONIC). Virtual: stands
/// until it is set.
class SessionClock {
 public:
  explicit SessionClock(bool wall) : wall_(wall) {}

  bool wall() const noexcept { return wall_; }
  double now() const noexcept {
    return wall_ ? std::chrono::duration<double>(std::chrono::steady_clock::now() - epoch_).count()
                 : virtual_now_.load(std::memory_order_acquire);
  }
  void set(double now) noexcept { virtual_now_.store(now, std::memory_order_release); }

  /// A time of this clock as the system's, for absolute deadlines.
  std::chrono::steady_clock::time_point at(double time) const noexcept {
    return epoch_ +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(time));
  }
  /// A CLOCK_MONOTONIC time stamp [s] on this clock.
  double from_monotonic(double stamp) const noexcept {
    return stamp - std::chrono::duration<double>(epoch_.time_since_epoch()).count();
  }

 private:
  bool wall_;
  std::chrono::steady_clock::time_point epoch_ = std::chrono::steady_clock::now();
  std::atomic<double> virtual_now_{0.0};
};

}  // namespace skein::app
