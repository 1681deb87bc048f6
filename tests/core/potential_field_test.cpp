// The artificial potential field (29, 30) and its descent (31).
#include "core/avoidance/potential_field.h"

#include <algorithm>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::AvoidanceParameters;
using core::Velocity;

AvoidanceParameters random_field(Draw& draw) {
  AvoidanceParameters a;
  a.alpha = draw.between(0.03, 0.3);
  a.beta = draw.between(0.03, 0.3);
  constexpr int shapes[] = {2, 3, 4, 8};
  a.p = shapes[draw.whole(0, 3)];
  a.K_a = draw.between(0.0, 1.0);
  a.K_o = draw.decades(-3.0, 0.0);
  return a;
}

TEST(PotentialField, DescendsAlongMinusTheGradient) {
  holds("descent against finite differences of the potential", [] {
    Draw draw(any_seed());
    const AvoidanceParameters a = random_field(draw);
    const double x_j = draw.between(-1.0, 1.0), y_j = draw.between(-1.0, 1.0);
    const double x_ref = draw.between(-1.0, 1.0), y_ref = draw.between(-1.0, 1.0);
    // Inside the region, off its edge by more than the step; in one case of five on an axis, where |d| has its kink.
    const double h = 1e-6;
    double dx = draw.between(-1.0, 1.0) * a.alpha, dy = draw.between(-1.0, 1.0) * a.beta;
    if (draw.chance(0.2)) (draw.chance(0.5) ? dx : dy) = 0.0;
    RC_PRE(core::region_level(a, dx, dy) < 0.999);
    const double x = x_j + dx, y = y_j + dy;
    const auto at = [&](double px, double py) { return core::potential(a, px, py, x_ref, y_ref, x_j, y_j); };
    const Velocity down = core::descent(a, x, y, x_ref, y_ref, x_j, y_j);
    // Truncation h^2/6 of the third derivative, K_o (p/alpha)^3 at most; rounding 4e-16 of the potential over h.
    const double bend = a.K_o * std::pow(a.p / std::min(a.alpha, a.beta), 3) + 1.0;
    const double tolerance = h * h * bend + 1e-15 * (4.0 * a.K_a + a.K_o) / h + (a.p == 3 ? h * bend * 0.01 : 0.0);
    RC_ASSERT(std::abs(-(at(x + h, y) - at(x - h, y)) / (2.0 * h) - down.x) <= tolerance);
    RC_ASSERT(std::abs(-(at(x, y + h) - at(x, y - h)) / (2.0 * h) - down.y) <= tolerance);
  });
}

TEST(PotentialField, IsThatOf30) {
  holds("K_a |p - p_ref|^2 + K_o exp(-level / p)", [] {
    Draw draw(any_seed());
    const AvoidanceParameters a = random_field(draw);
    const double dx = draw.between(-1.0, 1.0) * a.alpha, dy = draw.between(-1.0, 1.0) * a.beta;
    double level = 0.0;  // whole powers by multiplication
    for (const double d : {std::abs(dx / a.alpha), std::abs(dy / a.beta)}) {
      double power = 1.0;
      for (int k = 0; k < a.p; ++k) power *= d;
      level += power;
    }
    RC_ASSERT(std::abs(core::region_level(a, dx, dy) - level) <= 1e-14);
    RC_PRE(std::abs(level - 1.0) > 1e-9);
    const double expected = level > 1.0 ? 0.0 : a.K_a * (0.3 * 0.3 + 0.4 * 0.4) + a.K_o * std::exp(-level / a.p);
    RC_ASSERT(std::abs(core::potential(a, dx, dy, dx - 0.3, dy + 0.4, 0.0, 0.0) - expected) <= 1e-14);
  });
}

TEST(PotentialField, IsNothingOutsideTheRegion) {
  holds("zero potential, zero descent", [] {
    Draw draw(any_seed());
    const AvoidanceParameters a = random_field(draw);
    const double dx = draw.between(-3.0, 3.0) * a.alpha, dy = draw.between(-3.0, 3.0) * a.beta;
    RC_PRE(core::region_level(a, dx, dy) > 1.0);
    RC_ASSERT(core::potential(a, dx, dy, 1.0, 1.0, 0.0, 0.0) == 0.0);
    const Velocity down = core::descent(a, dx, dy, 1.0, 1.0, 0.0, 0.0);
    RC_ASSERT(down.x == 0.0 && down.y == 0.0);
  });
}

TEST(PotentialField, PushesAway) {
  holds("the repulsive part never points at the other robot, on either side of it, odd p too", [] {
    Draw draw(any_seed());
    AvoidanceParameters a = random_field(draw);
    a.K_a = 0.0;
    const double dx = draw.between(-1.0, 1.0) * a.alpha, dy = draw.between(-1.0, 1.0) * a.beta;
    RC_PRE(core::region_level(a, dx, dy) < 1.0);
    const Velocity away = core::descent(a, dx, dy, 0.0, 0.0, 0.0, 0.0);
    RC_ASSERT(away.x * dx >= 0.0 && away.y * dy >= 0.0);
    const Velocity mirrored = core::descent(a, -dx, -dy, 0.0, 0.0, 0.0, 0.0);
    RC_ASSERT(mirrored.x == -away.x && mirrored.y == -away.y);
  });
}

TEST(PotentialField, FadesAsCentresMeet) {
  // Note 4 on the paper: the repulsion is weakest where it matters most. Known, and why there is a shield.
  const AvoidanceParameters a;
  const auto push = [&](double d) { return core::descent(a, d, 0.0, d, 0.0, 0.0, 0.0).x; };
  EXPECT_GT(push(0.09), push(0.05));
  EXPECT_GT(push(0.05), push(0.01));
  EXPECT_LT(push(1e-6), 1e-5);
}

TEST(PotentialField, LeavesTheSameGapToAnObstacleAsToARobot) {
  const AvoidanceParameters a;
  for (const double radius : {0.01, core::standard_radius, 0.1, 0.5}) {
    const AvoidanceParameters wider = core::around(a, {0.0, 0.0, radius});
    EXPECT_NEAR(wider.alpha - radius, a.alpha - core::standard_radius, 1e-15);
    EXPECT_NEAR(wider.beta - radius, a.beta - core::standard_radius, 1e-15);
  }
}

}  // namespace
}  // namespace skein::test
