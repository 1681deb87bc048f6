#include "core/estimation/identification.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/estimation/statistics.h"
#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"
#include "core/math/small_matrix.h"

namespace skein::core {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Parameters = Eigen::Matrix<double, unknowns, 1>;
using Information = Eigen::Matrix<double, unknowns, unknowns>;
using Decomposition = Eigen::LDLT<Eigen::MatrixXd>;  // of any size: it takes less time to compile

constexpr std::size_t at(Unknown unknown) noexcept {
  return static_cast<std::size_t>(unknown);
}

/// Those that are above 0 are sought by their logarithms.
constexpr bool logarithmic(Unknown unknown) noexcept {
  switch (unknown) {
    case Unknown::left_diameter:
    case Unknown::right_diameter:
    case Unknown::track:
    case Unknown::slip:
    case Unknown::sigma_xy:
    case Unknown::sigma_theta:
      return true;
    case Unknown::delay:
    case Unknown::tag_heading:
    case Unknown::tag_ahead:
    case Unknown::tag_left:
      return false;
  }
  return false;
}

// What no camera tells: without it, poses without noise would be an equation, and not an estimate. [m, rad]
constexpr double finest_xy = 2e-5, finest_theta = 2e-4;

// Of a long run so many tell nearly all: the search goes near the place by them, and the last steps by all.
constexpr std::size_t enough_poses = 20'000;

struct Prior {
  Parameters mean, sigma;
};
Prior prior_of(const DifferentialDrive& believed) {
  Prior p;
  //        left           right            track                delay slip           tag: heading, ahead, left  noise
  p.mean << math::log(believed.left_diameter()), math::log(believed.right_diameter()), math::log(believed.track), 0.1,
      math::log(0.02), 0.0, 0.0, 0.0, math::log(1e-3), math::log(5e-3);
  p.sigma << 0.2, 0.2, 0.3, 0.3, 3.0, 0.2, 0.01, 0.01, 4.0, 4.0;
  return p;
}

/// What the data say of the delay, relative to where it was looked at. [s, s^2]
struct DelayPosterior {
  double mean = 0.0, variance = 0.0;
  double low = 0.0, high = 0.0;  // 2.5 % of it are below, and above
  double likeliest = 0.0;
  double gained = 0.0;  // by going there: how much the cost falls
};

struct Found {
  Vector3 error;       // pose - expected, in the world frame
  Matrix3 covariance;  // of it
};

/// The extended Kalman filter for one set of parameters, pose by pose: in a memory that does not grow with the run.
class Filter {
 public:
  /// Of the first `poses` poses.
  Filter(const IdentificationInput& input, const std::vector<bool>& used, std::size_t poses, const Parameters& p)
      : input_(input),
        used_(used),
        poses_(poses),
        left_step_(pi / input.believed.steps_per_turn * math::exp(p[at(Unknown::left_diameter)])),
        right_step_(pi / input.believed.steps_per_turn * math::exp(p[at(Unknown::right_diameter)])),
        track_(math::exp(p[at(Unknown::track)])),
        delay_(p[at(Unknown::delay)]),
        slip_(math::exp(p[at(Unknown::slip)])),
        turned_(p[at(Unknown::tag_heading)]),
        ahead_(p[at(Unknown::tag_ahead)]),
        aside_(p[at(Unknown::tag_left)]) {
    const double xy = math::exp(2.0 * p[at(Unknown::sigma_xy)]) + finest_xy * finest_xy;
    const double theta = math::exp(2.0 * p[at(Unknown::sigma_theta)]) + finest_theta * finest_theta;
    noise_ = Vector3(xy, xy, theta).asDiagonal();
  }

