#pragma once

#include <time.h>

// What cameras of every kind are allowed before they count as stuck, gone or useless.

namespace skein::vision {

/// Opening the shutter and settling the exposure takes cameras a second or two. [s]
inline constexpr double first_frame_wait = 5.0;

/// Frame times without a frame after which the camera counts as stuck. [frames]
inline constexpr double stall_frames = 3.0;

/// Between two attempts to open a camera that has gone. [s]
inline constexpr double reopen_pause = 0.1;

/// Damaged frames in a row after which it sends nothing else.
inline constexpr int max_damaged = 25;

/// A rate of this share of the requested one is that rate: 29.97 is 30.
inline constexpr double as_good = 0.99;

/// CLOCK_MONOTONIC [s].
inline double monotonic_now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace skein::vision
