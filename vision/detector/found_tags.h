#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <tuple>

#include "vision/tags/detection.h"

struct apriltag_detector;
struct apriltag_family;

namespace skein::vision::detail {

/// A tag has 8 modules and a border; AprilTag's thresholding works on whole 4x4 tiles and reads past a picture smaller
/// than one. [px]
inline constexpr int least_side = 16;

/// Makes the table by which AprilTag reads the codes of a family, with so many wrong bits; two take 45 ms and 19 MB.
/// Without memory for it AprilTag writes a line to stderr, and would never see a tag: throws std::bad_alloc.
void make_table(apriltag_family& family, int bits_corrected);

/// The robots' family, with its table. Detectors only read it: the process has one of it, and keeps it to its end.
apriltag_family& family_36h11();

/// Destroys a detector and none of its families' tables, which AprilTag would destroy as well.
struct DestroyDetector {
  void operator()(apriltag_detector* detector) const;
};
using AprilTagDetector = std::unique_ptr<apriltag_detector, DestroyDetector>;
AprilTagDetector create_detector();

/// From now on the detector looks for tags of this family, which has its table, too.
void add_family(apriltag_detector& detector, apriltag_family& family);

/// AprilTag does not look at what malloc answers, and ends the process by a signal where there is no memory. Where
/// memory is limited (`ulimit -v`, `ulimit -d`) and a search of so many pixels may exceed it: throws std::bad_alloc.
void expect_memory_for(int width, int height);

/// What AprilTag found in a picture that begins at this pixel of the frame; the likeness is left open.
inline Detection detection_of(int tag, float decision_margin, const double (&corners)[4][2], int left = 0,
                              int top = 0) {
  Detection detection;
  detection.tag = tag;
  detection.decision_margin = static_cast<double>(decision_margin);
  // AprilTag puts (0, 0) at the top-left pixel's outer corner, we at its centre.
  for (std::size_t corner = 0; corner < 4; ++corner)
    detection.corners[corner] = {corners[corner][0] - 0.5 + left, corners[corner][1] - 0.5 + top};
  return detection;
}

/// One tag that was found at two resolutions.
inline bool same_tag(const Detection& a, const Detection& b) {
  const auto distance = [](const auto& p, const auto& q) { return std::hypot(p[0] - q[0], p[1] - q[1]); };
  return a.tag == b.tag && distance(a.corners[0], b.corners[0]) < 0.5 * distance(a.corners[0], a.corners[1]);
}

/// The order in which tags are reported.
inline bool by_id(const Detection& a, const Detection& b) {
  return std::tie(a.tag, a.corners) < std::tie(b.tag, b.corners);
}

}  // namespace skein::vision::detail