  /// The innovation of the next pose that does not begin anew. False: there is none.
  bool next(Found& innovation) {
    for (; pose_ < poses_ && (pose_ == 0 || input_.poses[pose_].anew); ++pose_) begin(input_.poses[pose_]);
    if (pose_ >= poses_) return false;
    const SeenPose& seen = input_.poses[pose_++];
    drive(seen.t - delay_);
    const auto [s, c] = math::sincos(state_[2]);
    Matrix3 seen_by = Matrix3::Identity();
    seen_by(0, 2) = -ahead_ * s - aside_ * c;
    seen_by(1, 2) = ahead_ * c - aside_ * s;
    innovation.error << seen.pose.x - (state_[0] + ahead_ * c - aside_ * s),
        seen.pose.y - (state_[1] + ahead_ * s + aside_ * c), wrap_angle(seen.pose.theta - state_[2] - turned_);
    innovation.covariance = seen_by * covariance_ * seen_by.transpose() + noise_;
    expected_heading_ = state_[2];
    if (used_[found_++]) {
      const Matrix3 gain = covariance_ * seen_by.transpose() * innovation.covariance.inverse();
      state_ += gain * innovation.error;
      const Matrix3 rest = Matrix3::Identity() - gain * seen_by;
      covariance_ = rest * covariance_ * rest.transpose() + gain * noise_ * gain.transpose();
    }
    return true;
  }
  /// The pose of the newest innovation, and the heading that was expected there [rad].
  const SeenPose& pose() const noexcept { return input_.poses[pose_ - 1]; }
  double expected_heading() const noexcept { return expected_heading_; }

 private:
  void begin(const SeenPose& seen) {
    const auto& knots = input_.wheels;
    t_ = seen.t - delay_;
    const double theta = seen.pose.theta - turned_;
    const auto [s, c] = math::sincos(theta);
    state_ << seen.pose.x - ahead_ * c + aside_ * s, seen.pose.y - ahead_ * s - aside_ * c, theta;
    Matrix3 back = Matrix3::Identity();  // d state / d measured
    back(0, 2) = ahead_ * s + aside_ * c;
    back(1, 2) = -ahead_ * c + aside_ * s;
    covariance_ = back * noise_ * back.transpose();
    while (knot_ > 0 && knots[knot_ - 1].t > t_) --knot_;
    while (knot_ < knots.size() && knots[knot_].t <= t_) ++knot_;
  }

  void drive(double until) {
    const auto& knots = input_.wheels;
    // The way of both wheels up to there, arc by arc.
    const Vector3 before = state_;
    double left_way = 0.0, right_way = 0.0;
    const double whole = until - t_;
    while (t_ < until) {
      const double end = knot_ < knots.size() ? std::min(until, knots[knot_].t) : until;
      if (knot_ > 0 && knot_ < knots.size()) {
        const WheelKnot &a = knots[knot_ - 1], &b = knots[knot_];
        const double share = (end - t_) / (b.t - a.t);
        const double left = left_step_ * share * (b.left - a.left), right = right_step_ * share * (b.right - a.right);
        const double turn = (right - left) / track_, half = 0.5 * turn;
        const double chord = 0.5 * (left + right) * sinc(half);
        const auto [s, c] = math::sincos(state_[2] + half);
        state_[0] += chord * c;
        state_[1] += chord * s;
        state_[2] += turn;
        left_way += std::abs(left);
        right_way += std::abs(right);
      }
      t_ = end;
      if (knot_ < knots.size() && knots[knot_].t <= t_) ++knot_;
    }
    if (!(whole > 0.0)) return;
    Matrix3 carry = Matrix3::Identity();
    carry(0, 2) = -(state_[1] - before[1]);
    carry(1, 2) = state_[0] - before[0];
    const auto [s, c] = math::sincos(0.5 * (before[2] + state_[2]));
    Eigen::Matrix<double, 3, 2> wheels;
    wheels << 0.5 * c, 0.5 * c, 0.5 * s, 0.5 * s, -1.0 / track_, 1.0 / track_;
    // A heading that is off half way on average moves the end sideways, too.
    wheels.row(0) -= 0.5 * (state_[1] - before[1]) * wheels.row(2);
    wheels.row(1) += 0.5 * (state_[0] - before[0]) * wheels.row(2);
    const double scale = slip_ * slip_ * input_.slip_period / whole;
    const Eigen::Vector2d ways(scale * left_way * left_way, scale * right_way * right_way);
    covariance_ = carry * covariance_ * carry.transpose() + wheels * ways.asDiagonal() * wheels.transpose();
  }

