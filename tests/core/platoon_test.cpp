// The references of section V, (2, 3), the errors (4, 5) and the formation error (35, 37).
#include "core/reference/platoon.h"

#include <algorithm>
#include <cmath>

#include "core/control/formation.h"
#include "core/control/tracking_error.h"
#include "core/kinematics/unicycle.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Platoon;
using core::Pose;
using core::ReferencePoint;
using core::TrackingError;
using core::Twist;
using core::wrap_angle;

constexpr double lap = 83.92;  // [s]

Platoon case_study() {
  return {std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119), 4, 0.12, 0.05, 1.6};
}

TEST(Platoon, KeepsTwelveCentimetresOnStraightsAndElevenAndAHalfInCorners) {
  const Platoon platoon = case_study();
  double least = 1.0, most = 0.0;
  for (double t = 0.0; t < lap; t += 0.005)
    for (std::size_t i = 0; i + 1 < platoon.robots(); ++i) {
      const ReferencePoint ahead = platoon.at(i, t), behind = platoon.at(i + 1, t);
      const double d = core::distance(ahead.pose, behind.pose);
      least = std::min(least, d), most = std::max(most, d);
      const bool on_one_straight = ahead.pose.theta == behind.pose.theta;
      if (on_one_straight) {
        ASSERT_NEAR(d, 0.12, 1e-14) << t;
      }
    }
  EXPECT_NEAR(most, 0.12, 1e-12);
  EXPECT_NEAR(least, 0.115, 5e-5);
  EXPECT_NEAR(least, 2.0 * 0.119 * std::sin(0.06 / 0.119), 1e-6);  // the chord of 0.12 m of arc
}

TEST(Platoon, FollowsItsLeaderOnOnePath) {
  holds("robot i is where robot 1 was i spacings ago", [] {
    Draw draw(any_seed());
    const Platoon platoon = case_study();
    const double t = draw.between(0.0, 1000.0);
    const auto i = static_cast<std::size_t>(draw.whole(0, 3));
    const ReferencePoint here = platoon.at(i, t);
    const ReferencePoint leader = platoon.at(0, t - static_cast<double>(i) * 0.12 / 0.05);
    RC_ASSERT(core::distance(here.pose, leader.pose) <= 1e-13);
    RC_ASSERT(here.twist.v == 0.05);
    std::vector<ReferencePoint> all(4);
    platoon.at(t, all);
    RC_ASSERT(all[i] == here);
  });
}

TEST(Platoon, HasTheVelocitiesOf3) {
  // (3) by central differences: v_ref = |p'|, omega_ref = (x' y'' - x'' y') / v_ref^2. With h = 1 ms the second
  // difference carries a rounding of 4e-16 / h^2 = 4e-10 m/s^2, so 1e-8 rad/s after the division by v_ref, and the
  // truncation h^2 |p''''| / 12.
  const Platoon platoon = case_study();
  const double h = 1e-3;
  int bends = 0, straights = 0;
  for (double t = 0.0; t < lap; t += 0.0137) {
    const ReferencePoint a = platoon.at(1, t - h), b = platoon.at(1, t), c = platoon.at(1, t + h);
    if (a.twist.omega != b.twist.omega || c.twist.omega != b.twist.omega) continue;  // a joint: omega_ref jumps
    const double dx = (c.pose.x - a.pose.x) / (2.0 * h), dy = (c.pose.y - a.pose.y) / (2.0 * h);
    const double ddx = (c.pose.x - 2.0 * b.pose.x + a.pose.x) / (h * h);
    const double ddy = (c.pose.y - 2.0 * b.pose.y + a.pose.y) / (h * h);
    const double v = std::hypot(dx, dy);
    ASSERT_NEAR(b.twist.v, v, 3e-9);  // h^2 v omega^2 / 6
    ASSERT_NEAR(b.twist.omega, (dx * ddy - ddx * dy) / (v * v), 1e-7);
    ASSERT_NEAR(wrap_angle(b.pose.theta - std::atan2(dy, dx)), 0.0, 1e-8);
    (b.twist.omega == 0.0 ? straights : bends) += 1;
  }
  EXPECT_GT(bends, 500);
  EXPECT_GT(straights, 500);
}

TEST(Platoon, PutsThePapersPerturbationsWhereThePaperSays) {
  // Robot 2 at 18 s and robot 1 at 65 s on a horizontal straight, robot 3 at 46 s on a vertical one.
  const Platoon platoon = case_study();
  const auto horizontal = [](double theta) { return std::abs(std::sin(theta)) < 1e-12; };
  const auto vertical = [](double theta) { return std::abs(std::cos(theta)) < 1e-12; };
  EXPECT_TRUE(horizontal(platoon.at(1, 18.0).pose.theta));
  EXPECT_TRUE(vertical(platoon.at(2, 46.0).pose.theta));
  EXPECT_TRUE(horizontal(platoon.at(0, 65.0).pose.theta));
}

