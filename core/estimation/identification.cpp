#include "core/estimation/identification.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/estimation/statistics.h"
#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Parameters = Eigen::Matrix<double, unknowns, 1>;
using Information = Eigen::Matrix<double, unknowns, unknowns>;

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

/// The extended Kalman filter for one set of parameters.
class Filter {
 public:
  Filter(const IdentificationInput& input, const std::vector<bool>& used) : input_(input), used_(used) {}

  /// The innovations of all poses except those that begin anew; `expected`, if given, gets the headings.
  void run(const Parameters& p, std::vector<Found>& found, std::vector<double>* headings = nullptr) {
    found.clear();
    if (headings) headings->clear();
    const double left_step = pi / input_.believed.steps_per_turn * math::exp(p[at(Unknown::left_diameter)]);
    const double right_step = pi / input_.believed.steps_per_turn * math::exp(p[at(Unknown::right_diameter)]);
    const double track = math::exp(p[at(Unknown::track)]), delay = p[at(Unknown::delay)];
    const double slip = math::exp(p[at(Unknown::slip)]), turned = p[at(Unknown::tag_heading)];
    const double ahead = p[at(Unknown::tag_ahead)], aside = p[at(Unknown::tag_left)];
    const double xy = math::exp(2.0 * p[at(Unknown::sigma_xy)]) + finest_xy * finest_xy;
    const double theta_noise = math::exp(2.0 * p[at(Unknown::sigma_theta)]) + finest_theta * finest_theta;
    const Matrix3 noise = Vector3(xy, xy, theta_noise).asDiagonal();
    const auto& knots = input_.wheels;
    std::size_t knot = 0;  // the first behind the time reached
    Vector3 state;
    Matrix3 covariance;
    double t = 0.0;
    bool first = true;
    for (std::size_t k = 0; k < input_.poses.size(); ++k) {
      const SeenPose& seen = input_.poses[k];
      const double until = seen.t - delay;
      const Vector3 measured(seen.pose.x, seen.pose.y, seen.pose.theta);
      if (first || seen.anew) {
        first = false;
        const double theta = measured[2] - turned, c = math::cos(theta), s = math::sin(theta);
        state << measured[0] - ahead * c + aside * s, measured[1] - ahead * s - aside * c, theta;
        Matrix3 back = Matrix3::Identity();  // d state / d measured
        back(0, 2) = ahead * s + aside * c;
        back(1, 2) = -ahead * c + aside * s;
        covariance = back * noise * back.transpose();
        while (knot > 0 && knots[knot - 1].t > until) --knot;
        while (knot < knots.size() && knots[knot].t <= until) ++knot;
        t = until;
        continue;
      }
      // The way of both wheels up to there, arc by arc.
      const Vector3 before = state;
      double left_way = 0.0, right_way = 0.0;
      const double whole = until - t;
      while (t < until) {
        const double end = knot < knots.size() ? std::min(until, knots[knot].t) : until;
        if (knot > 0 && knot < knots.size()) {
          const WheelKnot &a = knots[knot - 1], &b = knots[knot];
          const double share = (end - t) / (b.t - a.t);
          const double left = left_step * share * (b.left - a.left), right = right_step * share * (b.right - a.right);
          const double turn = (right - left) / track, half = 0.5 * turn;
          const double chord = 0.5 * (left + right) * sinc(half);
          state[0] += chord * math::cos(state[2] + half);
          state[1] += chord * math::sin(state[2] + half);
          state[2] += turn;
          left_way += std::abs(left);
          right_way += std::abs(right);
        }
        t = end;
        if (knot < knots.size() && knots[knot].t <= t) ++knot;
      }
      if (whole > 0.0) {
        Matrix3 carry = Matrix3::Identity();
        carry(0, 2) = -(state[1] - before[1]);
        carry(1, 2) = state[0] - before[0];
        const double middle = 0.5 * (before[2] + state[2]), c = math::cos(middle), s = math::sin(middle);
        Eigen::Matrix<double, 3, 2> wheels;
        wheels << 0.5 * c, 0.5 * c, 0.5 * s, 0.5 * s, -1.0 / track, 1.0 / track;
        // A heading that is off half way on average moves the end sideways, too.
        wheels.row(0) -= 0.5 * (state[1] - before[1]) * wheels.row(2);
        wheels.row(1) += 0.5 * (state[0] - before[0]) * wheels.row(2);
        const double scale = slip * slip * input_.slip_period / whole;
        const Eigen::Vector2d ways(scale * left_way * left_way, scale * right_way * right_way);
        covariance = carry * covariance * carry.transpose() + wheels * ways.asDiagonal() * wheels.transpose();
      }
      const auto [s, c] = math::sincos(state[2]);
      Matrix3 seen_by = Matrix3::Identity();
      seen_by(0, 2) = -ahead * s - aside * c;
      seen_by(1, 2) = ahead * c - aside * s;
      Found innovation;
      innovation.error << measured[0] - (state[0] + ahead * c - aside * s),
          measured[1] - (state[1] + ahead * s + aside * c), wrap_angle(measured[2] - state[2] - turned);
      innovation.covariance = seen_by * covariance * seen_by.transpose() + noise;
      if (headings) headings->push_back(state[2]);
      if (used_[found.size()]) {
        const Matrix3 gain = covariance * seen_by.transpose() * innovation.covariance.inverse();
        state += gain * innovation.error;
        const Matrix3 rest = Matrix3::Identity() - gain * seen_by;
        covariance = rest * covariance * rest.transpose() + gain * noise * gain.transpose();
      }
      found.push_back(innovation);
    }
  }

