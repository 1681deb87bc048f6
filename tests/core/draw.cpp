#include "draw.h"

#include <algorithm>

namespace skein::test {

using core::Coupling;
using core::PairTable;
using core::Saturation;

namespace {

/// One value a pair, drawn from `value()`; one pair of five is uncoupled where `can_be_zero`.
template <typename Value>
PairTable random_table(Draw& draw, std::size_t robots, bool can_be_zero, Value&& value) {
  PairTable table(robots);
  for (std::size_t i = 0; i < robots; ++i)
    for (std::size_t j = i + 1; j < robots; ++j) table.set(i, j, can_be_zero && draw.chance(0.2) ? 0.0 : value());
  return table;
}

}  // namespace

core::TrackingError random_error(Draw& draw, double largest) {
  const auto length = [&] { return draw.chance(0.05) ? 0.0 : draw.sign() * draw.decades(-6.0, std::log10(largest)); };
  const double theta = draw.chance(0.05)  ? 0.0
                       : draw.chance(0.3) ? draw.sign() * draw.decades(-9.0, -1.0)
                                          : draw.angle();
  return {length(), length(), theta};
}

Group random_group(Draw& draw, std::size_t robots, Coupling coupling) {
  Group group;
  auto& g = group.gains;
  g.coupling = coupling;
  g.saturation = draw.chance(0.5) ? Saturation::tanh : Saturation::algebraic;
  g.k_y = draw.decades(-1.0, 1.5);
  g.k = draw.decades(-1.0, 3.0);
  const double n = static_cast<double>(robots);

  // The references first, inside the limits; then the couplings out of the least that any robot has left; then k_x and
  // k_theta out of what is left to each.
  double left_v = 1e9, left_omega = 1e9;
  for (std::size_t i = 0; i < robots; ++i) {
    group.errors.push_back(random_error(draw));
    const double v_max = draw.decades(-1.5, 0.5);
    const double v_ref = draw.between(-0.9, 0.9) * v_max;
    const double omega_ref = draw.between(-2.0, 2.0);
    const double omega_left = draw.decades(-1.0, 1.0);  // beside the reference and k_y |v_ref|
    g.v_max.push_back(v_max);
    g.omega_max.push_back(std::abs(omega_ref) + g.k_y * std::abs(v_ref) + omega_left);
    group.reference.push_back({v_ref, omega_ref});
    left_v = std::min(left_v, v_max - std::abs(v_ref));
    left_omega = std::min(left_omega, omega_left);
    g.c_x.push_back(draw.decades(-1.0, 2.0));
    g.c_theta.push_back(draw.decades(-1.0, 2.0));
  }
  g.k_xx = random_table(draw, robots, true, [&] { return draw.between(0.0, 0.9) * left_v / n; });
  g.k_tt = random_table(draw, robots, true, [&] { return draw.between(0.0, 0.45) * left_omega / n; });
  g.k_yy = random_table(draw, robots, true, [&] { return draw.between(0.0, 0.45) * left_omega / n; });
  for (PairTable* c : {&g.c_xx, &g.c_tt, &g.c_yy})
    *c = random_table(draw, robots, true, [&] { return draw.decades(-2.0, 2.0); });
  for (PairTable* l : {&g.l_xx, &g.l_tt})
    *l = random_table(draw, robots, true, [&] { return draw.decades(-1.0, 3.0); });

  g.k_x.resize(robots);
  g.k_theta.resize(robots);
  const bool all_authority = draw.chance(0.25);
  for (std::size_t i = 0; i < robots; ++i) {
    double xx = 0.0, tt_yy = 0.0;
    for (std::size_t j = 0; j < robots; ++j)
      if (j != i) xx += g.k_xx(i, j), tt_yy += g.k_tt(i, j) + g.k_yy(i, j);
    const double share = all_authority ? 1.0 : draw.between(0.01, 0.99);
    const auto& reference = group.reference[i];
    g.k_x[i] = share * (g.v_max[i] - std::abs(reference.v) - xx);
    g.k_theta[i] = share * (g.omega_max[i] - std::abs(reference.omega) - g.k_y * std::abs(reference.v) - tt_yy);
  }
  return group;
}

Group random_group(Draw& draw, std::size_t robots) {
  return random_group(draw, robots, draw.chance(0.5) ? Coupling::paper : Coupling::bounded);
}

}  // namespace skein::test
