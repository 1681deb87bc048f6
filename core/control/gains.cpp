#include "core/control/gains.h"

#include <cmath>

namespace skein::core {
namespace {

/// Over the partners of robot i: the smallest value, and the largest |t(i,j) - t(j,i)|.
struct Row {
  double smallest = 0.0;
  double asymmetry = 0.0;
};

Row row(const PairTable& table, std::size_t i) noexcept {
  Row result;
  if (table.uniform() && table.robots() > 1) {
    result.smallest = table(0, 1);
    return result;
  }
  bool first = true;
  for (std::size_t j = 0; j < table.robots(); ++j) {
    if (j == i) continue;
    result.smallest = first ? table(i, j) : std::min(result.smallest, table(i, j));
    result.asymmetry = std::max(result.asymmetry, std::abs(table(i, j) - table(j, i)));
    first = false;
  }
  return result;
}

}  // namespace

Gains paper_gains(std::size_t robots) {
  Gains gains;
  gains.v_max.assign(robots, 0.1);
  gains.omega_max.assign(robots, 1.7);
  gains.c_x.assign(robots, 20.0);
  gains.c_theta.assign(robots, 1.0);
  gains.k_x.assign(robots, 0.0);
  gains.k_theta.assign(robots, 0.0);
  gains.k_x_reserved.assign(robots, 0.0);
  gains.k_theta_reserved.assign(robots, 0.0);
  gains.k_xx = PairTable(robots, 0.008);
  gains.c_xx = PairTable(robots, 1.5);
  gains.l_xx = PairTable(robots, 100.0);
  gains.k_tt = PairTable(robots, 0.025);
  gains.c_tt = PairTable(robots, 0.04);
  gains.l_tt = PairTable(robots, 100.0);
  gains.k_yy = PairTable(robots, 0.08);
  gains.c_yy = PairTable(robots, 1.5);
  const std::vector<Twist> standstill(robots);
  use_all_authority(gains, standstill);
  return gains;
}

void use_all_authority(Gains& gains, std::span<const Twist> reference) noexcept {
  for (std::size_t i = 0; i < gains.robots(); ++i) {
    const double v_ref = std::abs(reference[i].v);
    const double omega_ref = std::abs(reference[i].omega);
    gains.k_x[i] = gains.v_max[i] - v_ref - gains.k_xx.row_sum(i);
    gains.k_theta[i] =
        gains.omega_max[i] - omega_ref - gains.k_y * v_ref - (gains.k_tt.row_sum(i) + gains.k_yy.row_sum(i));
  }
}

void use_policy(Gains& gains, std::span<const Twist> reference) noexcept {
  switch (gains.policy) {
    case GainPolicy::authority:
      return use_all_authority(gains, reference);
    case GainPolicy::fixed:
      return;
  }
}

double free_v(const Gains& gains, std::size_t i) noexcept {
  switch (gains.policy) {
    case GainPolicy::fixed:
      return gains.v_max[i] - gains.k_x_reserved[i];
    case GainPolicy::authority:
      break;
  }
  return (1.0 - tracking_share) * gains.v_max[i];
}

double free_omega(const Gains& gains, std::size_t i) noexcept {
  switch (gains.policy) {
    case GainPolicy::fixed:
      return gains.omega_max[i] - gains.k_theta_reserved[i];
    case GainPolicy::authority:
      break;
  }
  return (1.0 - tracking_share) * gains.omega_max[i];
}

Margins margins(const Gains& gains, std::size_t i, const Twist& reference) noexcept {
  const Row k_xx = row(gains.k_xx, i), k_tt = row(gains.k_tt, i), k_yy = row(gains.k_yy, i);
  const Row c_xx = row(gains.c_xx, i), c_tt = row(gains.c_tt, i), c_yy = row(gains.c_yy, i);
  const Row l_xx = row(gains.l_xx, i), l_tt = row(gains.l_tt, i);
  const double v_ref = std::abs(reference.v);
  Margins m{};
  m.a = std::min({gains.k_x[i], gains.k_theta[i], gains.c_x[i], gains.c_theta[i], gains.k_y, gains.k});
  m.b = std::min({k_xx.smallest, k_tt.smallest, k_yy.smallest, c_xx.smallest, c_tt.smallest, c_yy.smallest,
                  l_xx.smallest, l_tt.smallest});
  m.c = -std::max({k_xx.asymmetry, k_tt.asymmetry, k_yy.asymmetry});
  m.d = -std::max({c_xx.asymmetry, c_tt.asymmetry, c_yy.asymmetry});
  m.e = -std::max(l_xx.asymmetry, l_tt.asymmetry);
  m.f = gains.v_max[i] - v_ref - gains.k_x[i] - gains.k_xx.row_sum(i);
  m.g = gains.omega_max[i] - std::abs(reference.omega) - gains.k_theta[i] - gains.k_y * v_ref -
        (gains.k_tt.row_sum(i) + gains.k_yy.row_sum(i));
  return m;
}

}  // namespace skein::core
