// Past an obstacle on the lane: as far beside it as must be, smoothly, abreast of the place.
#include "core/planning/sidestep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"
#include "core/planning/planner.h"
#include "core/reference/platoon.h"
#include "core/safety/limits.h"
#include "core/safety/shield.h"
#include "draw.h"
#include "lab.h"

namespace skein::test {
namespace {

using core::Obstacle;
using core::Pose;
using core::ReferencePoint;
using core::Twist;

/// The paper's platoon on its lap.
core::Platoon lap(double start) {
  return core::Platoon(std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119), 4, 0.12, 0.05, start);
}

struct Ride {
  double aside = 0.0;   // the farthest that somebody was from its place [m]
  double change = 0.0;  // largest of a speed between two ticks [m/s]
  double gap = 1e9;     // smallest to the obstacle [m]
  double apart = 1e9;   // smallest between two midpoints [m]
  double last = 0.0;    // from its place at the end [m]
  int reversals = 0;
  bool passed = false;  // somebody passed
};

/// The platoon drives for `duration`; the obstacle is there from `from` on.
Ride drive(const core::Reference& reference, const Obstacle& obstacle, double from, double duration) {
  const std::size_t n = reference.robots();
  const core::Gains paper = core::paper_gains(n);
  core::Planner planner({n, 1, arena, 0.078, duration}, reference);
  core::Shield shield(n, 1);
  core::ShieldParameters parameters;
  parameters.half_width = arena.width;
  parameters.half_height = arena.height;
  const core::CommandLimits limits;
  core::LawPairs pairs(n);
  std::vector<Pose> poses(n), midway(n);
  std::vector<ReferencePoint> nominal(n), followed(n);
  std::vector<Twist> twists(n), commands(n), last(n);
  std::vector<core::TrackingError> errors(n);
  std::vector<double> v_limit(n);
  std::vector<int> sign(n);
  const std::vector<std::uint8_t> nobody(n);
  const std::unique_ptr<bool[]> touched(new bool[n]());
  reference.core::Reference::at(0.0, nominal);
  for (std::size_t i = 0; i < n; ++i) poses[i] = nominal[i].pose, last[i] = nominal[i].twist;
  Ride ride;
  for (int k = 0; k * dt < duration; ++k) {
    const double t = k * dt;
    reference.core::Reference::at(t, nominal);
    core::Gains gains = paper;
    for (core::PairTable* table : {&gains.k_xx, &gains.k_tt, &gains.k_yy})
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) table->set(i, j, planner.share(i) * planner.share(j) * (*table)(i, j));
    std::vector<Obstacle> obstacles;
    if (t >= from) obstacles.push_back(obstacle);
    planner.step({t, false, poses, last, nobody, nobody, obstacles, 0.0}, gains, dt, nominal, followed);
    for (std::size_t i = 0; i < n; ++i) {
      twists[i] = followed[i].twist;
      errors[i] = core::tracking_error(followed[i].pose, poses[i]);
      ride.passed = ride.passed || planner.state(i) == core::Planner::State::passing;
      EXPECT_GE(core::margins(gains, i, twists[i]).f, -gains.v_max[i]);
    }
    core::use_policy(gains, twists);
    core::coordination_law(gains, errors, twists, commands, pairs);
    for (std::size_t i = 0; i < n; ++i) {
      commands[i] = limits.limit(commands[i]);
      v_limit[i] = limits.v_limit(commands[i].omega);
      midway[i] = {poses[i].x, poses[i].y, poses[i].theta + 0.5 * commands[i].omega * dt};
    }
    shield.apply(parameters, {midway, obstacles, v_limit}, commands, {touched.get(), n});
    for (std::size_t i = 0; i < n; ++i) {
      ride.change = std::max(ride.change, std::abs(commands[i].v - last[i].v));
      const int now = commands[i].v > 0.005 ? 1 : commands[i].v < -0.005 ? -1 : 0;
      if (now != 0 && sign[i] == -now) ++ride.reversals;
      if (now != 0) sign[i] = now;
      poses[i] = core::advance(poses[i], commands[i], dt);
      const double away = core::distance(poses[i], reference.at(i, t + dt).pose);
      ride.aside = std::max(ride.aside, away);
      if (t + dt >= duration - 0.5 * dt) ride.last = std::max(ride.last, away);
      if (t >= from)
        ride.gap = std::min(ride.gap, std::hypot(poses[i].x - obstacle.x, poses[i].y - obstacle.y) - obstacle.radius -
                                          core::standard_radius);
      for (std::size_t j = 0; j < i; ++j) ride.apart = std::min(ride.apart, core::distance(poses[i], poses[j]));
    }
    last = commands;
  }
  return ride;
}

