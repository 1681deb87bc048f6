// (16, 17): the law has no seam where theta_e passes zero, and none where sinc changes from its series to the quotient.
#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Twist;

/// sin(a)/a with digits to spare: the quotient is exact to the last bit of long double for every a != 0.
double exact_sinc(double a) {
  const long double big = a;
  return a == 0.0 ? 1.0 : static_cast<double>(std::sin(big) / big);
}

TEST(Sinc, IsExactAtEverySize) {
  holds("sinc is sin(a)/a to two units in the last place", [] {
    Draw draw(any_seed());
    const double a = draw.sign() * draw.decades(-12.0, 1.5);
    RC_ASSERT(std::abs(core::sinc(a) - exact_sinc(a)) <= 5e-16);
    RC_ASSERT(core::sinc(-a) == core::sinc(a));
  });
  EXPECT_EQ(core::sinc(0.0), 1.0);
  EXPECT_EQ(core::sinc(-0.0), 1.0);
}

TEST(Sinc, HasNoSeamAtTheSeriesSwitch) {
  // Up and down through the switch (1e-3) in steps small enough to land on both of its sides.
  for (double a = 0.9e-3; a < 1.1e-3; a += 1e-8) ASSERT_NEAR(core::sinc(a), exact_sinc(a), 3e-16) << a;
}

TEST(Sinc, HasTheRightSlopeOnBothSidesOfTheSwitch) {
  // The quotient of differences over 2h carries a rounding of about 2e-16 / h and a truncation of about h^2 |a| / 30.
  for (double a : {-0.5, -2e-3, -1.0e-3, -0.5e-3, 0.0, 1e-5, 0.5e-3, 0.9999e-3, 1.0e-3, 1.0001e-3, 2e-3, 0.1, 1.0}) {
    const double h = 1e-4;
    const double slope = (core::sinc(a + h) - core::sinc(a - h)) / (2.0 * h);
    const double exact = a == 0.0             ? 0.0
                         : std::abs(a) < 0.01 ? -a / 3.0 + a * a * a / 30.0
                                              : (std::cos(a) - exact_sinc(a)) / a;
    EXPECT_NEAR(slope, exact, 2e-11 + h * h) << a;
  }
}

/// A bound on |d command / d theta_e,i|: the sum of every term's largest slope.
double steepest(const Group& group, std::size_t i) {
  const auto& g = group.gains;
  double slope = std::abs(group.reference[i].v) + g.k_theta[i] * g.c_theta[i] + g.k_y * std::abs(group.reference[i].v);
  for (std::size_t j = 0; j < group.robots(); ++j) {
    if (j == i) continue;
    const double theta_j = std::abs(group.errors[j].theta);
    const double l = g.l_tt(i, j), k = g.k_tt(i, j), c = g.c_tt(i, j);
    // The paper's weight l b_j / sqrt(1 + (l b_i b_j)^2) has at most the slope l |b_j| * l |b_j|; times phi <= k.
    slope += l * theta_j * k * c + l * theta_j * l * theta_j * k + (std::sqrt(l) * c + l) * k + g.k_yy(i, j);
    slope += l * k + l * (theta_j + 1.0) * k * c + std::sqrt(l) * k * (c + 1.0);  // what i does to j
  }
  return slope;
}

TEST(Law, HasNoJumpWhereThetaPassesZero) {
  holds("commands at theta_e = -eps, 0 and +eps differ by no more than slope times eps", [] {
    const int n = any_of(1, 8);
    Draw draw(any_seed());
    Group group = random_group(draw, static_cast<std::size_t>(n));
    const std::size_t i = static_cast<std::size_t>(draw.whole(0, n - 1));
    const double eps = draw.decades(-300.0, -6.0);  // down to where a careless sin(a)/a meets denormal numbers
    std::vector<Twist> at[3];
    for (int side = -1; side <= 1; ++side) {
      group.errors[i].theta = side * eps;
      auto& command = at[side + 1];
      command.resize(group.robots());
      core::coordination_law(group.gains, group.errors, group.reference, command);
    }
    const double slope = steepest(group, i);
    for (std::size_t j = 0; j < group.robots(); ++j)
      for (int side : {0, 2}) {
        const double size = 1.0 + std::abs(at[1][j].v) + std::abs(at[1][j].omega);
        RC_ASSERT(std::isfinite(at[side][j].omega) && std::isfinite(at[side][j].v));
        RC_ASSERT(std::abs(at[side][j].v - at[1][j].v) <= slope * eps + 1e-14 * size);
        RC_ASSERT(std::abs(at[side][j].omega - at[1][j].omega) <= slope * eps + 1e-13 * size);
      }
  });
}

TEST(Law, IsSmoothAcrossTheSeriesSwitch) {
  // One robot with a big y error, so that the sinc term dominates; theta_e through 1e-3.
  core::Gains gains = core::paper_gains(1);
  const std::vector<Twist> reference{{0.05, 0.0}};
  std::vector<Twist> command(1);
  const auto omega = [&](double theta) {
    const std::vector<core::TrackingError> errors{{0.0, 0.5, theta}};
    core::coordination_law(gains, errors, reference, command);
    return command[0].omega - 1.7 * std::tanh(theta);  // k_theta at standstill: 1.7
  };
  const double factor = 11.0 * 0.05 * 200.0 * 0.5 / std::sqrt(1.0 + 200.0 * 200.0 * 0.25);
  for (double theta = 0.9e-3; theta < 1.1e-3; theta += 1e-7)
    ASSERT_NEAR(omega(theta), factor * exact_sinc(theta), 5e-16);
}

TEST(Law, IgnoresARobotWhoseErrorIsZero) {
  holds("commands of the others are those of the group without it", [] {
    const int n = any_of(2, 8);
    Draw draw(any_seed());
    Group group = random_group(draw, static_cast<std::size_t>(n));
    const std::size_t last = group.robots() - 1;
    group.errors[last] = {};
    std::vector<Twist> with(group.robots());
    core::coordination_law(group.gains, group.errors, group.reference, with);
    // The bounded and the paper's coupling weigh with b_j = 0; the y coupling with sin(theta_j) = 0.
    Group without = group;
    for (std::size_t i = 0; i < last; ++i) {
      without.gains.k_xx.set(i, last, 0.0);
      without.gains.k_tt.set(i, last, 0.0);
      without.gains.k_yy.set(i, last, 0.0);
    }
    std::vector<Twist> alone(group.robots());
    core::coordination_law(without.gains, without.errors, without.reference, alone);
    for (std::size_t i = 0; i < last; ++i) RC_ASSERT(with[i] == alone[i]);
  });
}

}  // namespace
}  // namespace skein::test
