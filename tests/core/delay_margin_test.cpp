// The delay that the law bears: the linearisation's answer against robots that are driven with it.
#include "core/control/delay_margin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "core/control/coordination_law.h"
#include "core/control/tracking_error.h"
#include "core/kinematics/unicycle.h"

namespace skein::test {
namespace {

using core::Gains;
using core::Pose;
using core::Twist;

/// One robot beside a reference of constant velocities, its commands held and late. The largest error of the last tenth
/// of the run, as a multiple of the first.
double growth(const Gains& gains, const Twist& reference, double period, double delay, double seconds) {
  constexpr double start = 1e-6;  // far inside where everything is linear
  Pose robot{0.0, start, 0.0}, ideal{0.0, 0.0, 0.0};
  const int whole = static_cast<int>(std::floor(delay / period));
  const double rest = delay - whole * period;
  std::deque<Twist> waiting(static_cast<std::size_t>(whole) + 1, reference);
  double last = 0.0;
  const int ticks = static_cast<int>(seconds / period);
  for (int k = 0; k < ticks; ++k) {
    const core::TrackingError e[] = {core::tracking_error(ideal, robot)};
    Twist command[1];
    core::coordination_law(gains, e, {&reference, 1}, command);
    waiting.push_back(command[0]);  // behind those that are still on their way
    robot = core::advance(robot, waiting.front(), rest);
    waiting.pop_front();
    robot = core::advance(robot, waiting.front(), period - rest);
    ideal = core::advance(ideal, reference, period);
    if (k > ticks - ticks / 10) last = std::max(last, std::hypot(e[0].x, e[0].y) + 0.1 * std::abs(e[0].theta));
  }
  return last / start;
}

Gains one_robot(const Twist& reference) {
  Gains gains = core::paper_gains(1);
  gains.k_xx = core::PairTable(1);
  core::use_all_authority(gains, {&reference, 1});
  return gains;
}

TEST(DelayMargin, IsWhereDrivenRobotsBeginToSwing) {
  for (const Twist& reference : {Twist{0.05, 0.0}, Twist{0.05, 0.05 / 0.119}, Twist{0.02, -0.3}, Twist{0.06, 0.1}})
    for (const double period : {0.02, 0.04}) {
      const Gains gains = one_robot(reference);
      const core::DelayMargin margin = core::delay_margin(gains, 0, reference, period);
      ASSERT_FALSE(margin.unbounded);
      ASSERT_GT(margin.delay, 0.5 * period);
      EXPECT_LT(growth(gains, reference, period, 0.93 * margin.delay, 300.0), 0.1) << reference.v << " " << period;
      EXPECT_GT(growth(gains, reference, period, 1.07 * margin.delay, 150.0), 10.0) << reference.v << " " << period;
    }
}

TEST(DelayMargin, BeyondItRobotsSwingButNotWithoutBound) {
  const Twist reference{0.05, 0.05 / 0.119};
  constexpr double period = 0.04;
  const Gains gains = one_robot(reference);
  const double margin = core::delay_margin(gains, 0, reference, period).delay;
  EXPECT_LT(core::swing(gains, 0, reference, period, 0.7 * margin), 1e-4) << "it still settles";
  double before = 5e-4;
  for (const double times : {1.1, 2.0, 4.0}) {
    const double swing = core::swing(gains, 0, reference, period, times * margin);
    EXPECT_GT(swing, before) << times;
    EXPECT_LT(swing, 0.1 * times * margin) << "v_max for as long as the delay";
    before = swing;
  }
}

TEST(DelayMargin, OfAStraightIsThatOfItsTwoChains) {
  // x alone: a gain K = k_x c_x and a sampled integrator. In continuous time the margin is pi / (2 K); sampling takes
  // half a period of it.
  Twist rest{};
  Gains gains = one_robot(rest);
  gains.c_theta[0] = 1e-3;  // the heading's loop is far slower
  const double K = gains.k_x[0] * gains.c_x[0];
  EXPECT_NEAR(core::delay_margin(gains, 0, rest, 0.001).delay, 0.064, 1e-9) << "64 periods are tried";
  EXPECT_TRUE(core::delay_margin(gains, 0, rest, 0.001).unbounded);
  EXPECT_NEAR(core::delay_margin(gains, 0, rest, 0.02).delay, 1.5707963 / K - 0.01, 2e-4);
}

TEST(DelayMargin, IsNoneWhereTheLoopSwingsByItself) {
  Gains gains = one_robot({0.05, 0.0});
  gains.c_theta[0] = 1e4;
  EXPECT_EQ(core::delay_margin(gains, 0, {0.05, 0.0}, 0.04).delay, 0.0);
  EXPECT_GT(core::loop_radius(gains, 0, {0.05, 0.0}, 0.04, 0.0), 1.0);
}

TEST(DelayMargin, ShrinksWithTheGains) {
  const Twist straight{0.05, 0.0};
  Gains gains = one_robot(straight);
  double before = core::delay_margin(gains, 0, straight, 0.04).delay;
  for (int k = 0; k < 4; ++k) {
    gains.k_y *= 1.5;
    const double now = core::delay_margin(gains, 0, straight, 0.04).delay;
    EXPECT_LT(now, before);
    before = now;
  }
}

}  // namespace
}  // namespace skein::test
