#pragma once

#include <array>
#include <cstddef>

namespace skein::app {

/// When the control loop's ticks begin. Without a camera: at absolute deadlines, so that lateness does not add up. With
/// one that delivers a frame (or 2, 3...) a period: as soon as one has been worked off, so that poses do not grow old
/// waiting for a tick; the deadlines are drawn to the frames, after the first second by at most a twentieth of a period
/// a tick, and a frame that does not come is waited for no longer. A camera of another rate leaves the deadlines alone.
/// All times on the session's clock [s]; no clock, no waiting in here.
class TickTimer {
 public:
  TickTimer(double period, double first) noexcept : period_(period), deadline_(first) {}

  /// The next tick begins at `earliest` if a frame has been ready since `since`, else when one is, else at `latest`.
  struct Window {
    double since, earliest, latest;
  };
  Window window() const noexcept;

  /// The newest frame at hand; it has been worked off.
  void frame(double captured_at, double ready_at) noexcept;
  /// A tick is over. Returns the periods from its deadline to the next one's: 1, or more where deadlines have passed
  /// meanwhile.
  int ticked(double now) noexcept;

  /// Whether the ticks follow the camera's frames.
  bool follows_frames() const noexcept;

 private:
  static constexpr std::size_t memory = 5;  // intervals that must agree before they are believed
  double period_, deadline_;
  double captured_at_ = 0.0, ready_at_ = 0.0;  // of the newest frame
  std::array<double, memory> intervals_{};
  std::size_t frames_ = 0;
  int ticks_ = 0;
  bool in_step_ = false;  // the newest frame was ready where the deadline was
};

}  // namespace skein::app
