#include "vision/diagnosis/repeat_watch.h"

#include <algorithm>
#include <cstring>

namespace skein::vision {
namespace {

// A strip is compared in pieces of so many pixels, as wide as two blocks of a coder's. It has a sensor's noise if three
// quarters of them differ from another frame's: what a coder leaves out because it does not move, what is clipped, cut
// off or painted over the picture, shows the same although it is new, and proves nothing.
constexpr std::size_t piece = 16;

bool same(const std::uint8_t* a, const std::uint8_t* b, std::size_t count) {
  return std::memcmp(a, b, count) == 0;
}

/// Whether neighbouring pixels differ as they do where there is noise, or a texture: one that is clipped, or painted in
/// one colour, is flat.
bool rough(const std::uint8_t* pixels, std::size_t count) {
  std::size_t steps = 0;
  for (std::size_t u = 1; u < count; ++u) steps += pixels[u] != pixels[u - 1] ? 1U : 0U;
  return 4 * steps >= count - 1;
}

/// Whether it holds for three quarters of a strip's pieces, each given by its first pixel and its width.
template <class Holds>
bool mostly(std::size_t pixels, Holds&& holds) {
  int pieces = 0, held = 0;
  for (std::size_t left = 0; left < pixels; left += piece, ++pieces)
    held += holds(left, std::min(piece, pixels - left)) ? 1 : 0;
  return 4 * held >= 3 * pieces;
}

}  // namespace

bool RepeatWatch::repeats(const Frame& frame) {
  if (frame.width != width_ || frame.height != height_) forget(frame);
  const bool again = !last_.empty() && frame.grey == last_;
  part_ = again ? 1.0 : old_part(frame);
  if (part_ == 0.0) {
    since_.reset();
    frozen_ = false;
  } else {
    if (!since_ || frame.captured_at < *since_) since_ = frame.captured_at;
    frozen_ = frame.captured_at - *since_ >= patience;
  }
  if (again) return true;
  std::vector<std::uint8_t>& strips = older_[next_];
  std::size_t at = 0;
  for (int v = height_ - rows; v >= 0; v -= rows_apart, at += strip())
    std::copy_n(frame.row(v), strip(), strips.data() + at);
  next_ = (next_ + 1) % frames;
  kept_ = std::min(kept_ + 1, frames);
  return part_ > 0.0;
}

void RepeatWatch::forget(const Frame& frame) {
  width_ = frame.width;
  height_ = frame.height;
  kept_ = 0;
  const int strips = std::max(0, height_ - rows + rows_apart) / rows_apart;
  for (auto& older : older_) older.resize(static_cast<std::size_t>(strips) * strip());
}

/// Whether a frame before the last one showed it, to the bit. The last one does not count: a picture that is coded, or
/// clipped, stands still from frame to frame. Noise that has changed and is back is no new noise.
bool RepeatWatch::seen_before(Strip pixels, std::size_t at) const {
  for (std::size_t ago = 2; ago <= kept_; ++ago)
    if (same(pixels, older(ago, at), strip())) return true;
  return false;
}

RepeatWatch::Age RepeatWatch::age(Strip pixels, std::size_t at) const {
  const Strip last = older(1, at);
  const bool noisy = mostly(width_, [&](std::size_t left, std::size_t count) {
    return !same(pixels + left, last + left, count) && rough(pixels + left, count);
  });
  if (!noisy) return Age::quiet;
  if (seen_before(pixels, at)) return Age::old;
  const bool fresh = mostly(strip(), [&](std::size_t left, std::size_t count) {
    for (std::size_t ago = 2; ago <= kept_; ++ago)
      if (same(pixels + left, older(ago, at) + left, count)) return false;
    return true;
  });
  return fresh ? Age::fresh : Age::mixed;
}

/// Strips are old if they have a sensor's noise, and an older frame's to the bit. A part of a frame is believed to be
/// old only if noise elsewhere in it is new, so that the camera is known to have some; all of it, if nothing in it is
/// new.
double RepeatWatch::old_part(const Frame& frame) const {
  const auto any_strip = [&](auto&& is) {
    std::size_t at = 0;
    for (int v = height_ - rows; v >= 0; v -= rows_apart, at += strip())
      if (is(frame.row(v), at)) return true;
    return false;
  };
  if (kept_ < 2 || !any_strip([&](Strip pixels, std::size_t at) { return seen_before(pixels, at); })) return 0.0;
  int strips = 0, old = 0, fresh = 0, quiet = 0;
  any_strip([&](Strip pixels, std::size_t at) {
    ++strips;
    switch (age(pixels, at)) {
      case Age::old:
        ++old;
        break;
      case Age::fresh:
        ++fresh;
        break;
      case Age::quiet:
        ++quiet;
        break;
      case Age::mixed:
        break;
    }
    return false;
  });
  if (old == 0) return 0.0;
  if (old + quiet == strips) return 1.0;
  return fresh > 0 ? static_cast<double>(old) / strips : 0.0;
}

}  // namespace skein::vision
