#pragma once

#include <atomic>
#include <chrono>

namespace skein::app {

/// The session's clock: seconds since it was made, monotonic. Wall: runs by itself (CLOCK_MONOTONIC), unless a
/// simulation is paced: then it stands until it is set. Virtual: always stands until it is set.
class SessionClock {
 public:
  explicit SessionClock(bool wall) : wall_(wall), runs_(wall) {}

  /// The session runs on threads of its own.
  bool wall() const noexcept { return wall_; }
  /// Whether time passes by itself now.
  bool runs() const noexcept { return runs_.load(std::memory_order_acquire); }
  double now() const noexcept {
    return runs() ? since_epoch() + offset_.load(std::memory_order_acquire) : set_now_.load(std::memory_order_acquire);
  }
  /// Control thread only: time stands at `now` [s].
  void set(double now) noexcept {
    set_now_.store(now, std::memory_order_release);
    runs_.store(false, std::memory_order_release);
  }
  /// Control thread only: time passes again, from its present value.
  void run() noexcept {
    if (runs()) return;
    offset_.store(set_now_.load() - since_epoch(), std::memory_order_release);
    runs_.store(true, std::memory_order_release);
  }

  /// A time of this clock as system time, for absolute deadlines.
  std::chrono::steady_clock::time_point at(double time) const noexcept {
    return epoch_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                        std::chrono::duration<double>(time - offset_.load(std::memory_order_acquire)));
  }
  /// A CLOCK_MONOTONIC time stamp [s] on this clock.
  double from_monotonic(double stamp) const noexcept {
    return stamp - std::chrono::duration<double>(epoch_.time_since_epoch()).count() + offset_.load();
  }

 private:
  double since_epoch() const noexcept {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - epoch_).count();
  }

  const bool wall_;
  std::atomic<bool> runs_;
  const std::chrono::steady_clock::time_point epoch_ = std::chrono::steady_clock::now();
  std::atomic<double> set_now_{0.0}, offset_{0.0};
};

}  // namespace skein::app
