// The shortest path of one robot, against geometry.
#include "app/experiment/ways.h"

#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numbers>

#include "app/experiment/experiment_file.h"

namespace skein::app {
namespace {

/// An arena of 2.0 m x 1.5 m with these obstacles, and one robot.
Experiment with_obstacles(std::vector<core::Obstacle> obstacles) {
  static const Experiment paper = paper_experiment();  // reading it would take longer than a path
  Experiment e = paper;
  e.robots.resize(1);
  e.arena_width = 2.0;
  e.arena_height = 1.5;
  e.obstacles = std::move(obstacles);
  return e;
}

TEST(ShortestPaths, IsTheStraightLineWhereItIsFree) {
  const Experiment e = with_obstacles({{0.0, 0.3, 0.1}});
  ShortestPaths paths(e);
  EXPECT_DOUBLE_EQ(paths.length(0, {-0.8, 0.0, 0.0}, {0.8, 0.1, 0.0}).value(), std::hypot(1.6, 0.1));
}

/// Two tangents, and the arc between them.
TEST(ShortestPaths, GoesRoundAnObstacleAlongItsTangents) {
  for (const double radius : {0.05, 0.2, 0.4}) {
    const Experiment e = with_obstacles({{0.0, 0.0, radius}});
    ShortestPaths paths(e);
    const double away = 0.8, around = radius + e.robots[0].radius;
    const double shortest =
        2.0 * std::sqrt(away * away - around * around) + around * (std::numbers::pi - 2.0 * std::acos(around / away));
    const double length = paths.length(0, {-away, 0.0, 0.0}, {away, 0.0, 0.0}).value();
    EXPECT_GE(length, shortest - 1e-9) << radius;
    EXPECT_LE(length, 1.01 * shortest) << radius;
  }
}

TEST(ShortestPaths, IsAsLongAsTheBodyIsLargeAndNoneWhereItDoesNotFit) {
  // A wall with a gap at y = 0.4 that is 0.1 m wide.
  std::vector<core::Obstacle> wall;
  for (double y = -0.74; y < 0.3; y += 0.02) wall.push_back({0.0, y, 0.03});
  const double below = wall.back().y + 0.03;
  for (double y = below + 0.1 + 0.03; y < 0.76; y += 0.02) wall.push_back({0.0, y, 0.03});
  Experiment e = with_obstacles(wall);
  e.robots[0].radius = 0.035;
  const core::Pose from{-0.6, -0.3, 0.0}, to{0.6, -0.3, 0.0};
  const double gap = below + 0.05;
  const double through = 2.0 * std::hypot(0.6, gap + 0.3);
  const double length = ShortestPaths(e).length(0, from, to).value();
  EXPECT_LE(length, 1.01 * through);
  EXPECT_GE(length, 0.95 * through);
  e.robots[0].radius = 0.055;
  EXPECT_FALSE(ShortestPaths(e).length(0, from, to));
}

RC_GTEST_PROP(ShortestPaths, IsTheSameThereAndBackAndNoShorterThanTheLine, ()) {
  const auto coordinate = [](int most) { return 0.001 * *rc::gen::inRange(-most, most + 1); };
  std::vector<core::Obstacle> obstacles(*rc::gen::inRange<std::size_t>(1, 9));
  for (core::Obstacle& o : obstacles) o = {coordinate(900), coordinate(650), 0.001 * *rc::gen::inRange(20, 200)};
  const Experiment e = with_obstacles(obstacles);
  const core::Pose from{coordinate(900), coordinate(650), 0.0}, to{coordinate(900), coordinate(650), 0.0};
  for (const core::Obstacle& o : obstacles)
    for (const core::Pose& end : {from, to})
      RC_PRE(std::hypot(end.x - o.x, end.y - o.y) > o.radius + e.robots[0].radius + 0.01);
  ShortestPaths paths(e);
  const std::optional<double> there = paths.length(0, from, to), back = paths.length(0, to, from);
  RC_ASSERT(there.has_value() == back.has_value());
  if (!there) return;
  RC_ASSERT(*there >= core::distance(from, to) - 1e-9);
  RC_ASSERT(std::abs(*there - *back) <= 0.03 * *there + 1e-9);
}

}  // namespace
}  // namespace skein::app
