// Drives from rest to rest, open paths, rounds: continuous, as far as they should go, and (3) all along.
#include "core/reference/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/reference/polyline.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Point;
using core::ReferencePoint;
using core::Travel;
using core::wrap_angle;

TEST(Travel, IsSmoothFromRestToRest) {
  holds("s' = v, |v'| within the acceleration, v' continuous, the whole way and no more", [] {
    Draw draw(any_seed());
    const double distance = draw.between(0.0, 3.0), speed = draw.between(0.01, 0.5), most = draw.between(0.02, 1.0);
    const bool timed = draw.chance(0.5);
    const double shortest = Travel::shortest(distance, most), given = shortest * draw.between(1.0, 5.0) + 1e-3;
    const Travel travel = timed ? Travel::within(distance, given, most) : Travel(distance, speed, most);
    if (timed && distance > 0.0) RC_ASSERT(std::abs(travel.duration() - given) <= 1e-9 * given);
    if (!timed) RC_ASSERT(travel.speed() <= speed);
    RC_ASSERT(travel.at(-1.0).s == 0.0 && travel.at(-1.0).v == 0.0);
    RC_ASSERT(travel.at(travel.duration() + 1.0).s == distance && travel.at(travel.duration() + 1.0).v == 0.0);

    if (travel.duration() < 1e-6) return;
    const double h = 1e-4 * std::min(travel.duration(), 1.5 * travel.speed() / most);
    const double t = draw.between(0.0, 1.0) * travel.duration();
    const Travel::State a = travel.at(t - h), b = travel.at(t), c = travel.at(t + h);
    RC_ASSERT(b.s >= 0.0 && b.s <= distance * (1.0 + 1e-12) && b.v >= 0.0 && b.v <= travel.speed() * (1.0 + 1e-12));
    RC_ASSERT(std::abs((c.s - a.s) / (2.0 * h) - b.v) <= 1e-6 * (travel.speed() + 1e-6));
    const double before = (b.v - a.v) / h, after = (c.v - b.v) / h;
    RC_ASSERT(std::abs(after) <= most * (1.0 + 1e-6));
    RC_ASSERT(std::abs(after - before) <= 1e-3 * most);  // at no joint does the acceleration jump
  });
}

TEST(Travel, TakesNoLongerThanItMust) {
  const Travel fastest(0.6, 1e9, 0.2);
  EXPECT_NEAR(fastest.duration(), Travel::shortest(0.6, 0.2), 1e-12);
  EXPECT_EQ(Travel(0.0, 0.1, 0.1).duration(), 0.0);
}

std::vector<Point> random_waypoints(Draw& draw) {
  std::vector<Point> points;
  const int n = static_cast<int>(draw.whole(3, 7));
  // Ever further to the right: no corner turns back.
  for (int k = 0; k < n; ++k) points.push_back({0.4 * k + draw.between(-0.1, 0.1), draw.between(-0.3, 0.3)});
  return points;
}

TEST(OpenPath, RunsFromItsFirstPointToItsLastAtUnitSpeed) {
  holds("an open polyline and an open spline", [] {
    Draw draw(any_seed());
    const std::vector<Point> points = random_waypoints(draw);
    const bool line = draw.chance(0.5);
    std::shared_ptr<const core::Path> path;
    if (line)
      path = std::make_shared<core::Polyline>(
          points, std::min(0.1, 0.99 * core::Polyline::largest_radius(points, false)), false);
    else
      path = std::make_shared<core::Spline>(points, false);
    RC_ASSERT(!path->closed());
    const double length = path->length();
    for (const auto& [s, point] : {std::pair{0.0, points.front()}, std::pair{length, points.back()}}) {
      RC_ASSERT(std::hypot(path->at(s).pose.x - point.x, path->at(s).pose.y - point.y) <= 1e-9);
      RC_ASSERT(std::abs(path->at(s).curvature) <= 1e-9);  // straight at its ends
    }
    RC_ASSERT(path->at(-1.0).pose == path->at(0.0).pose && path->at(length + 1.0).pose == path->at(length).pose);
    const double h = 1e-6, s = draw.between(2.0 * h, length - 2.0 * h);
    const core::PathPoint a = path->at(s - h), b = path->at(s), c = path->at(s + h);
    RC_ASSERT(std::abs(core::distance(a.pose, c.pose) / (2.0 * h) - 1.0) <= 1e-6);
    if (a.curvature != 0.0 && c.curvature != 0.0)
      RC_ASSERT(std::abs(wrap_angle(c.pose.theta - a.pose.theta) / (2.0 * h) - b.curvature) <=
                1e-3 * (1.0 + path->largest_curvature()));
    RC_ASSERT(std::abs(b.curvature) <= path->largest_curvature());
  });
}

