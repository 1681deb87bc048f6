#pragma once

#include <memory>
#include <vector>

#include "vision/frames/frame.h"
#include "vision/tags/detection.h"

namespace skein::vision {

struct DetectorOptions {
  double decimate = 1.0;  // edges are searched at 1 / decimate of the resolution; 2 needs 3 px and more a module
  int min_white_black_diff =
      5;                        // grey levels between ink and paper; 40 is 3 times faster on a textured, well-lit floor
  int threads = 1;              // of a search; more gain little below a few megapixels
  double least_likeness = 0.7;  // texture that happens to decode reaches a half; -1: AprilTag's own answer
};

/// A rectangle of a frame: columns [left, left + width), rows [top, top + height). [px]
struct Window {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
};

/// Finds the tags of the family 36h11: AprilTag's detections that also correlate with the tag that they decode to.
/// The first of a process takes ~50 ms and ~20 MB to build, which all share. Not for two threads at once.
class TagDetector {
 public:
  explicit TagDetector(const DetectorOptions& options = {});
  ~TagDetector();
  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;

  /// Every tag in the frame, also two with the same id, ordered by id and then by place. Valid until the next call.
  const std::vector<Detection>& detect(const Frame& frame);

  /// The tags that lie wholly in a part of the frame; corners are still those in the frame. A window that reaches over
  /// the edge is cut there.
  const std::vector<Detection>& detect(const Frame& frame, Window window);

  /// May be changed between calls (threads only at the start).
  void set_decimate(double decimate);
  void set_min_white_black_diff(int grey_levels);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The tags of both full and half resolution, each once, in TagDetector's order. At half the resolution AprilTag finds
/// tags that it misses at full resolution (large ones on textured paper), and the other way round: for still pictures,
/// where time does not matter. The detector is left at half resolution.
std::vector<Detection> detect_at_both(TagDetector& detector, const Frame& frame);

/// The decimation that finds tags of this size without errors: 2 where a module, an eighth of a tag's edge [px], has at
/// least 3.5 px, else 1.
double decimate_for_edge(double edge_px);

}  // namespace skein::vision
