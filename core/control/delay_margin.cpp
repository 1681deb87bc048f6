#include "core/control/delay_margin.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <deque>

#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"

namespace skein::core {
namespace {

constexpr int most_periods = 64;
/// An error that is not corrected at all (y beside a reference that stands) has the eigenvalue 1: it does not grow.
constexpr double root_rounding = 1e-7;

/// e' = A e - B u over a time h with u held: e(h) = transition e(0) - input u.
struct Step {
  Eigen::Matrix3d transition;
  Eigen::Matrix<double, 3, 2> input;
};

Step step(const Twist& reference, double h) {
  // The series of exp(M h) and of its integral, over a time so short that ten terms are exact, then doubled.
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  a(0, 1) = reference.omega;
  a(1, 0) = -reference.omega;
  a(1, 2) = reference.v;
  Eigen::Matrix<double, 3, 2> b = Eigen::Matrix<double, 3, 2>::Zero();
  b(0, 0) = 1.0;
  b(2, 1) = 1.0;
  int doublings = 0;
  for (double size = a.norm() * h; size > 0.25; size *= 0.5) ++doublings;
  const double part = std::ldexp(h, -doublings);
  Eigen::Matrix3d transition = Eigen::Matrix3d::Identity(), integral = part * transition, term = transition;
  for (int k = 1; k <= 10; ++k) {
    term = term * a * part / k;
    transition += term;
    integral += term * part / (k + 1);
  }
  for (int k = 0; k < doublings; ++k) {
    integral = integral + transition * integral;
    transition = transition * transition;
  }
  return {transition, integral * b};
}

}  // namespace

double loop_radius(const Gains& gains, std::size_t i, const Twist& reference, double period, double delay) {
  const int whole = static_cast<int>(std::floor(delay / period));
  const double rest = delay - whole * period;  // so long does the command before still act
  const Step before = step(reference, rest), after = step(reference, period - rest);
  // u = K e, with the saturations' slopes at 0.
  Eigen::Matrix<double, 2, 3> feedback = Eigen::Matrix<double, 2, 3>::Zero();
  feedback(0, 0) = gains.k_x[i] * gains.c_x[i];
  feedback(1, 1) = gains.k_y * gains.k * reference.v;
  feedback(1, 2) = gains.k_theta[i] * gains.c_theta[i];

  // The state: e, and the commands u_{k-1}, u_{k-2}, ..., that have not acted yet.
  const int size = 3 + 2 * (whole + 1);
  Eigen::MatrixXd loop = Eigen::MatrixXd::Zero(size, size);
  loop.topLeftCorner<3, 3>() = after.transition * before.transition;
  const auto acts = [&](int age, const Eigen::Matrix<double, 3, 2>& input) {
    if (age == 0)
      loop.topLeftCorner<3, 3>() -= input * feedback;
    else
      loop.block<3, 2>(0, 3 + 2 * (age - 1)) -= input;
  };
  acts(whole, after.input);
  acts(whole + 1, after.transition * before.input);
  loop.block<2, 3>(3, 0) = feedback;
  for (int age = 1; age <= whole; ++age) loop.block<2, 2>(3 + 2 * age, 3 + 2 * (age - 1)).setIdentity();
  return loop.eigenvalues().cwiseAbs().maxCoeff();
}

DelayMargin delay_margin(const Gains& gains, std::size_t i, const Twist& reference, double period) {
  const auto stable = [&](double delay) {
    return loop_radius(gains, i, reference, period, delay) <= 1.0 + root_rounding;
  };
  if (!stable(0.0)) return {};
  int periods = 1;
  while (periods <= most_periods && stable(periods * period)) ++periods;
  if (periods > most_periods) return {most_periods * period, true};
  double low = (periods - 1) * period, high = periods * period;
  while (high - low > 1e-4 * period) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return {low, false};
}

double swing(const Gains& gains, std::size_t i, const Twist& reference, double period, double delay) {
  constexpr double beside = 0.01, turned = 0.1, lasts = 120.0;  // [m], [rad], [s]
  Gains own = paper_gains(1);
  own.saturation = gains.saturation;
  own.k_y = gains.k_y;
  own.k = gains.k;
  own.k_x = {gains.k_x[i]};
  own.c_x = {gains.c_x[i]};
  own.k_theta = {gains.k_theta[i]};
  own.c_theta = {gains.c_theta[i]};

  Pose robot{beside, 0.0, turned}, place{};
  const int whole = static_cast<int>(std::floor(delay / period));
  const double rest = delay - whole * period;  // so long does the command before still act
  std::deque<Twist> on_their_way(static_cast<std::size_t>(whole) + 1, reference);
  const int ticks = static_cast<int>(lasts / period);
  double largest = 0.0;
  for (int k = 0; k < ticks; ++k) {
    const TrackingError error = tracking_error(place, robot);
    Twist command;
    coordination_law(own, {&error, 1}, {&reference, 1}, {&command, 1});
    on_their_way.push_back(command);
    robot = advance(robot, on_their_way.front(), rest);
    on_their_way.pop_front();
    robot = advance(robot, on_their_way.front(), period - rest);
    place = advance(place, reference, period);
    if (k >= ticks - ticks / 4) largest = std::max(largest, distance(robot, place));
  }
  return largest;
}

}  // namespace skein::core