  const IdentificationInput& input_;
  const std::vector<bool>& used_;
  std::size_t poses_;
  double left_step_, right_step_, track_, delay_, slip_, turned_, ahead_, aside_;
  Matrix3 noise_;
  std::size_t pose_ = 0, found_ = 0;
  std::size_t knot_ = 0;  // the first behind the time reached
  double t_ = 0.0;        // the time reached
  Vector3 state_;
  Matrix3 covariance_;
  double expected_heading_ = 0.0;
};

class Search {
 public:
  Search(const IdentificationInput& input, std::size_t innovations)
      : input_(input), used_(innovations, true), poses_(input.poses.size()), prior_(prior_of(input.believed)) {}

  /// From now on only the first poses count; at most all.
  void look_at(std::size_t poses) { poses_ = std::min(poses, input_.poses.size()); }

  Filter filter(const Parameters& p) const { return {input_, used_, poses_, p}; }

  /// Minus the logarithm of the posterior, up to a constant.
  double cost(const Parameters& p) const {
    double sum = 0.5 * (p - prior_.mean).cwiseQuotient(prior_.sigma).squaredNorm();
    Filter filter = this->filter(p);
    Found found;
    for (std::size_t k = 0; filter.next(found); ++k)
      if (used_[k])
        sum += 0.5 *
               (math::log(found.covariance.determinant()) + found.error.dot(found.covariance.inverse() * found.error));
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  }

  /// Fisher's scoring, damped where a step does not help. False: it does not come to rest.
  bool climb(Parameters& p, int& iterations) {
    constexpr int most = 60;
    // Of a long run every step is dear, and so much less of the cost is a thirtieth of a standard deviation.
    const double settled = poses_ > enough_poses ? 1e-3 : 1e-6;
    double here = cost(p), damping = 0.0;
    for (int i = 0; i < most; ++i, ++iterations) {
      Parameters slope;
      linearise(p, slope, information_);
      Information curved = information_;
      for (const Unknown noise : {Unknown::slip, Unknown::sigma_xy, Unknown::sigma_theta})
        curved(at(noise), at(noise)) = curvature(at(noise), p, slope);
      for (int tries = 0;; ++tries) {
        Information damped = curved;
        damped.diagonal() *= 1.0 + damping;
        Parameters step = Decomposition(damped).solve(Eigen::VectorXd(-slope));
        // No step farther than the prior finds likely.
        step /= std::max(1.0, step.cwiseQuotient(prior_.sigma).cwiseAbs().maxCoeff());
        const double there = cost(p + step);
        if (there <= here) {
          const double improved = step.dot(information_ * step);
          // Along a kink (see delay_posterior) only short steps help: what they gain is far below what noise does.
          const bool crawls = damping > 0.0 && here - there < 100.0 * settled;
          p += step;
          here = there;
          damping = damping < 1e-3 ? 0.0 : damping * 0.1;
          if (improved < settled || crawls) {
            inform(p);
            return true;
          }
          break;
        }
        // At the end of what doubles can tell there is no better place.
        if (step.dot(information_ * step) < 1e-6) return true;
        if (tries == 20) return false;
        damping = damping == 0.0 ? 1e-3 : damping * 10.0;
      }
    }
    return false;
  }

