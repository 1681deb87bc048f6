// Avoidance in closed loop with the law, the limits and the shield: crossings on a collision course, and back again.
#include <algorithm>
#include <array>

#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"
#include "core/safety/limits.h"
#include "core/safety/shield.h"
#include "draw.h"
#include "encounter.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Pose;
using core::Twist;

/// One encounter_tick of everything in core, in the order of the control encounter_tick, with perfect measurements.
/// Returns the least distance between two robots.
double encounter_tick(Encounter& e, core::Shield* shield) {
  for (auto& point : e.nominal) point.pose = core::advance(point.pose, point.twist, e.dt);
  e.step();
  const std::vector<Twist> reference = e.twists();
  core::use_all_authority(e.gains, reference);
  std::vector<core::TrackingError> errors(e.n);
  for (std::size_t i = 0; i < e.n; ++i) errors[i] = core::tracking_error(e.reference[i].pose, e.poses[i]);
  std::vector<Twist> commands(e.n);
  core::coordination_law(e.gains, errors, reference, commands);
  const core::CommandLimits limits;
  std::vector<double> v_limit(e.n);
  for (std::size_t i = 0; i < e.n; ++i) {
    commands[i] = limits.limit(commands[i]);
    v_limit[i] = limits.v_limit(commands[i].omega);
  }
  if (shield)
    shield->apply({}, {.poses = e.poses, .obstacles = e.obstacles, .v_limit = v_limit}, commands, {e.held.get(), e.n});
  e.twists_before = commands;
  double least = 1e9;
  for (std::size_t i = 0; i < e.n; ++i) {
    e.poses[i] = core::advance(e.poses[i], commands[i], e.dt);
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, core::distance(e.poses[i], e.poses[j]));
  }
  return least;
}

/// Two references on straight lines that meet in the origin at the same time, crossing at `angle`.
Encounter crossing(double angle, double speed, double late) {
  Encounter e(2);
  const double way = 0.6;
  e.nominal[0] = {{-way, 0.0, 0.0}, {speed, 0.0}};
  e.nominal[1] = {{-(way + late) * std::cos(angle), -(way + late) * std::sin(angle), angle}, {speed, 0.0}};
  for (std::size_t i = 0; i < 2; ++i) e.poses[i] = e.nominal[i].pose;
  return e;
}

TEST(AvoidanceDrive, TwoOnACollisionCourseWouldCollideWithoutIt) {
  Encounter e = crossing(0.5 * core::pi, 0.05, 0.01);
  e.parameters.enabled = false;
  double least = 1e9;
  for (int k = 0; k < 600; ++k) least = std::min(least, encounter_tick(e, nullptr));
  EXPECT_LT(least, 2.0 * core::standard_radius);
}

TEST(AvoidanceDrive, TwoOnACollisionCoursePassAndReturn) {
  for (const double angle : {0.4, 0.8, 0.5 * core::pi, 2.0, 2.6, -1.0, -2.0})
    for (const double late : {0.0, 0.01, 0.03}) {
      Encounter e = crossing(angle, 0.05, late);
      core::Shield shield(2, 0);
      double least = 1e9;
      bool avoided = false;
      for (int k = 0; k < 3000; ++k) {  // two minutes
        least = std::min(least, encounter_tick(e, &shield));
        avoided |= e.avoidance.state(0) == core::Avoidance::State::avoiding;
      }
      EXPECT_TRUE(avoided) << angle << ", " << late;
      EXPECT_GE(least, 2.0 * core::standard_radius) << angle << ", " << late;
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(e.avoidance.state(i), core::Avoidance::State::nominal) << angle << ", " << late;
        EXPECT_LT(core::distance(e.poses[i], e.nominal[i].pose), 0.005) << angle << ", " << late;
      }
    }
}

TEST(AvoidanceDrive, ARobotRoundsAnObstacleOrWaits) {
  // An obstacle on the line, a little to one side: the shield keeps the bodies apart whatever the field does.
  for (const double side : {-0.05, -0.02, 0.02, 0.05}) {
    Encounter e(1);
    e.nominal[0] = {{-0.5, 0.0, 0.0}, {0.05, 0.0}};
    e.poses[0] = e.nominal[0].pose;
    e.obstacles = {{0.0, side, 0.04}};
    core::Shield shield(1, 1);
    double least = 1e9;
    for (int k = 0; k < 1500; ++k) {
      encounter_tick(e, &shield);
      least = std::min(least, std::hypot(e.poses[0].x, e.poses[0].y - side) - 0.04 - core::standard_radius);
    }
    EXPECT_GE(least, 0.006) << "8 mm less what turning within a encounter_tick costs; side " << side;
  }
}

}  // namespace
}  // namespace skein::test
