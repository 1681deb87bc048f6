// Ways round one another: crowds that all want through one point, robots that are held up, places at rest.
#include "core/avoidance/steering.h"

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
using State = core::Avoidance::State;

/// Uncoupled robots with places at rest to go to; law, limits and shield as in the control tick.
struct Crossing : Encounter {
  Crossing(std::size_t robots, double horizon) : Encounter(robots), shield(robots, 100) {
    parameters.horizon = horizon;
    for (core::PairTable* table : {&gains.k_xx, &gains.k_tt, &gains.k_yy}) table->fill(0.0);
  }

  /// Drives until everybody is within a centimetre of its place, and says when that was [s]; NaN: not in time.
  double drive(double most) {
    std::vector<core::Twist> commands(n);
    std::vector<core::TrackingError> errors(n);
    std::vector<double> v_limit(n);
    const core::CommandLimits limits;
    for (double t = 0.0; t < most; t += dt) {
      step();
      const std::vector<core::Twist> asked = twists();
      core::use_all_authority(gains, asked);
      for (std::size_t i = 0; i < n; ++i) {
        const core::ReferenceBounds bounds = core::reference_bounds(gains, i);
        in_bounds =
            in_bounds && core::margins(gains, i, asked[i]).hold(1e-9) && std::abs(asked[i].v) <= bounds.v + 1e-12;
        errors[i] = core::tracking_error(reference[i].pose, poses[i]);
      }
      core::coordination_law(gains, errors, asked, commands);
      std::vector<Pose> midway = poses;
      for (std::size_t i = 0; i < n; ++i) {
        commands[i] = limits.limit(commands[i]);
        v_limit[i] = limits.v_limit(commands[i].omega);
        midway[i].theta += 0.5 * commands[i].omega * dt;
      }
      shield.apply({}, {.poses = midway, .obstacles = obstacles, .v_limit = v_limit}, commands, {held.get(), n});
      twists_before = commands;
      double farthest = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        poses[i] = core::advance(poses[i], commands[i], dt);
        farthest = std::max(farthest, core::distance(poses[i], nominal[i].pose));
        for (std::size_t j = 0; j < i; ++j) least = std::min(least, core::distance(poses[i], poses[j]));
        for (const core::Obstacle& o : obstacles)
          least_gap =
              std::min(least_gap, std::hypot(poses[i].x - o.x, poses[i].y - o.y) - o.radius - core::standard_radius);
      }
      if (farthest < 0.01) return t;
    }
    return std::numeric_limits<double>::quiet_NaN();
  }

  core::Shield shield;
  double least = 1e9, least_gap = 1e9;
  bool in_bounds = true;
};

/// Robots on a circle, everybody's place on the other side.
Crossing swap(std::size_t robots, double radius, double horizon, Draw* draw = nullptr) {
  Crossing c(robots, horizon);
  for (std::size_t i = 0; i < robots; ++i) {
    const double a = 2.0 * core::pi * static_cast<double>(i) / static_cast<double>(robots);
    const double along = draw ? draw->between(-0.02, 0.02) : 0.0;
    c.poses[i] = {(radius + along) * std::cos(a), (radius + along) * std::sin(a), core::wrap_angle(a + core::pi)};
    c.nominal[i] = {{-radius * std::cos(a), -radius * std::sin(a), core::wrap_angle(a + core::pi)}, {}};
  }
  return c;
}

TEST(Steering, CrowdsThatSwapPlacesArriveAndNeverTouch) {
  for (const std::size_t robots : {2, 3, 4, 6, 10, 20}) {
    Crossing c = swap(robots, 0.55, 3.0);
    EXPECT_LT(c.drive(60.0), 45.0) << robots;
    EXPECT_GE(c.least, 0.078 - 1e-6) << robots;
    EXPECT_TRUE(c.in_bounds) << robots << ": (18)";
  }
}

TEST(Steering, SoDoThoseThatOnlyTheirDeadlocksTeach) {
  for (const std::size_t robots : {2, 4, 6}) {
    Crossing c = swap(robots, 0.4, 0.0);
    EXPECT_LT(c.drive(120.0), 120.0) << robots;
    EXPECT_GE(c.least, 0.078 - 1e-6) << robots;
    EXPECT_TRUE(c.in_bounds) << robots << ": (18)";
  }
}

TEST(Steering, StartsThatAreNotEvenMakeNoDifference) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Draw draw(seed);
    Crossing c = swap(8, 0.5, 3.0, &draw);
    EXPECT_LT(c.drive(60.0), 60.0) << seed;
    EXPECT_GE(c.least, 0.078 - 1e-6) << seed;
  }
}

TEST(Steering, OneThatWasPushedAwayFromAPlaceAtRestComesBack) {
  holds("to within a centimetre, wherever it was put and however it looks", [] {
    Draw draw(any_seed());
    Crossing c(1, draw.chance(0.5) ? 3.0 : 0.0);
    c.nominal[0].pose = draw.pose(0.3);
    c.poses[0] = draw.pose(0.5);
    RC_ASSERT(c.drive(40.0) < 40.0);
    RC_ASSERT(c.in_bounds);
    for (int k = 0; k < 250; ++k) c.drive(c.dt);
    RC_ASSERT(c.avoidance.state(0) == State::nominal);
    RC_ASSERT(std::abs(core::wrap_angle(c.poses[0].theta - c.nominal[0].pose.theta)) < 0.1);
  });
}

TEST(Steering, AFieldOfObstaclesIsCrossed) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed);
    Crossing c(1, seed % 2 ? 3.0 : 0.0);
    c.poses[0] = {-0.8, 0.0, 0.0};
    c.nominal[0] = {{0.8, 0.0, 0.0}, {}};
    while (c.obstacles.size() < 5) {
      const core::Obstacle o{draw.between(-0.5, 0.5), draw.between(-0.2, 0.2), draw.between(0.03, 0.07)};
      if (std::all_of(c.obstacles.begin(), c.obstacles.end(), [&](const core::Obstacle& other) {
            return std::hypot(o.x - other.x, o.y - other.y) > o.radius + other.radius + 0.14;
          }))
        c.obstacles.push_back(o);
    }
    EXPECT_LT(c.drive(120.0), 120.0) << seed;
    EXPECT_GE(c.least_gap, 0.008 - 1e-6) << seed;
  }
}

}  // namespace
}  // namespace skein::test
