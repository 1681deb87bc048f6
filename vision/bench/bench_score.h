#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "vision/bench/bench_scenes.h"
#include "vision/tags/tag_pose.h"

namespace skein::vision::detail {

/// The score of a method in a scene.
struct Score {
  std::vector<double> ms;
  double xy2 = 0.0;
  double theta2 = 0.0;
  double nees = 0.0;  // sum over the poses that come with a covariance
  std::int64_t with_covariance = 0;
  std::int64_t right = 0;
  std::int64_t in_sight = 0;
  std::int64_t seen_in_sight = 0;
  std::int64_t wrong_poses = 0;
  std::int64_t wrong_ids = 0;

  void add(const BenchMoment& truth, const std::vector<TagPose>& poses);

  double recall() const;     // of the tags in sight [%]
  double mean_nees() const;  // normalised estimation error squared, per degree of freedom: 1 where the claimed
                             // deviations are true
  double rms_xy() const;     // [m]
  double rms_theta() const;  // [rad]
  double percentile(double share) const;  // of the times [ms]; 0 without any
};

/// By the names of the methods.
using Scores = std::map<std::string, Score>;

/// The CPU time of this thread: every method uses one thread, and other load on the machine must not count. [ms]
double own_ms();

}  // namespace skein::vision::detail