TEST(Platoon, KeepsHeadingAndTurnThroughAStop) {
  const Platoon still(std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119), 2, 0.12, 0.0, 1.1);
  const ReferencePoint point = still.at(0, 12.3);
  EXPECT_EQ(point.twist, (Twist{0.0, 0.0}));
  EXPECT_TRUE(std::isfinite(point.pose.theta));
  EXPECT_EQ(point.pose, still.at(0, 0.0).pose);
}

TEST(TrackingError, IsTheReferenceSeenFromTheRobot) {
  // The robot looks up; the reference is 1 m to its right on the map, that is to the robot's right hand: y_e < 0.
  const TrackingError e = core::tracking_error({1.0, 0.0, 0.0}, {0.0, 0.0, 0.5 * core::pi});
  EXPECT_NEAR(e.x, 0.0, 1e-15);
  EXPECT_NEAR(e.y, -1.0, 1e-15);
  EXPECT_NEAR(e.theta, -0.5 * core::pi, 1e-15);
  EXPECT_EQ(core::tracking_error({0, 0, -3.0}, {0, 0, 3.0}).theta, wrap_angle(-6.0));
}

TEST(TrackingError, ChangesAs5Says) {
  holds("(5) is the derivative of (4) along (1)", [] {
    Draw draw(any_seed());
    const Pose pose = draw.pose(1.0), reference = draw.pose(1.0);
    const Twist command{draw.between(-0.2, 0.2), draw.between(-2.0, 2.0)};
    const Twist moves{draw.between(-0.2, 0.2), draw.between(-2.0, 2.0)};
    const double h = 1e-5;
    const TrackingError now = core::tracking_error(reference, pose);
    const auto at = [&](double t) {
      return core::tracking_error(core::advance(reference, moves, t), core::advance(pose, command, t));
    };
    const TrackingError after = at(h), before = at(-h);
    const TrackingError rate = core::error_rate(now, moves, command);
    // A central difference: truncation h^2 |e'''| / 6 (|e'''| <= 8 * 3 m/s^3), rounding 4e-16 / h.
    RC_ASSERT(std::abs((after.x - before.x) / (2.0 * h) - rate.x) <= 1e-9);
    RC_ASSERT(std::abs((after.y - before.y) / (2.0 * h) - rate.y) <= 1e-9);
    RC_ASSERT(std::abs(wrap_angle(after.theta - before.theta) / (2.0 * h) - rate.theta) <= 1e-9);
  });
}

TEST(FormationError, IsPositiveWhereRobotsAreTooClose) {
  const Pose a{0.0, 0.0, 0.0}, b{0.12, 0.0, 0.0};
  EXPECT_EQ(core::formation_error(a, b, a, b), 0.0);
  EXPECT_NEAR(core::formation_error(a, b, a, {0.10, 0.0, 1.0}), 0.02, 1e-15);
  EXPECT_NEAR(core::formation_error(a, b, a, {0.15, 0.0, 1.0}), -0.03, 1e-15);
  // Moving the whole formation, or turning it, changes nothing (35).
  EXPECT_NEAR(core::formation_error(a, b, {1.0, 1.0, 0.0}, {1.0, 1.12, 0.0}), 0.0, 1e-15);
}

TEST(Platoon, ChangesItsSpacingSmoothly) {
  const auto path = std::make_shared<core::Circle>(0.5);
  const core::Platoon platoon(path, 3, 0.12, 0.05, 0.0, {{10.0, 8.0, 0.2}, {30.0, 10.0, 0.1}});
  const auto gap = [&](double t) {  // of arc, from robot 1 to robot 3
    const core::ReferencePoint a = platoon.at(0, t), c = platoon.at(2, t);
    return 0.5 * core::wrap_angle(a.pose.theta - c.pose.theta);
  };
  EXPECT_NEAR(gap(10.0), 0.24, 1e-12);
  EXPECT_NEAR(gap(14.0), 0.32, 1e-12);
  EXPECT_NEAR(gap(18.0), 0.4, 1e-12);
  EXPECT_NEAR(gap(25.0), 0.4, 1e-12);
  EXPECT_NEAR(gap(50.0), 0.2, 1e-12);
  const core::ReferenceDemand demand = platoon.demand(11.0);
  const double h = 1e-5;
  for (double t = 9.0; t < 42.0; t += 0.037) {
    const core::ReferencePoint b = platoon.at(2, t);
    EXPECT_NEAR(b.twist.v, 0.05 - (gap(t + h) - gap(t - h)) / (2.0 * h), 1e-7);
    EXPECT_NEAR(b.twist.omega, b.twist.v / 0.5, 1e-12);
    EXPECT_NEAR(platoon.at(2, t + 1e-6).twist.v, b.twist.v, 1e-7) << "no jump";
    EXPECT_LE(std::abs(b.twist.v), demand.v + 1e-12);
  }
  EXPECT_NEAR(demand.v, 0.05 + 2.0 * 1.875 * 0.1 / 10.0, 1e-12);
}

}  // namespace
}  // namespace skein::test
