#pragma once

#include <cmath>

#include "draw.h"

namespace skein::test {

/// (15) written down a second time, term by term and robot by robot with every j != i, so that core's rearrangement
/// (each pair once, common factors) has something to be compared with. `size` is the sum of the absolute terms: what
/// rounding errors are relative to.
struct Literal {
  double value = 0.0;
  double size = 0.0;
  void add(double term) { value += term, size += std::abs(term); }
};

inline double literal_phi(core::Saturation kind, double r, double kx) {
  return kind == core::Saturation::tanh ? r * std::tanh(kx) : r * (kx / std::sqrt(1.0 + kx * kx));  // (11)
}

inline double literal_sinc(double a) {
  return a == 0.0 ? 1.0 : std::sin(a) / a;  // (16, 17)
}

inline double literal_normaliser(const Group& group) {
  double e_e = 0.0;
  for (const auto& e : group.errors) e_e += e.x * e.x + e.y * e.y;
  return std::sqrt(1.0 + group.gains.k * group.gains.k * e_e);
}

/// The weight with which b_e,j enters the coupling of b_e,i: (15) as printed, or the bounded drop-in of the notes.
inline double literal_weight(core::Coupling coupling, double l, double b_i, double b_j) {
  if (coupling == core::Coupling::paper) return l * b_j / std::sqrt(1.0 + (l * b_i * b_j) * (l * b_i * b_j));
  return std::sqrt(l) * b_j / std::sqrt((1.0 + l * b_i * b_i) * (1.0 + l * b_j * b_j));
}

/// (15a)
inline Literal literal_v(const Group& group, std::size_t i) {
  const auto& g = group.gains;
  const auto& e = group.errors;
  Literal v;
  v.add(group.reference[i].v * std::cos(e[i].theta));
  v.add(literal_phi(g.saturation, g.k_x[i], g.c_x[i] * e[i].x));
  for (std::size_t j = 0; j < group.robots(); ++j) {
    if (j == i) continue;
    v.add(literal_weight(g.coupling, g.l_xx(i, j), e[i].x, e[j].x) *
          literal_phi(g.saturation, g.k_xx(i, j), g.c_xx(i, j) * (e[i].x - e[j].x)));
  }
  return v;
}

/// (15b)
inline Literal literal_omega(const Group& group, std::size_t i) {
  const auto& g = group.gains;
  const auto& e = group.errors;
  Literal omega;
  omega.add(group.reference[i].omega);
  omega.add(literal_phi(g.saturation, g.k_theta[i], g.c_theta[i] * e[i].theta));
  omega.add(g.k_y * group.reference[i].v * g.k * e[i].y / literal_normaliser(group) * literal_sinc(e[i].theta));
  for (std::size_t j = 0; j < group.robots(); ++j) {
    if (j == i) continue;
    omega.add(literal_weight(g.coupling, g.l_tt(i, j), e[i].theta, e[j].theta) *
              literal_phi(g.saturation, g.k_tt(i, j), g.c_tt(i, j) * (e[i].theta - e[j].theta)));
    omega.add(literal_phi(g.saturation, g.k_yy(i, j), g.c_yy(i, j) * (e[i].y - e[j].y)) * literal_sinc(e[i].theta) *
              std::sin(e[j].theta));
  }
  return omega;
}

}  // namespace skein::test
