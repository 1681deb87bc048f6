// V falls, as (20) says, or the tick says that it does not: no false alarm on healthy robots, an alarm on broken ones.
#include <gtest/gtest.h>

#include "tests/app/experiment_texts.h"
#include "tests/app/fixture.h"

namespace skein::app {
namespace {

int alarms(const std::vector<TickRecord>& rows) {
  int count = 0;
  for (const TickRecord& row : rows)
    for (const Event& event : row.events) count += is<events::VRise>(event);
  return count;
}

class Healthy : public testing::TestWithParam<const char*> {};

TEST_P(Healthy, RobotsRaiseNoAlarm) {
  auto e = load_experiment(experiments + GetParam() + ".toml");
  ASSERT_TRUE(e) << e.error().front().message();
  EXPECT_EQ(alarms(test::simulate(*e)), 0);
  e->simulation.pose_noise = 0.001;
  e->simulation.heading_noise = 0.5 * core::pi / 180.0;
  e->simulation.latency = 0.08;
  e->simulation.dropout = 0.05;
  e->simulation.slip = 0.02;
  for (RobotSpec& robot : e->robots) robot.motor = core::MotorModel::epuck2, robot.drive.max_step_rate = 1100.0;
  for (e->seed = 1; e->seed <= 3; ++e->seed) EXPECT_EQ(alarms(test::simulate(*e)), 0) << e->seed;
}
INSTANTIATE_TEST_SUITE_P(Examples, Healthy,
                         testing::Values("platoon", "uncoupled", "lemniscate", "diamond-to-line", "corner-blends",
                                         "unequal-speeds", "parking", "obstacles", "crossing", "kidnap",
                                         "antipodal-swap-4", "antipodal-swap-6"));

TEST(Broken, RobotsAreNoticed) {
  Experiment e = paper_experiment();
  e.duration = 30.0;
  e.perturbations.clear();
  Experiment plant = e;
  plant.robots[1].drive.wheel_diameter *= 0.98;  // as real ones differ
  EXPECT_EQ(alarms(test::simulate(e, plant)), 0);
  plant.robots[1].drive.wheel_diameter = 0.6 * e.robots[1].drive.wheel_diameter;
  EXPECT_GT(alarms(test::simulate(e, plant)), 0);
  plant = e;
  plant.robots[2].drive.track *= 2.0;  // turns half as much as it is told
  EXPECT_GT(alarms(test::simulate(e, plant)), 0);
}

TEST(Limits, ThatBiteAreNamed) {
  Experiment e = paper_experiment();
  e.duration = 40.0;
  for (RobotSpec& robot : e.robots) robot.drive.max_step_rate = 450.0;  // 0.058 m/s of each wheel
  std::uint8_t seen = 0;
  for (const TickRecord& row : test::simulate(e))
    for (const RobotRecord& robot : row.robots) {
      EXPECT_EQ(robot.limits != 0, robot.is(limited));
      const core::CommandLimits limits = make_limits(e, 0);
      EXPECT_EQ((robot.limits & limit_v) != 0, !robot.is(stopped) && std::abs(robot.law.v) > limits.v_max);
      EXPECT_EQ((robot.limits & limit_omega) != 0, !robot.is(stopped) && std::abs(robot.law.omega) > limits.omega_max);
      const double wheel = std::abs(robot.law.v) + 0.5 * limits.drive.track * std::abs(robot.command.omega);
      if (wheel > limits.drive.max_wheel_speed() + 1e-12 && !robot.is(stopped)) {
        EXPECT_NE(robot.limits & limit_wheels, 0);
      }
      seen |= robot.limits;
    }
  EXPECT_NE(seen & limit_wheels, 0);
}

}  // namespace
}  // namespace skein::app
