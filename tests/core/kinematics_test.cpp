// (1) and its exact solution, angles, and the wheels of a differential drive.
#include <algorithm>

#include "core/geometry/pose.h"
#include "core/kinematics/differential_drive.h"
#include "core/kinematics/unicycle.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::DifferentialDrive;
using core::pi;
using core::Pose;
using core::Twist;
using core::wrap_angle;

TEST(WrapAngle, IsInTheHalfOpenTurnAndTheSameDirection) {
  holds("wrap_angle lands in (-pi, pi] and points the same way", [] {
    Draw draw(any_seed());
    const double angle = draw.sign() * draw.decades(-6.0, 4.0);
    const double wrapped = wrap_angle(angle);
    RC_ASSERT(wrapped > -pi && wrapped <= pi);
    // 2 pi as a double is off by 2.4e-16, and so is every turn taken off.
    const double turns = std::abs(angle) / (2.0 * pi) + 1.0;
    RC_ASSERT(std::abs(std::cos(wrapped) - std::cos(angle)) <= 3e-16 * turns + 2e-16);
    RC_ASSERT(std::abs(std::sin(wrapped) - std::sin(angle)) <= 3e-16 * turns + 2e-16);
    RC_ASSERT(wrap_angle(wrapped) == wrapped);
  });
}

TEST(WrapAngle, ChoosesPlusPi) {
  EXPECT_EQ(wrap_angle(pi), pi);
  EXPECT_EQ(wrap_angle(-pi), pi);
  EXPECT_EQ(wrap_angle(3.0 * pi), pi);
  EXPECT_EQ(wrap_angle(-3.0 * pi), pi);
  EXPECT_LT(wrap_angle(std::nextafter(pi, 4.0)), -3.14159);
  EXPECT_EQ(wrap_angle(std::nextafter(-pi, 0.0)), std::nextafter(-pi, 0.0));
  EXPECT_EQ(wrap_angle(0.0), 0.0);
  EXPECT_EQ(wrap_angle(2.0 * pi), 0.0);
  EXPECT_EQ(wrap_angle(1.5), 1.5);
}

/// (1) by the classical Runge-Kutta method: error per unit of time about (omega h)^4 v.
Pose runge_kutta(Pose pose, const Twist& twist, double dt, int steps) {
  const double h = dt / steps;
  for (int k = 0; k < steps; ++k) {
    const double start = pose.theta, middle = start + 0.5 * twist.omega * h, end = start + twist.omega * h;
    pose.x += h / 6.0 * twist.v * (std::cos(start) + 4.0 * std::cos(middle) + std::cos(end));
    pose.y += h / 6.0 * twist.v * (std::sin(start) + 4.0 * std::sin(middle) + std::sin(end));
    pose.theta = end;
  }
  pose.theta = wrap_angle(pose.theta);
  return pose;
}

TEST(Unicycle, DrivesTheArcThatAFineIntegrationFinds) {
  holds("advance is the solution of (1)", [] {
    Draw draw(any_seed());
    const Pose from = draw.pose(2.0);
    const double omega = draw.chance(0.1) ? 0.0 : draw.sign() * draw.decades(-9.0, 1.0);
    const Twist twist{draw.between(-0.5, 0.5), omega};
    const double dt = draw.decades(-3.0, 0.3);
    const Pose exact = core::advance(from, twist, dt), fine = runge_kutta(from, twist, dt, 400);
    // |omega| dt <= 20 rad over 400 steps: (0.05)^4 / 2880 of the way at worst, and 400 roundings.
    RC_ASSERT(std::abs(exact.x - fine.x) <= 1e-8 * std::abs(twist.v) * dt + 1e-13);
    RC_ASSERT(std::abs(exact.y - fine.y) <= 1e-8 * std::abs(twist.v) * dt + 1e-13);
    RC_ASSERT(std::abs(wrap_angle(exact.theta - fine.theta)) <= 1e-12);
    RC_ASSERT(exact.theta > -pi && exact.theta <= pi);
  });
}

TEST(Unicycle, ApproachesTheStraightLineAsTheTurnVanishes) {
  const Pose from{0.3, -0.2, 0.7};
  const double v = 0.1, dt = 0.04;
  const Pose straight = core::advance(from, {v, 0.0}, dt);
  EXPECT_DOUBLE_EQ(straight.x, from.x + v * dt * std::cos(0.7));
  EXPECT_DOUBLE_EQ(straight.y, from.y + v * dt * std::sin(0.7));
  EXPECT_EQ(straight.theta, 0.7);
  for (double omega = 1.0; omega > 1e-18; omega /= 3.0) {
    const Pose arc = core::advance(from, {v, omega}, dt);
    // The arc's end lies half the turn's angle to the side of the straight's: v dt * omega dt / 2.
    EXPECT_LE(core::distance(arc, straight), 0.5 * v * dt * omega * dt + 2e-16);
    EXPECT_GE(core::distance(arc, straight), 0.49 * v * dt * omega * dt - 2e-16);
  }
}

