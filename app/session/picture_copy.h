#pragma once

#include "app/run/status.h"
#include "vision/frames/frame.h"

namespace skein::app {

/// A frame's size, pixels and time. A picture that is filled again and again keeps its memory.
inline void copy_pixels(const vision::Frame& from, Picture& to) {
  to.width = from.width;
  to.height = from.height;
  to.grey.assign(from.grey.begin(), from.grey.end());
  to.captured_at = from.captured_at;
}
inline void copy_pixels(const Picture& from, vision::Frame& to) {
  to.resize(from.width, from.height);
  to.grey.assign(from.grey.begin(), from.grey.end());
}

}  // namespace skein::app