  /// Poses that are no part of the rest, whose chance is below one in 10^7, count for nothing from now on. How many.
  std::size_t drop_outliers(const Parameters& p) {
    constexpr double far = 35.0;
    Filter filter = this->filter(p);
    Found found;
    std::vector<std::size_t> dropped;  // afterwards: the filter goes by those that are used
    for (std::size_t k = 0; filter.next(found); ++k)
      if (used_[k] && found.error.dot(found.covariance.inverse() * found.error) > far) dropped.push_back(k);
    for (const std::size_t k : dropped) used_[k] = false;
    return dropped.size();
  }

  /// Moves the noise from where all parameters together are likeliest to where it is likeliest by itself, whatever the
  /// others are (restricted maximum likelihood). A fit follows a part of the noise: of the slip, which wanders off
  /// slowly and of which a run tells as much as some dozens of draws would, as much as several parameters can follow. A
  /// step of Newton's, with Laplace's integral over the others. After climb(), which came to rest at `p`.
  void discount_fit(Parameters& p) {
    constexpr double h = 0.02;
    Parameters slope;
    const Information covariance = math::inverse(information_);
    const auto log_determinant = [&](const Parameters& there) {
      Information information;
      linearise(there, slope, information);  // of a part: how it changes with p does not depend on the length
      return Decomposition(information).vectorD().array().log().sum();
    };
    Parameters step = Parameters::Zero();
    look_at(enough_poses);
    for (const Unknown noise : {Unknown::slip, Unknown::sigma_xy, Unknown::sigma_theta}) {
      Parameters more = p, less = p;
      more[at(noise)] += h, less[at(noise)] -= h;
      step -= 0.5 * (log_determinant(more) - log_determinant(less)) / (2.0 * h) * covariance.col(at(noise));
    }
    look_at(input_.poses.size());
    if (!step.allFinite()) return;
    // Farther than a standard deviation a single step is a guess.
    p += step / std::max(1.0, step.cwiseAbs().cwiseQuotient(covariance.diagonal().cwiseSqrt()).maxCoeff());
    inform(p);
  }

