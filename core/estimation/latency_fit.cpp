#include "core/estimation/latency_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/pose.h"

namespace skein::core {
namespace {

/// A heading by the counters, up to a constant. [rad]
double heading_by(const DifferentialDrive& drive, const WheelKnot& wheels) {
  return pi / drive.steps_per_turn * (drive.right_diameter() * wheels.right - drive.left_diameter() * wheels.left) /
         drive.track;
}

/// A heading seen, without jumps by whole turns.
struct SeenHeading {
  double t, theta;  // [s], [rad]
};

/// Headings against what the counters say for a delay that is tried.
class HeadingFit {
 public:
  struct Solution {
    double squares = 0.0;  // of the residuals [rad^2]
    double scale = 0.0;
    Eigen::VectorXd residuals;  // [rad]
  };

  HeadingFit(const TurnRecord& turn, std::vector<SeenHeading> seen) : turn_(turn), seen_(std::move(seen)) {
    for (const WheelKnot& wheels : turn_.wheels) told_.push_back(heading_by(turn_.believed, wheels));
    const double seconds = seen_.back().t - seen_.front().t;
    knots_ = std::max<Eigen::Index>(2, std::lround(std::ceil(seconds / drift_knots)) + 1);
    spacing_ = seconds / static_cast<double>(knots_ - 1);
  }

  Solution at(double delay) const {
    const auto n = static_cast<Eigen::Index>(seen_.size());
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, knots_ + 1);  // counters, then the offset's knots
    Eigen::VectorXd headings(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const SeenHeading& one = seen_[static_cast<std::size_t>(k)];
      headings[k] = one.theta;
      columns(k, 0) = told_at(one.t - delay);
      const double place = (one.t - seen_.front().t) / spacing_;
      const Eigen::Index knot = std::min<Eigen::Index>(knots_ - 2, static_cast<Eigen::Index>(place));
      columns(k, 1 + knot) = 1.0 - (place - static_cast<double>(knot));
      columns(k, 2 + knot) = place - static_cast<double>(knot);
    }
    const Eigen::VectorXd solution =
        (columns.transpose() * columns).ldlt().solve(Eigen::VectorXd(columns.transpose() * headings));
    Solution found{0.0, solution[0], headings - columns * solution};
    found.squares = found.residuals.squaredNorm();
    return found;
  }

  /// The delay of the least squares: on a grid first, since the headings repeat themselves.
  double best() const {
    double delay = least_delay, least = at(delay).squares;
    const int steps = static_cast<int>((largest_delay - least_delay) / stride + 1e-9);
    for (int i = 1; i <= steps; ++i) {
      const double tried = least_delay + i * stride;
      if (const double squares = at(tried).squares; squares < least) least = squares, delay = tried;
    }
    double low = delay - stride, high = delay + stride;
    for (int i = 0; i < 25; ++i) {
      const double third = (high - low) / 3.0;
      if (at(low + third).squares < at(high - third).squares)
        high -= third;
      else
        low += third;
    }
    return 0.5 * (low + high);
  }

  std::size_t size() const { return seen_.size(); }
  Eigen::Index parameters() const { return knots_ + 2; }

  static constexpr double least_delay = -0.15, largest_delay = 0.6, stride = 0.005;  // [s]

 private:
  double told_at(double t) const {
    const auto after = std::upper_bound(turn_.wheels.begin(), turn_.wheels.end(), t,
                                        [](double time, const WheelKnot& knot) { return time < knot.t; });
    if (after == turn_.wheels.begin()) return told_.front();
    if (after == turn_.wheels.end()) return told_.back();
    const auto k = static_cast<std::size_t>(after - turn_.wheels.begin());
    const WheelKnot& before = turn_.wheels[k - 1];
    return told_[k - 1] + (told_[k] - told_[k - 1]) * (t - before.t) / (after->t - before.t);
  }

  static constexpr double drift_knots = 2.5;  // [s]
  const TurnRecord& turn_;
  std::vector<SeenHeading> seen_;
  std::vector<double> told_;  // by the counters [rad]
  Eigen::Index knots_ = 2;
  double spacing_ = 1.0;
};

}  // namespace

double TurnRecord::turned() const {
  double way = 0.0;
  for (std::size_t k = 1; k < wheels.size(); ++k)
    way += std::abs(heading_by(believed, wheels[k]) - heading_by(believed, wheels[k - 1]));
  return way;
}

LatencyFit fit_latency(const TurnRecord& turn) {
  LatencyFit result;
  if (turn.poses.size() < LatencyFit::least_poses || turn.wheels.empty()) return result;
  std::vector<SeenHeading> seen;
  seen.reserve(turn.poses.size());
  for (const SeenPose& pose : turn.poses)
    seen.push_back(
        {pose.t, seen.empty() ? pose.pose.theta : seen.back().theta + wrap_angle(pose.pose.theta - seen.back().theta)});
  const HeadingFit fit(turn, seen);
  result.late = fit.best();
  const HeadingFit::Solution found = fit.at(result.late);
  result.scale = found.scale;
  const double n = static_cast<double>(fit.size());
  result.heading_rms = std::sqrt(found.squares / n);
  // The curvature of the squares; residuals that resemble their neighbours count for less than as many.
  constexpr double step = 2e-3;
  const double curvature =
      (fit.at(result.late + step).squares - 2.0 * found.squares + fit.at(result.late - step).squares) / (step * step);
  const double together =
      found.residuals.head(found.residuals.size() - 1).dot(found.residuals.tail(found.residuals.size() - 1)) /
      std::max(found.squares, 1e-12);
  const double correlation = std::clamp(together, 0.0, 0.95);
  const double variance = found.squares / (n - static_cast<double>(fit.parameters()));
  result.sigma = std::sqrt(2.0 * variance / std::max(curvature, 1e-12) * (1.0 + correlation) / (1.0 - correlation));

  const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
  result.halves = {HeadingFit(turn, {seen.begin(), middle}).best(), HeadingFit(turn, {middle, seen.end()}).best()};
  return result;
}

}  // namespace skein::core
