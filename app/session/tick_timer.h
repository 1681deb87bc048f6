#pragma once

#include <array>
#include <cstddef>

namespace skein::app {

/// Determines when the control loop's ticks begin. Without a camera: at absolute deadlines, so that lateness does not
/// accumulate. With a camera that delivers one (or 2, 3...) frames per period: as soon as a frame has been processed,
/// so that poses do not age while waiting for a tick; the deadlines are shifted to the frames, after the first second
/// by at most a twentieth of a period per tick, and a tick does not wait for a missing frame. A camera of another rate
/// does not affect the deadlines. All times on the session's clock [s]; no clock, no waiting in here.
class TickTimer {
 public:
  TickTimer(double period, double first) noexcept : period_(period), deadline_(first) {}

  /// The next tick begins at `earliest` if a frame has been ready since `since`; otherwise as soon as one is ready, at
  /// the time `expected` from the camera so far; at the latest at `latest`.
  struct Window {
    double since, earliest, expected, latest;
    /// When the tick should begin, given that its newest frame was ready at `ready_at` (NaN: none yet): a frame from
    /// before `since` is not the one that it waits for.
    double due(double ready_at) const noexcept;
  };
  Window window() const noexcept;

  /// The newest processed frame.
  void frame(double captured_at, double ready_at) noexcept;
  /// Ends a tick. Returns the number of periods from its deadline to the next one: 1, or more if deadlines have passed
  /// meanwhile.
  int ticked(double now) noexcept;

  /// Whether the ticks follow the camera's frames.
  bool follows_frames() const noexcept;

 private:
  static constexpr std::size_t memory = 5;  // intervals that must agree before they are used
  double period_, deadline_;
  double captured_at_ = 0.0, ready_at_ = 0.0;  // of the newest frame
  std::array<double, memory> intervals_{};
  std::size_t frames_ = 0;
  int ticks_ = 0;
  bool in_step_ = false;  // the newest frame was ready where the deadline was
};

}  // namespace skein::app