  /// Fisher's information tells the posterior's curvature where it is likeliest. Of the delay that is not enough:
  /// wheels change their speeds at the ticks, and a delay at which a pose meets a change is a kink of the expected
  /// pose. On either side of a kink, and kinks are a tick apart, other changes of speed tell the delay; it is another
  /// parabola, and there may be a second maximum. So the posterior is summed up, along the line on which the other
  /// parameters follow the delay.
  DelayPosterior delay_posterior(const Parameters& p, const Information& covariance) {
    constexpr double fine = 0.25, negligible = 8.0;
    constexpr int fine_steps = 16, most = 60;  // to either side
    const double variance = covariance(at(Unknown::delay), at(Unknown::delay));
    const Parameters line = covariance.col(at(Unknown::delay)) / variance;
    struct Point {
      double delay, cost;
    };
    const double here = cost(p);
    std::vector<Point> points{{0.0, 0.0}};
    Point best = points.front();
    for (const double side : {-1.0, 1.0}) {
      double stride = fine * std::sqrt(variance), delay = 0.0;
      for (int k = 0; k < most; ++k) {
        delay += side * stride;
        points.push_back({delay, cost(p + line * delay) - here});
        if (points.back().cost < best.cost) best = points.back();
        if (points.back().cost > best.cost + negligible) break;
        if (k >= fine_steps) stride *= 1.1;  // a flat side is a long one
      }
    }
    std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.delay < b.delay; });
    double mass = 0.0, first = 0.0, second = 0.0;
    std::vector<double> until{0.0};  // the mass below each point
    for (std::size_t k = 1; k < points.size(); ++k) {
      const auto [a, cost_a] = points[k - 1];
      const auto [b, cost_b] = points[k];
      const double share_a = 0.5 * (b - a) * math::exp(best.cost - cost_a);
      const double share_b = 0.5 * (b - a) * math::exp(best.cost - cost_b);
      mass += share_a + share_b;
      first += share_a * a + share_b * b;
      second += share_a * a * a + share_b * b * b;
      until.push_back(mass);
    }
    const auto quantile = [&](double share) {
      const auto k = std::max<std::ptrdiff_t>(
          1, std::lower_bound(until.begin(), std::prev(until.end()), share * mass) - until.begin());
      const double below = until[k - 1], within = until[k] - below;
      return std::lerp(points[k - 1].delay, points[k].delay, (share * mass - below) / within);
    };
    const double mean = first / mass;
    return {mean, second / mass - mean * mean, quantile(0.025), quantile(0.975), best.delay, -best.cost};
  }

  const Information& information() const noexcept { return information_; }
  const Prior& prior() const noexcept { return prior_; }
  const std::vector<bool>& used() const noexcept { return used_; }

 private:
  /// Takes the information at `p`. For a long run, whose passes are expensive, the last one taken serves: `p` has moved
  /// by a fraction of a standard deviation since.
  void inform(const Parameters& p) {
    Parameters slope;
    if (poses_ <= enough_poses) linearise(p, slope, information_);
  }

  /// The curvature of the cost along the logarithm of a noise, for a step. Where a noise is far below the others, the
  /// cost grows with its square, an exponential of its logarithm. Fisher's information does not contain that curvature:
  /// steps by it alone oscillate, and the damping that stops them slows all other parameters. Instead this is the
  /// secant from here to where that exponential and the prior balance.
  double curvature(std::size_t noise, const Parameters& p, const Parameters& slope) const {
    const double before = 1.0 / math::squared(prior_.sigma[noise]);
    const double pull = (p[noise] - prior_.mean[noise]) * before, push = slope[noise] - pull;
    if (!(push > information_(noise, noise) - before)) return information_(noise, noise);
    constexpr int enough = 50;
    double way = 0.0;
    for (int k = 0; k < enough; ++k) {
      const double steep = push * math::exp(2.0 * way);
      way -= (pull + before * way + steep) / (before + 2.0 * steep);
    }
    constexpr double there = 1e-6;
    return std::abs(way) > there ? -slope[noise] / way : before + 2.0 * push;
  }

  void linearise(const Parameters& p, Parameters& slope, Information& information) {
    constexpr double h = 1e-6;
    Filter filter = this->filter(p);
    std::array<std::optional<Filter>, unknowns> filters;
    for (std::size_t i = 0; i < unknowns; ++i) {
      Parameters there = p;
      there[i] += h;
      filters[i].emplace(this->filter(there));
    }
    slope = (p - prior_.mean).cwiseQuotient(prior_.sigma.cwiseProduct(prior_.sigma));
    information = prior_.sigma.cwiseProduct(prior_.sigma).cwiseInverse().asDiagonal();
    std::array<Vector3, unknowns> error;
    std::array<Matrix3, unknowns> spread;  // S^-1 dS
    Found found;
    std::array<Found, unknowns> moved;
    for (std::size_t k = 0; filter.next(found); ++k) {
      for (std::size_t i = 0; i < unknowns; ++i) filters[i]->next(moved[i]);
      if (!used_[k]) continue;
      const Matrix3 inverse = found.covariance.inverse();
      const Vector3 weighted = inverse * found.error;
      for (std::size_t i = 0; i < unknowns; ++i) {
        Vector3 difference = moved[i].error - found.error;
        difference[2] = wrap_angle(difference[2]);
        error[i] = difference / h;
        spread[i] = inverse * (moved[i].covariance - found.covariance) / h;
        slope[i] += weighted.dot(error[i]) + 0.5 * spread[i].trace() -
                    0.5 * weighted.dot(found.covariance * (spread[i] * weighted));
      }
      for (std::size_t j = 0; j < unknowns; ++j) {
        const Vector3 by_covariance = inverse * error[j];
        for (std::size_t i = j; i < unknowns; ++i)
          information(i, j) += error[i].dot(by_covariance) + 0.5 * spread[i].cwiseProduct(spread[j].transpose()).sum();
      }
    }
    information.triangularView<Eigen::StrictlyUpper>() = information.transpose();
  }

  const IdentificationInput& input_;
  std::vector<bool> used_;
  std::size_t poses_;  // that count
  Prior prior_;
  Information information_;
};

}  // namespace

