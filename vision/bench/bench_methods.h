#pragma once

#include <memory>
#include <string>
#include <vector>

#include "vision/bench/bench_scenes.h"
#include "vision/frames/frame.h"
#include "vision/tags/tag_pose.h"

namespace skein::vision::detail {

/// A method that computes the poses of tags from a frame.
class BenchMethod {
 public:
  virtual ~BenchMethod() = default;
  /// Resets its state.
  virtual void restart() {}
  virtual const std::vector<TagPose>& detect(const Frame& frame) = 0;

  std::string name;
};

/// AprilTag out of the box (first), tuned, ArUco (where its module can be loaded), and the tracker (last).
std::vector<std::unique_ptr<BenchMethod>> bench_methods(const BenchScene& scene);

}  // namespace skein::vision::detail
