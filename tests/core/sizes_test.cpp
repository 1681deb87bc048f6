// Bodies of different sizes: shield, field and detours keep the sum of two radii and the margin.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "core/avoidance/avoidance.h"
#include "core/kinematics/robot_type.h"
#include "core/kinematics/step_motor.h"
#include "core/kinematics/unicycle.h"
#include "core/safety/shield.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Pose;
using core::ShieldParameters;
using core::Sizes;
using core::Twist;

/// Robots that all drive at full speed to where they look, for some seconds: the least gap that a pair had beside the
/// one that it must keep, and the farthest that a body was over the edge. [m]
struct Worst {
  double gap = std::numeric_limits<double>::infinity();
  double over = -std::numeric_limits<double>::infinity();
};
Worst drive(std::vector<Pose> poses, const std::vector<double>& radii, bool told) {
  const std::size_t n = poses.size();
  std::vector<double> beyond;
  for (const double radius : radii) beyond.push_back(radius - core::standard_radius);
  ShieldParameters parameters;
  parameters.half_width = parameters.half_height = 0.8;
  core::Shield shield(n, 0);
  Worst worst;
  std::array<bool, 8> touched{};
  for (int tick = 0; tick < 400; ++tick) {
    std::vector<Twist> commands(n, Twist{0.1, 0.0});
    const std::vector<double> v_limit(n, 0.1);
    shield.apply(parameters, {.poses = poses, .v_limit = v_limit, .sizes = told ? Sizes(beyond) : Sizes()}, commands,
                 {touched.data(), n});
    for (std::size_t i = 0; i < n; ++i) {
      poses[i] = core::advance(poses[i], commands[i], dt);
      worst.over = std::max({worst.over, std::abs(poses[i].x) + radii[i] - 0.8, std::abs(poses[i].y) + radii[i] - 0.8});
      for (std::size_t j = 0; j < i; ++j)
        worst.gap = std::min(worst.gap, core::distance(poses[i], poses[j]) - radii[i] - radii[j]);
    }
  }
  return worst;
}

TEST(Sizes, TheShieldKeepsTheSameGapBetweenAnyTwoBodies) {
  const double margin = ShieldParameters{}.distance - 2.0 * core::standard_radius;
  test::holds("8 mm, and inside", [&] {
    const std::size_t n = *rc::gen::inRange<std::size_t>(2, 6);
    std::vector<Pose> poses;
    std::vector<double> radii;
    Draw draw(any_seed());
    for (int tries = 0; poses.size() < n && tries < 1000; ++tries) {
      const Pose pose{draw.between(-0.6, 0.6), draw.between(-0.6, 0.6), draw.between(-3.1, 3.1)};
      const double radius = draw.between(0.02, 0.12);
      bool free = true;
      for (std::size_t j = 0; j < poses.size(); ++j)
        free = free && core::distance(pose, poses[j]) > radius + radii[j] + margin;
      if (!free) continue;
      poses.push_back(pose);
      radii.push_back(radius);
    }
    const Worst worst = drive(poses, radii, true);
    RC_ASSERT(worst.gap >= margin - 1e-6);
    RC_ASSERT(worst.over <= -margin + 1e-6);
  });
}

TEST(Sizes, WithoutThemLargeBodiesMeet) {
  const std::vector<Pose> head_on{{-0.4, 0.0, 0.0}, {0.4, 0.0, core::pi}};
  EXPECT_LT(drive(head_on, {0.07, 0.06}, false).gap, 0.0);
  EXPECT_GE(drive(head_on, {0.07, 0.06}, true).gap, 0.008 - 1e-6);
}

TEST(Sizes, StandardBodiesChangeNothingToTheBit) {
  const std::vector<Pose> start{{-0.4, 0.01, 0.02}, {0.4, 0.0, core::pi}, {0.0, 0.3, -1.5}};
  const std::vector<double> radii(3, core::standard_radius);
  const Worst with = drive(start, radii, true), without = drive(start, radii, false);
  EXPECT_EQ(with.gap, without.gap);
  EXPECT_EQ(with.over, without.over);
}

TEST(Sizes, TheFieldsRegionGrowsByWhatBothBodiesAreLarger) {
  // Two robots 0.14 m apart: outside the region of 0.10 m of two e-pucks, inside that of two of 60 mm.
  const std::vector<Pose> poses{{0.0, 0.0, 0.0}, {0.14, 0.0, 0.0}};
  const std::vector<Twist> twists(2);
  const std::vector<core::ReferencePoint> nominal{{poses[0], {0.05, 0.0}}, {poses[1], {0.05, 0.0}}};
  std::vector<core::ReferencePoint> reference(2);
  const core::Gains gains = core::paper_gains(2);
  const std::vector<double> beyond(2, 0.025);
  for (const bool large : {false, true}) {
    core::Avoidance avoidance(2, 0);
    core::Scene scene{poses, twists, {}, {}};
    if (large) scene.sizes = Sizes(beyond);
    avoidance.step({}, gains, dt, scene, nominal, reference);
    EXPECT_EQ(avoidance.state(0) == core::Avoidance::State::avoiding, large);
  }
  // And each robot has its own region (30), where it is given one.
  core::Avoidance avoidance(2, 0);
  std::vector<core::AvoidanceParameters> own(2);
  own[1].alpha = own[1].beta = 0.2;
  avoidance.step({}, gains, dt, {poses, twists, {}, {}}, nominal, reference, own);
  EXPECT_EQ(avoidance.state(0), core::Avoidance::State::nominal);
  EXPECT_EQ(avoidance.state(1), core::Avoidance::State::avoiding);
}

TEST(RobotTypes, HaveNamesOfTheirOwnAndMeasuresThatAreOnes) {
  for (const core::RobotType& type : core::robot_types) {
    EXPECT_EQ(core::find_robot_type(type.name), &type) << "the name is taken twice";
    EXPECT_GT(type.radius, 0.5 * type.wheels.track - 0.01) << type.name << ": the wheels stand inside the body";
    EXPECT_GT(type.wheels.max_wheel_speed(), 0.1) << type.name << ": v_max of the paper";
  }
  EXPECT_EQ(core::find_robot_type("nobody"), nullptr);
  const core::RobotType& epuck = *core::find_robot_type("epuck1");
  EXPECT_EQ(epuck.radius, core::standard_radius);
  EXPECT_EQ(epuck.wheels.max_step_rate, core::max_step_rate(core::MotorModel::epuck1));
  EXPECT_EQ(core::find_robot_type("epuck2")->wheels.max_step_rate, core::max_step_rate(core::MotorModel::epuck2));
  // 0.6781 mm/s a unit of speed, as K-Team's library has it.
  EXPECT_NEAR(core::find_robot_type("khepera4")->wheels.metres_per_step(), 0.6781e-3, 1e-12);
}

TEST(ServoMotor, RunsAnyWholeSpeedAndStandsAtNone) {
  EXPECT_EQ(core::nearest_command(core::MotorModel::servo, 1234.4), 1234.0);
  EXPECT_EQ(core::nearest_command(core::MotorModel::servo, -0.6), -1.0);
  EXPECT_EQ(core::actual_step_rate(core::MotorModel::servo, 3.0), 3.0);
  core::StepMotor motor(core::MotorModel::servo);
  motor.command(2500.0);
  motor.advance(2.0);
  EXPECT_EQ(motor.counter(), 5000);
}

}  // namespace
}  // namespace skein::test