WheelLog::WheelLog(MotorModel motor) noexcept : left_(motor), right_(motor) {}

void WheelLog::advance(double t) {
  while (now_ < t) {
    const double seconds = std::min({t - now_, left_.rate_lasts(), right_.rate_lasts()});
    left_.advance(seconds);
    right_.advance(seconds);
    now_ = seconds < t - now_ ? now_ + seconds : t;
    knots_.push_back({now_, left_.position(), right_.position()});
  }
}

void WheelLog::command(double t, const WheelSpeeds& speeds) {
  if (knots_.empty()) {
    now_ = t;
    knots_.push_back({t, 0.0, 0.0});
  }
  advance(t);
  left_.command(speeds.left);
  right_.command(speeds.right);
}

std::vector<WheelKnot> WheelLog::finish(double t) && {
  if (!knots_.empty()) advance(t);
  return std::move(knots_);
}

DifferentialDrive Identification::drive(const DifferentialDrive& believed) const {
  DifferentialDrive drive = believed;
  drive.set_diameters((*this)[Unknown::left_diameter].value, (*this)[Unknown::right_diameter].value);
  drive.track = (*this)[Unknown::track].value;
  return drive;
}

double useful_width(Unknown unknown, double value) noexcept {
  switch (unknown) {
    case Unknown::left_diameter:
    case Unknown::right_diameter:
    case Unknown::track:
      return 0.01 * value;
    case Unknown::delay:
      return 0.02;
    case Unknown::slip:
    case Unknown::sigma_xy:
    case Unknown::sigma_theta:
      return value;
    case Unknown::tag_heading:
      return 2.0 * pi / 180.0;
    case Unknown::tag_ahead:
    case Unknown::tag_left:
      return 0.003;
  }
  return 0.0;
}