TEST(Drive, HasTheVelocitiesOf3AndTurnsOnTheSpotAfterwards) {
  const auto path =
      std::make_shared<core::Spline>(std::vector<Point>{{0, 0}, {0.4, 0.1}, {0.6, 0.5}, {0.5, 0.9}}, false);
  const Travel travel(path->length(), 0.08, 0.05);
  const core::Drive drive(path, 0.0, 2.0, travel, -0.5);
  EXPECT_EQ(drive.at(1.0).twist, core::Twist{});
  const double h = 1e-5, arrival = 2.0 + travel.duration();
  for (double t = 1.5; t < arrival + 10.0; t += 0.0371) {
    const ReferencePoint a = drive.at(t - h), b = drive.at(t), c = drive.at(t + h);
    const double dx = (c.pose.x - a.pose.x) / (2.0 * h), dy = (c.pose.y - a.pose.y) / (2.0 * h);
    EXPECT_NEAR(b.twist.v * std::cos(b.pose.theta), dx, 2e-6) << t;
    EXPECT_NEAR(b.twist.v * std::sin(b.pose.theta), dy, 2e-6) << t;
    EXPECT_NEAR(b.twist.omega, wrap_angle(c.pose.theta - a.pose.theta) / (2.0 * h), 1e-5) << t;
    EXPECT_LE(std::abs(c.twist.v - a.twist.v) / (2.0 * h), 0.05 * (1.0 + 1e-6)) << t;
  }
  EXPECT_EQ(drive.at(arrival + 100.0).twist.omega, -0.5);
  EXPECT_EQ(drive.at(arrival + 100.0).twist.v, 0.0);
  const core::ReferenceDemand demand = drive.demand(11.0);
  EXPECT_GE(demand.v, 0.08);
  EXPECT_GE(demand.turning, 0.5);
}

TEST(Drive, KeepsItsHeadingAtRest) {
  const auto path = std::make_shared<core::Polyline>(std::vector<Point>{{0.5, 0.5}, {-0.5, -0.5}}, 0.1, false);
  const core::Drive drive(path, 0.0, 0.0, Travel(path->length(), 0.1, 0.1), 0.0);
  for (double t : {-5.0, 0.0, 3.0, 100.0}) EXPECT_DOUBLE_EQ(drive.at(t).pose.theta, std::atan2(-1.0, -1.0));
  EXPECT_NEAR(drive.at(1e6).pose.x, -0.5, 1e-12);
  EXPECT_TRUE(drive.smooth());
  EXPECT_EQ(drive.end(), Travel(path->length(), 0.1, 0.1).duration());
}

TEST(Independent, DemandsTheMostOfAll) {
  std::vector<std::unique_ptr<const core::Trajectory>> all;
  all.push_back(std::make_unique<core::Rounds>(std::make_shared<core::Circle>(0.5), 0.05, 0.0));
  all.push_back(std::make_unique<core::Rounds>(
      std::make_shared<core::MovedPath>(std::make_shared<core::Circle>(0.1), 1.0, 0.5), 0.02, 0.0));
  const core::Independent independent(std::move(all));
  EXPECT_DOUBLE_EQ(independent.demand(11.0).v, 0.05);
  EXPECT_DOUBLE_EQ(independent.demand(11.0).turning, 0.05 * 13.0);
  EXPECT_NEAR(independent.at(1, 0.0).pose.x, 1.1, 1e-15);
  EXPECT_NEAR(independent.at(1, 0.0).pose.y, 0.5, 1e-15);
  EXPECT_EQ(independent.lines().size(), 2u);
}

}  // namespace
}  // namespace skein::test