TEST(Sidestep, PassesAnObstacleOnTheStraightNoFartherThanMustBe) {
  const core::Platoon platoon = lap(1.6);
  for (const double radius : {0.03, 0.045, 0.06})
    for (const double off : {-0.06, -0.02, 0.0, 0.03, 0.07}) {
      SCOPED_TRACE(testing::Message() << radius << " " << off);
      const Ride ride = drive(platoon, {0.0, 0.45 + off, radius}, 0.0, 50.0);
      const double needed = std::max(0.0, radius + 0.043 - std::abs(off));
      EXPECT_TRUE(ride.passed);
      EXPECT_LE(ride.aside, needed + 0.008);
      EXPECT_LE(ride.change, 0.03);
      EXPECT_EQ(ride.reversals, 0);
      EXPECT_GE(ride.gap, 0.008);
      EXPECT_GE(ride.apart, 0.078);
      EXPECT_LT(ride.last, 0.001);
    }
}

/// By how much a way comes nearer to obstacles and edges, or sooner, than the shield allows. [m]
double lacks_room(const core::Sidestep& way, const core::SidestepSearch::Query& query, const core::Reference& reference,
                  const core::Lattice& lattice) {
  double most = 0.0, before = -1.0;
  for (int k = 0; query.t + 0.1 * k < way.ends(); ++k) {
    const Pose at = way.pose(reference, query.robot, query.t + 0.1 * k);
    const double room = lattice.room(at.x, at.y);
    most = std::max(most, std::max(0.0, std::exp(-0.1 * query.gamma) * before) - room);
    before = room;
  }
  return most;
}

TEST(SidestepSearch, AWayIsDrivenAsItWasChecked) {
  // Before and in corners, where means of headings over longer times are tried, and with a clock that slows down.
  const core::Gains gains = core::paper_gains(4);
  // Also where the edges of the arena leave 3 cm outside the lane: nearly all ways lead along the inside.
  core::Lattice wide(arena, 0.0435, 1), tight({0.72, 0.52}, 0.0435, 1);
  int ways = 0, corners = 0;
  for (int start = 0; start < 80; ++start)
    for (const bool slow : {false, true}) {
      core::Lattice& lattice = start < 40 ? wide : tight;
      const core::Platoon platoon = lap(0.1 * (start % 40));
      const Pose there = platoon.at(0, 5.8).pose;
      const Obstacle obstacle{there.x, there.y, 0.04};
      lattice.build({&obstacle, 1});
      core::SidestepSearch::Query query;
      query.t = 1.0;
      query.pace = {core::free_v(gains, 0), core::free_omega(gains, 0)};
      if (slow) query.delay = core::Delay({query.t, 0.0, 0.0}, 0.6, 1.5, 0.3, 11.0);
      core::SidestepSearch search;
      if (search.begin(query, platoon, lattice) != core::SidestepSearch::Lane::blocked) continue;
      for (core::Sidestep way; search.next(way); ++ways) {
        EXPECT_EQ(way.delay().ends(), query.delay.ends());
        corners += std::abs(platoon.at(0, way.begins() + 2.0).twist.omega) > 0.1;
        for (int k = 0; query.t + 0.1 * k < way.ends(); ++k) {
          const ReferencePoint at = way.shift(platoon, 0, query.t + 0.1 * k);
          ASSERT_LE(at.twist.v, query.pace.v + 1e-9) << "start " << start << ", " << k << (slow ? ", slow" : "");
        }
        ASSERT_LE(lacks_room(way, query, platoon, lattice), 2e-4) << "start " << start << (slow ? ", slow" : "");
      }
    }
  EXPECT_GT(ways, 100);
  EXPECT_GT(corners, 10);
}

/// Beside the lane stands what the place itself drives past, before, beside and behind the obstacle on the lane.
TEST(SidestepSearch, NoWayLeadsIntoWhatStandsBesideTheLane) {
  const core::Gains gains = core::paper_gains(4);
  core::Lattice lattice(arena, 0.0435, 3);
  int ways = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Draw draw(seed);
    const core::Platoon platoon = lap(draw.between(0.0, 4.0));
    const double meets = draw.between(5.0, 6.5);
    const auto obstacle = [&](double around, double from, double to) {
      const double t = meets + draw.between(-around, around), off = draw.between(from, to);
      const Pose place = platoon.at(0, t).pose;
      const double x = place.x - off * std::sin(place.theta), y = place.y + off * std::cos(place.theta);
      return Obstacle{x, y, draw.between(0.03, 0.05)};
    };
    const std::vector<Obstacle> obstacles{obstacle(0.0, -0.05, 0.05), obstacle(3.0, 0.1, 0.2),
                                          obstacle(3.0, -0.2, -0.1)};
    core::SidestepSearch::Query query;
    query.t = 1.0;
    query.pace = {core::free_v(gains, 0), core::free_omega(gains, 0)};
    lattice.build(obstacles);
    core::SidestepSearch search;
    if (search.begin(query, platoon, lattice) != core::SidestepSearch::Lane::blocked) continue;
    for (core::Sidestep way; search.next(way); ++ways)
      ASSERT_LE(lacks_room(way, query, platoon, lattice), 2e-4) << "seed " << seed;
  }
  EXPECT_GT(ways, 300);
}

}  // namespace
}  // namespace skein::test
