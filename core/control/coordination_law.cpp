#include "core/control/coordination_law.h"

#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

/// The symmetric factor of the coupling of b_i and b_j (b is x or theta): robot i gets b_j times it, robot j gets -b_i
/// times it, because phi is odd. That sign is what makes the sums (21) vanish.
double coupling_factor(const Gains& gains, double k, double c, double l, double b_i, double b_j) noexcept {
  const double phi = saturate(gains.saturation, k, c * (b_i - b_j));
  switch (gains.coupling) {
    case Coupling::paper: {
      const double product = l * b_i * b_j;
      return l * phi / std::sqrt(1.0 + product * product);
    }
    case Coupling::bounded:
      break;
  }
  return std::sqrt(l) * phi / std::sqrt((1.0 + l * b_i * b_i) * (1.0 + l * b_j * b_j));
}

/// The first two terms of (15a), the first three of (15b).
void track(const Gains& gains, std::span<const TrackingError> errors, std::span<const Twist> reference,
           std::span<Twist> command) noexcept {
  const double normaliser = group_normaliser(gains.k, errors);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TrackingError& e = errors[i];
    const double v_ref = reference[i].v;
    command[i].v = v_ref * math::cos(e.theta) + saturate(gains.saturation, gains.k_x[i], gains.c_x[i] * e.x);
    command[i].omega = reference[i].omega + saturate(gains.saturation, gains.k_theta[i], gains.c_theta[i] * e.theta) +
                       gains.k_y * v_ref * gains.k * e.y / normaliser * sinc(e.theta);
  }
}

/// The sums of (15a) and (15b), each pair once.
void coordinate(const Gains& gains, std::span<const TrackingError> errors, std::span<Twist> command) noexcept {
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TrackingError& e_i = errors[i];
    for (std::size_t j = i + 1; j < errors.size(); ++j) {
      const TrackingError& e_j = errors[j];
      const double xx = coupling_factor(gains, gains.k_xx(i, j), gains.c_xx(i, j), gains.l_xx(i, j), e_i.x, e_j.x);
      command[i].v += e_j.x * xx;
      command[j].v -= e_i.x * xx;

      const double tt =
          coupling_factor(gains, gains.k_tt(i, j), gains.c_tt(i, j), gains.l_tt(i, j), e_i.theta, e_j.theta);
      const double yy = saturate(gains.saturation, gains.k_yy(i, j), gains.c_yy(i, j) * (e_i.y - e_j.y));
      command[i].omega += e_j.theta * tt + yy * sinc(e_i.theta) * math::sin(e_j.theta);
      command[j].omega -= e_i.theta * tt + yy * sinc(e_j.theta) * math::sin(e_i.theta);
    }
  }
}

}  // namespace

double group_normaliser(double k, std::span<const TrackingError> errors) noexcept {
  double squares = 0.0;
  for (const TrackingError& e : errors) squares += e.x * e.x + e.y * e.y;
  return std::sqrt(1.0 + k * k * squares);
}

void coordination_law(const Gains& gains, std::span<const TrackingError> errors, std::span<const Twist> reference,
                      std::span<Twist> command) noexcept {
  track(gains, errors, reference, command);
  coordinate(gains, errors, command);
}

void coordination_law(const Gains& gains, std::span<const TrackingError> errors, std::span<const Twist> reference,
                      std::span<Twist> command, LawPairs& pairs) noexcept {
  constexpr std::size_t small = 16;  // where an exponential a robot costs more than a tanh a pair
  track(gains, errors, reference, command);
  if (errors.size() >= small && pairs.suit(gains, errors))
    pairs.add(gains, errors, command);
  else
    coordinate(gains, errors, command);
}

CouplingSums coupling_sums(const Gains& gains, std::span<const TrackingError> errors) noexcept {
  CouplingSums sums{};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TrackingError& e_i = errors[i];
    for (std::size_t j = 0; j < errors.size(); ++j) {
      if (j == i) continue;
      const TrackingError& e_j = errors[j];
      sums.x +=
          e_i.x * e_j.x * coupling_factor(gains, gains.k_xx(i, j), gains.c_xx(i, j), gains.l_xx(i, j), e_i.x, e_j.x);
      sums.theta += e_i.theta * e_j.theta *
                    coupling_factor(gains, gains.k_tt(i, j), gains.c_tt(i, j), gains.l_tt(i, j), e_i.theta, e_j.theta);
      sums.y += saturate(gains.saturation, gains.k_yy(i, j), gains.c_yy(i, j) * (e_i.y - e_j.y)) * e_i.theta *
                sinc(e_i.theta) * math::sin(e_j.theta);
    }
  }
  return sums;
}

}  // namespace skein::core