TEST(Unicycle, KeepsThePoseBitForBitWhileNothingMoves) {
  const Pose pose{0.3, -0.2, pi};
  EXPECT_EQ(core::advance(pose, {0.0, 0.0}, 1.0), pose);
  EXPECT_EQ(core::advance(pose, {0.1, 1.0}, 0.0), pose);
}

TEST(Unicycle, TwoHalvesOfAnArcAreTheArc) {
  holds("advance composes, forwards and back", [] {
    Draw draw(any_seed());
    const Pose from = draw.pose(2.0);
    const Twist twist{draw.between(-0.2, 0.2), draw.between(-3.0, 3.0)};
    const double first = draw.between(0.0, 1.0), second = draw.between(0.0, 1.0);
    const Pose once = core::advance(from, twist, first + second);
    const Pose twice = core::advance(core::advance(from, twist, first), twist, second);
    RC_ASSERT(core::distance(once, twice) <= 2e-15);
    RC_ASSERT(std::abs(wrap_angle(once.theta - twice.theta)) <= 4e-15);
    const Pose back = core::advance(once, {-twist.v, -twist.omega}, first + second);
    RC_ASSERT(core::distance(back, from) <= 2e-15);
  });
}

TEST(DifferentialDrive, HasTheFactSheetsMeasures) {
  const DifferentialDrive drive;
  EXPECT_NEAR(drive.metres_per_step(), 1.288e-4, 5e-8);
  EXPECT_NEAR(drive.max_wheel_speed(), 0.1288, 5e-5);
  EXPECT_NEAR(0.5 * drive.track, 0.0265, 1e-12);
  DifferentialDrive two;
  two.max_step_rate = 1100;
  EXPECT_NEAR(two.max_wheel_speed(), 0.142, 5e-4);
}

TEST(DifferentialDrive, TurnsTwistsIntoWheelsAndBack) {
  holds("twist(wheels(t)) is t, and wheels(twist(w)) is w", [] {
    Draw draw(any_seed());
    const DifferentialDrive drive{draw.between(0.03, 0.06), draw.between(0.04, 0.1), draw.between(500.0, 2000.0)};
    const Twist twist{draw.between(-0.3, 0.3), draw.between(-5.0, 5.0)};
    const Twist back = drive.twist(drive.wheels(twist));
    RC_ASSERT(std::abs(back.v - twist.v) <= 1e-15);
    RC_ASSERT(std::abs(back.omega - twist.omega) <= 2e-14);
    const core::WheelSpeeds wheels{draw.between(-1000.0, 1000.0), draw.between(-1000.0, 1000.0)};
    const core::WheelSpeeds again = drive.wheels(drive.twist(wheels));
    RC_ASSERT(std::abs(again.left - wheels.left) <= 1e-11);
    RC_ASSERT(std::abs(again.right - wheels.right) <= 1e-11);
  });
}

TEST(DifferentialDrive, HasWheelsThatNeedNotBeAlike) {
  DifferentialDrive drive;
  drive.set_diameters(0.040, 0.042);
  EXPECT_NEAR(drive.left_diameter(), 0.040, 1e-17);
  EXPECT_NEAR(drive.right_diameter(), 0.042, 1e-17);
  EXPECT_NEAR(drive.wheel_diameter, 0.041, 1e-17);
  // Both wheels a turn a second: each comes as far as its own circumference says.
  const core::Twist twist = drive.twist({1000.0, 1000.0});
  EXPECT_NEAR(twist.v, core::pi * 0.041, 1e-15);
  EXPECT_NEAR(twist.omega, core::pi * 0.002 / drive.track, 1e-14);
  const core::Twist wanted{0.05, 0.7}, back = drive.twist(drive.wheels(wanted));
  EXPECT_NEAR(back.v, wanted.v, 1e-16);
  EXPECT_NEAR(back.omega, wanted.omega, 1e-15);
  EXPECT_NEAR(drive.max_wheel_speed(), core::pi * 0.040, 1e-15) << "what the slower rim can do, both can";
}

TEST(DifferentialDrive, TurnsLeftWithTheRightWheelAhead) {
  const DifferentialDrive drive;
  const auto straight = drive.wheels({0.05, 0.0});
  EXPECT_EQ(straight.left, straight.right);
  EXPECT_NEAR(straight.left, 0.05 / (pi * 0.041 / 1000), 1e-9);
  const auto left = drive.wheels({0.0, 1.0});
  EXPECT_GT(left.right, 0.0);
  EXPECT_EQ(left.left, -left.right);
  EXPECT_GT(drive.twist({0.0, 100.0}).omega, 0.0);
}

}  // namespace
}  // namespace skein::test