 private:
  const IdentificationInput& input_;
  const std::vector<bool>& used_;
};

class Search {
 public:
  Search(const IdentificationInput& input, std::size_t innovations)
      : used_(innovations, true), filter_(input, used_), prior_(prior_of(input.believed)) {}

  /// Minus the logarithm of the posterior, up to a constant.
  double cost(const Parameters& p) {
    filter_.run(p, found_);
    double sum = 0.5 * (p - prior_.mean).cwiseQuotient(prior_.sigma).squaredNorm();
    for (std::size_t k = 0; k < found_.size(); ++k)
      if (used_[k])
        sum += 0.5 * (math::log(found_[k].covariance.determinant()) +
                      found_[k].error.dot(found_[k].covariance.inverse() * found_[k].error));
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  }

  /// Fisher's scoring, damped where a step does not help. False: it does not come to rest.
  bool climb(Parameters& p, int& iterations) {
    constexpr int most = 60;
    double here = cost(p), damping = 0.0;
    for (int i = 0; i < most; ++i, ++iterations) {
      Parameters slope;
      linearise(p, slope, information_);
      for (int tries = 0;; ++tries) {
        Information damped = information_;
        damped.diagonal() *= 1.0 + damping;
        Parameters step = damped.ldlt().solve(-slope);
        // No step farther than the prior finds likely.
        step /= std::max(1.0, step.cwiseQuotient(prior_.sigma).cwiseAbs().maxCoeff());
        const double there = cost(p + step);
        if (there <= here) {
          const double improved = step.dot(information_ * step);
          // Along a kink (see delay_posterior) only short steps help: what they gain is far below what noise does.
          const bool crawls = damping > 0.0 && here - there < 1e-4;
          p += step;
          here = there;
          damping = damping < 1e-3 ? 0.0 : damping * 0.1;
          if (improved < 1e-6 || crawls) {
            linearise(p, slope, information_);
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
    filter_.run(p, found_);
    std::size_t dropped = 0;
    for (std::size_t k = 0; k < found_.size(); ++k)
      if (used_[k] && found_[k].error.dot(found_[k].covariance.inverse() * found_[k].error) > far)
        used_[k] = false, ++dropped;
    return dropped;
  }

  /// Moves the noise from where all parameters together are likeliest to where it is likeliest by itself, whatever the
  /// others are (restricted maximum likelihood). A fit follows a part of the noise: of the slip, which wanders off
  /// slowly and of which a run tells as much as some dozens of draws would, as much as several parameters can follow. A
  /// step of Newton's, with Laplace's integral over the others.
  void discount_fit(Parameters& p) {
    constexpr double h = 0.02;
    Parameters slope;
    linearise(p, slope, information_);
    const Information covariance = information_.inverse();
    const auto log_determinant = [&](const Parameters& there) {
      Information information;
      linearise(there, slope, information);
      return information.ldlt().vectorD().array().log().sum();
    };
    Parameters step = Parameters::Zero();
    for (const Unknown noise : {Unknown::slip, Unknown::sigma_xy, Unknown::sigma_theta}) {
      Parameters more = p, less = p;
      more[at(noise)] += h, less[at(noise)] -= h;
      step -= 0.5 * (log_determinant(more) - log_determinant(less)) / (2.0 * h) * covariance.col(at(noise));
    }
    if (!step.allFinite()) return;
    // Farther than a standard deviation a single step is a guess.
    p += step / std::max(1.0, step.cwiseAbs().cwiseQuotient(covariance.diagonal().cwiseSqrt()).maxCoeff());
    linearise(p, slope, information_);
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
  Filter& filter() noexcept { return filter_; }

 private:
  void linearise(const Parameters& p, Parameters& slope, Information& information) {
    constexpr double h = 1e-6;
    filter_.run(p, found_);
    for (std::size_t i = 0; i < unknowns; ++i) {
      Parameters there = p;
      there[i] += h;
      filter_.run(there, moved_[i]);
    }
    slope = (p - prior_.mean).cwiseQuotient(prior_.sigma.cwiseProduct(prior_.sigma));
    information = prior_.sigma.cwiseProduct(prior_.sigma).cwiseInverse().asDiagonal();
    std::array<Vector3, unknowns> error;
    std::array<Matrix3, unknowns> spread;  // S^-1 dS
    for (std::size_t k = 0; k < found_.size(); ++k) {
      if (!used_[k]) continue;
      const Matrix3 inverse = found_[k].covariance.inverse();
      const Vector3 weighted = inverse * found_[k].error;
      for (std::size_t i = 0; i < unknowns; ++i) {
        Vector3 difference = moved_[i][k].error - found_[k].error;
        difference[2] = wrap_angle(difference[2]);
        error[i] = difference / h;
        spread[i] = inverse * (moved_[i][k].covariance - found_[k].covariance) / h;
        slope[i] += weighted.dot(error[i]) + 0.5 * spread[i].trace() -
                    0.5 * weighted.dot(found_[k].covariance * (spread[i] * weighted));
      }
      for (std::size_t i = 0; i < unknowns; ++i)
        for (std::size_t j = 0; j <= i; ++j)
          information(i, j) +=
              error[i].dot(inverse * error[j]) + 0.5 * spread[i].cwiseProduct(spread[j].transpose()).sum();
    }
    information.triangularView<Eigen::StrictlyUpper>() = information.transpose();
  }

  std::vector<bool> used_;
  Filter filter_;
  Prior prior_;
  std::vector<Found> found_;
  std::array<std::vector<Found>, unknowns> moved_;
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
  constexpr double stride = 0.05, last = 0.6;
  double best = std::numeric_limits<double>::infinity();
  for (double delay = -0.1; delay <= last; delay += stride) {
    Parameters there = search.prior().mean;
    there[at(Unknown::delay)] = delay;
    if (const double cost = search.cost(there); cost < best) best = cost, p = there;
  }
  result.converged = search.climb(p, result.iterations);
  for (int round = 0; round < 3 && result.converged && search.drop_outliers(p) > 0; ++round)
    result.converged = search.climb(p, result.iterations);

  Information covariance = search.information().inverse();
  std::optional<DelayPosterior> delay;
  for (int round = 0; result.converged; ++round) {
    constexpr double better = 0.05;
    search.discount_fit(p);
    covariance = search.information().inverse();
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

  std::vector<Found> found;
  std::vector<double> headings;
  search.filter().run(p, found, &headings);
  std::size_t k = 0;
  for (std::size_t pose = 1; pose < input.poses.size(); ++pose) {
    if (input.poses[pose].anew) continue;
    const Vector3& error = found[k].error;
    const auto [s, c] = math::sincos(headings[k]);
    result.innovations.push_back({input.poses[pose].t, c * error[0] + s * error[1], -s * error[0] + c * error[1],
                                  error[2], error.dot(found[k].covariance.inverse() * error), search.used()[k]});
    ++k;
  }
  return result;
}

}  // namespace skein::core
