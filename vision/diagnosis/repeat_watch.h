#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "vision/frames/frame.h"

namespace skein::vision {

/// A camera that delivers the same picture again and again, with new time stamps: a driver whose buffer is not
/// overwritten any more, a capture program whose input has stopped. A sensor's noise makes any two of its frames differ
/// somewhere. Single frames are repeated by cameras that expose for longer than a frame time. For one thread.
class RepeatWatch {
 public:
  /// The camera counts as frozen when its picture has been the same for longer than this. [s]
  static constexpr double patience = 0.25;

  /// To be called before the next frame is read into `frame`: keeps the pixels of the last one, without copying them.
  void keep(Frame& frame) { std::swap(frame.grey, last_); }

  /// Whether the frame that was read since shows exactly what the last one showed: a comparison that ends at the first
  /// pixel that differs.
  bool repeats(const Frame& frame) {
    const bool same = !last_.empty() && frame.grey == last_;
    if (!same) {
      since_.reset();
      frozen_ = false;
    } else {
      if (!since_ || frame.captured_at < *since_) since_ = frame.captured_at;
      frozen_ = frame.captured_at - *since_ >= patience;
    }
    return same;
  }
  bool frozen() const { return frozen_; }

 private:
  std::vector<std::uint8_t> last_;
  std::optional<double> since_;  // of the first repeated frame [s]
  bool frozen_ = false;
};

}  // namespace skein::vision
