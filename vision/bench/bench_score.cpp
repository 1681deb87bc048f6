#include "vision/bench/bench_score.h"

#include <Eigen/Cholesky>

#include <time.h>

#include <algorithm>
#include <cmath>

namespace skein::vision::detail {
namespace {

// A pose further off than this is a wrong one, wherever the tag. [m], [rad]
constexpr double wrong_xy = 2e-3;
constexpr double wrong_theta = 2.0 * core::pi / 180.0;

double share_of(double part, std::int64_t count) {
  return part / static_cast<double>(std::max<std::int64_t>(1, count));
}

}  // namespace

void Score::add(const BenchMoment& truth, const std::vector<TagPose>& poses) {
  std::vector<bool> seen(truth.tags.size());
  for (const TagPose& pose : poses) {
    if (static_cast<std::size_t>(pose.tag) >= truth.tags.size()) {
      ++wrong_ids;
      continue;
    }
    const auto i = static_cast<std::size_t>(pose.tag);
    const double xy = core::distance(pose.pose, truth.tags[i].pose);
    const double theta = core::wrap_angle(pose.pose.theta - truth.tags[i].pose.theta);
    if (pose.covariance(0, 0) > 0.0) {
      const Eigen::Vector3d error(pose.pose.x - truth.tags[i].pose.x, pose.pose.y - truth.tags[i].pose.y, theta);
      nees += error.dot(pose.covariance.ldlt().solve(error)) / 3.0;
      ++with_covariance;
    }
    if (xy > wrong_xy || std::abs(theta) > wrong_theta) {
      ++wrong_poses;
      continue;
    }
    seen[i] = true;
    if (!truth.in_sight[i]) continue;
    ++right;
    xy2 += xy * xy;
    theta2 += theta * theta;
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    in_sight += truth.in_sight[i] ? 1 : 0;
    seen_in_sight += truth.in_sight[i] && seen[i] ? 1 : 0;
  }
}

double Score::recall() const {
  return share_of(100.0 * static_cast<double>(seen_in_sight), in_sight);
}

double Score::mean_nees() const {
  return share_of(nees, with_covariance);
}

double Score::rms_xy() const {
  return std::sqrt(share_of(xy2, right));
}

double Score::rms_theta() const {
  return std::sqrt(share_of(theta2, right));
}

double Score::percentile(double share) const {
  if (ms.empty()) return 0.0;
  std::vector<double> sorted = ms;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double own_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace skein::vision::detail
