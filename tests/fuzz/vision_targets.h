#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/fuzz/damage.h"
#include "vision/frames/film.h"
#include "vision/frames/frame_source.h"

namespace skein::fuzz {

using Opener = std::function<std::unique_ptr<vision::FrameSource>(const std::string& path)>;

/// The frames of a small film: times that a container would round, indices with a gap.
inline std::vector<vision::Frame> small_film() {
  std::vector<vision::Frame> frames(4);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    vision::Frame& frame = frames[k];
    frame.resize(48, 32);
    for (std::size_t i = 0; i < frame.grey.size(); ++i)
      frame.grey[i] = static_cast<std::uint8_t>((i * 7 + (i / 48) * 13 + k * 31) ^ (i >> 3));
    frame.index = static_cast<std::int64_t>(k < 2 ? k : k + 3);
    frame.captured_at = 17.0 + 0.1 * static_cast<double>(k) / 3.0;
  }
  return frames;
}

/// Reads a file to its end. Frames are whole; what was passed over is said; of a recorded film, every frame is one that
/// was recorded, to the bit.
inline void frames(const std::string& path, const Opener& open, const std::vector<vision::Frame>& recorded) {
  const auto source = open(path);
  if (!source) return;
  vision::Frame frame;
  for (int k = 0; k < 1000; ++k) {
    const auto more = source->read(frame);
    if (!more || !*more) break;
    must_hold(frame.width > 0 && frame.height > 0);
    must_hold(frame.grey.size() == static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
    must_hold(std::isfinite(frame.captured_at));
    if (!source->recorded()) continue;
    bool known = false;
    for (const vision::Frame& one : recorded)
      known = known || (one.index == frame.index && one.captured_at == frame.captured_at && one.grey == frame.grey);
    must_hold(known);
  }
  for (const std::string& line : source->skipped()) must_hold(line.find(path) == 0);
}

}  // namespace skein::fuzz
