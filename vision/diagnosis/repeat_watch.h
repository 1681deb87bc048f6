#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "vision/frames/frame.h"

namespace skein::vision {

/// A camera that delivers the same picture again and again, with new time stamps: a driver whose buffers are not
/// overwritten any more, a capture program whose input has stopped. Or one whose buffers are overwritten in part: a
/// transfer that breaks off leaves the rest as it was filled some frames before. A sensor's noise makes any two of its
/// frames differ everywhere. Single frames are repeated by cameras that expose for longer than a frame time. For one
/// thread.
class RepeatWatch {
 public:
  /// The camera counts as frozen when its picture, or a part of it, has been old for longer than this. [s]
  static constexpr double patience = 0.25;

  /// To be called before the next frame is read into `frame`: keeps the pixels of the last one, without copying them.
  void keep(Frame& frame) { std::swap(frame.grey, last_); }

  /// Whether the frame that was read since shows exactly what the last one showed, or in a part what an older one did:
  /// comparisons that end at the first pixel that differs.
  bool repeats(const Frame& frame);
  bool frozen() const { return frozen_; }
  /// How much of the last frame's height had been seen before; 0: nothing, 1: all of it.
  double part() const { return part_; }

 private:
  /// Some neighbouring rows, of the newest frame or an older one.
  using Strip = const std::uint8_t*;
  enum class Age { quiet, old, fresh, mixed };

  // That are compared. A single row would do for a sensor's noise; the synthetic camera's is drawn from so small a
  // stock that one row may come back, but no two.
  static constexpr int rows = 2;
  // From one strip to the next: whatever is old and as high as a tag that can be read, 16 px, has one in it. [px]
  static constexpr int rows_apart = 15;
  // Frames that are kept: twice as many as a driver has buffers, since some of them are passed over.
  static constexpr std::size_t frames = 8;

  void forget(const Frame& frame);
  double old_part(const Frame& frame) const;
  Age age(Strip pixels, std::size_t at) const;
  bool seen_before(Strip pixels, std::size_t at) const;
  std::size_t strip() const { return static_cast<std::size_t>(rows) * static_cast<std::size_t>(width_); }
  /// What the frame `ago` (1: the last one) showed in the strip that is kept at `at`.
  Strip older(std::size_t ago, std::size_t at) const { return older_[(next_ + frames - ago) % frames].data() + at; }

  Frame::Grey last_;
  std::array<std::vector<std::uint8_t>, frames> older_;  // the strips of so many frames in turn
  std::size_t next_ = 0, kept_ = 0;                      // where the next one's go; how many frames are there
  int width_ = 0, height_ = 0;                           // of these [px]
  double part_ = 0.0;
  std::optional<double> since_;  // of the first repeated frame [s]
  bool frozen_ = false;
};

}  // namespace skein::vision