Identification identify(const IdentificationInput& input) {
  Identification result;
  result.correlation.setIdentity();
  const double step = pi / input.believed.steps_per_turn;
  const double left_step = step * input.believed.left_diameter(), right_step = step * input.believed.right_diameter();
  for (std::size_t k = 1; k < input.wheels.size(); ++k) {
    const double left = (input.wheels[k].left - input.wheels[k - 1].left) * left_step;
    const double right = (input.wheels[k].right - input.wheels[k - 1].right) * right_step;
    result.driven += std::abs(0.5 * (left + right));
    result.turned += std::abs(right - left) / input.believed.track;
  }
  std::size_t innovations = 0;
  for (std::size_t k = 1; k < input.poses.size(); ++k) innovations += !input.poses[k].anew;
  constexpr std::size_t least = 20;
  if (innovations < least || !(result.driven + result.turned > 0.0)) return result;

  Search search(input, innovations);
  Parameters p = search.prior().mean;
  // The delay first, coarsely: from too far away the search may find another fit of commands to poses.
  const auto begin_coarsely = [&] {
    constexpr double stride = 0.05, last = 0.6;
    double best = std::numeric_limits<double>::infinity();
    for (double delay = -0.1; delay <= last; delay += stride) {
      Parameters there = search.prior().mean;
      there[at(Unknown::delay)] = delay;
      if (const double cost = search.cost(there); cost < best) best = cost, p = there;
    }
  };
  search.look_at(enough_poses);
  begin_coarsely();
  result.converged = search.climb(p, result.iterations);
  if (input.poses.size() > enough_poses) {
    const auto delay = static_cast<Eigen::Index>(at(Unknown::delay));
    const double variance = math::inverse(search.information())(delay, delay);
    search.look_at(input.poses.size());
    // The robot may have stood all that time, and have told nothing.
    if (!result.converged || !(variance < math::squared(useful_width(Unknown::delay, 0.0)))) begin_coarsely();
    result.converged = search.climb(p, result.iterations);
  }
  for (int round = 0; round < 3 && result.converged && search.drop_outliers(p) > 0; ++round)
    result.converged = search.climb(p, result.iterations);

  Information covariance = math::inverse(search.information());
  std::optional<DelayPosterior> delay;
  for (int round = 0; result.converged; ++round) {
    constexpr double better = 0.05;
    search.discount_fit(p);
    covariance = math::inverse(search.information());
    delay = search.delay_posterior(p, covariance);
    const Parameters line = covariance.col(at(Unknown::delay)) / covariance(at(Unknown::delay), at(Unknown::delay));
    if (round < 3 && delay->gained > better) {  // it came to rest on the wrong side of a kink
      p += line * delay->likeliest;
      result.converged = search.climb(p, result.iterations);
      continue;
    }
    // All parameters on average over the delay.
    covariance += (delay->variance - covariance(at(Unknown::delay), at(Unknown::delay))) * line * line.transpose();
    delay->low += p[at(Unknown::delay)], delay->high += p[at(Unknown::delay)];
    p += line * delay->mean;
    break;
  }

  const auto within = [&](Estimate& e, double width) {
    e.known = result.converged && std::max(e.high - e.value, e.value - e.low) <= width;
  };
  for (std::size_t i = 0; i < unknowns; ++i) {
    const auto unknown = static_cast<Unknown>(i);
    const double sigma = std::sqrt(covariance(i, i));
    Estimate& e = result.estimates[i];
    const auto value = [&](double parameter) { return logarithmic(unknown) ? math::exp(parameter) : parameter; };
    e = {value(p[i]), value(p[i] - z_95 * sigma), value(p[i] + z_95 * sigma),
         1.0 - math::squared(sigma / search.prior().sigma[i])};
    if (unknown == Unknown::delay && delay) e.low = delay->low, e.high = delay->high;
    within(e, useful_width(unknown, e.value));
    for (std::size_t j = 0; j < unknowns; ++j)
      result.correlation(i, j) = covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
  }

  // Mean and ratio by their logarithms as well: what both wheels have in common, and in what they differ.
  const auto of_both = [&](double share_left, double share_right) {
    const std::size_t l = at(Unknown::left_diameter), r = at(Unknown::right_diameter);
    const auto variance = [&](double left, double right, double both) {
      return share_left * share_left * left + share_right * share_right * right + 2.0 * share_left * share_right * both;
    };
    const double sigma = std::sqrt(variance(covariance(l, l), covariance(r, r), covariance(l, r)));
    const Parameters& before = search.prior().sigma;
    const double value = share_left * p[l] + share_right * p[r];
    return Estimate{math::exp(value), math::exp(value - z_95 * sigma), math::exp(value + z_95 * sigma),
                    1.0 - sigma * sigma / variance(before[l] * before[l], before[r] * before[r], 0.0)};
  };
  result.wheel_diameter = of_both(0.5, 0.5);
  within(result.wheel_diameter, useful_width(Unknown::left_diameter, result.wheel_diameter.value));
  result.wheel_ratio = of_both(-1.0, 1.0);
  within(result.wheel_ratio, useful_ratio);

  Filter filter = search.filter(p);
  Found found;
  for (std::size_t k = 0; filter.next(found); ++k) {
    const Vector3& error = found.error;
    const auto [s, c] = math::sincos(filter.expected_heading());
    result.innovations.push_back({filter.pose().t, c * error[0] + s * error[1], -s * error[0] + c * error[1], error[2],
                                  error.dot(found.covariance.inverse() * error), search.used()[k]});
  }
  return result;
}

}  // namespace skein::core
