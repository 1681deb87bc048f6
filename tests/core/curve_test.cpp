// The paths that are given by another parameter, or by points: what their arc length, heading and curvature promise.
#include "core/reference/curve.h"

#include <cmath>
#include <memory>

#include "core/reference/polyline.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Path;
using core::PathPoint;
using core::pi;
using core::Point;
using core::wrap_angle;

/// Points around the origin, one in every part of the turn, so that the line does not turn back on itself.
std::vector<Point> random_points(Draw& draw) {
  const int n = draw.whole(4, 9);
  std::vector<Point> points;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * pi * (i + draw.between(-0.2, 0.2)) / n, r = draw.between(0.5, 1.0);
    points.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return points;
}

std::unique_ptr<Path> random_curve(Draw& draw) {
  const double width = draw.between(0.5, 2.0), height = draw.between(0.5, 2.0);
  switch (draw.whole(0, 2)) {
    case 0:
      return std::make_unique<core::Ellipse>(width, height);
    case 1:
      return std::make_unique<core::Lemniscate>(width, height);
    default:
      return std::make_unique<core::Spline>(random_points(draw));
  }
}

TEST(Curve, HasUnitSpeedItsHeadingIsTheTangentAndItsCurvatureTheTurn) {
  holds("|dp/ds| = 1, theta the tangent, curvature = dtheta/ds, curvature_rate its derivative", [] {
    Draw draw(any_seed());
    const auto path = random_curve(draw);
    const double s = draw.between(-2.0, 2.0) * path->length(), h = 1e-5;
    const PathPoint here = path->at(s), before = path->at(s - h), after = path->at(s + h);
    const double bend = path->largest_curvature();
    const double dx = (after.pose.x - before.pose.x) / (2.0 * h), dy = (after.pose.y - before.pose.y) / (2.0 * h);
    // Truncation: the curvature squared, and its rate (at a spline's knot: its jump), times h^2.
    const double rate =
        1.0 + std::abs(before.curvature_rate) + std::abs(here.curvature_rate) + std::abs(after.curvature_rate);
    const double tolerance = 5e-9 + h * h * (bend * bend + rate);
    RC_ASSERT(std::abs(std::hypot(dx, dy) - 1.0) <= tolerance);
    RC_ASSERT(std::abs(wrap_angle(std::atan2(dy, dx) - here.pose.theta)) <= tolerance);
    RC_ASSERT(std::abs(here.curvature) <= bend);
    const double turn = wrap_angle(after.pose.theta - before.pose.theta) / (2.0 * h);
    RC_ASSERT(std::abs(turn - here.curvature) <= 1e-7 * (1.0 + bend) + h * rate);
    if (std::abs(after.curvature_rate - before.curvature_rate) < 1e-2 * rate)  // no knot between
      RC_ASSERT(std::abs((after.curvature - before.curvature) / (2.0 * h) - here.curvature_rate) <= 1e-2 * rate);
  });
}

TEST(Curve, IsClosedAndHasNoGap) {
  Draw draw(7);
  for (int k = 0; k < 30; ++k) {
    const auto path = random_curve(draw);
    const double step = path->length() / 3000.0;
    PathPoint last = path->at(0.0);
    for (int i = 1; i <= 3100; ++i) {
      const PathPoint here = path->at(i * step);
      ASSERT_LE(core::distance(last.pose, here.pose), step * (1.0 + 1e-9));
      ASSERT_LE(std::abs(wrap_angle(here.pose.theta - last.pose.theta)), step * path->largest_curvature() + 1e-12);
      ASSERT_LE(std::abs(here.curvature - last.curvature), 0.2 * path->largest_curvature()) << "continuous";
      last = here;
    }
    EXPECT_LE(core::distance(path->at(path->length()).pose, path->at(0.0).pose), 1e-12);
  }
}

TEST(Ellipse, IsOneAndACircleWhereBothAxesAreAlike) {
  const core::Ellipse circle(0.8, 0.8);
  EXPECT_NEAR(circle.length(), 0.8 * pi, 1e-12);
  const core::Circle same(0.4);
  for (double s = 0.0; s < 3.0; s += 0.1) {
    EXPECT_LE(core::distance(circle.at(s).pose, same.at(s).pose), 1e-12);
    EXPECT_NEAR(circle.at(s).curvature, 2.5, 1e-12);
    EXPECT_NEAR(circle.at(s).curvature_rate, 0.0, 1e-10);
  }
  const core::Ellipse ellipse(1.2, 0.8);
  EXPECT_NEAR(ellipse.largest_curvature(), 0.6 / 0.16, 1e-3);  // a / b^2, at the ends
  EXPECT_NEAR(ellipse.length(), 3.17309, 1e-5);                // 4 a E(sqrt(1 - b^2 / a^2))
}

TEST(Lemniscate, BendsToBothSidesAndCrossesItselfInTheMiddle) {
  const core::Lemniscate eight(1.4, 0.8);
  EXPECT_NEAR(eight.at(0.0).pose.x, 0.7, 1e-15);
  EXPECT_NEAR(eight.at(0.0).pose.theta, 0.5 * pi, 1e-15);
  const double quarter = 0.25 * eight.length();
  EXPECT_NEAR(std::hypot(eight.at(quarter).pose.x, eight.at(quarter).pose.y), 0.0, 1e-12);
  EXPECT_NEAR(eight.at(quarter).curvature, 0.0, 1e-12);
  EXPECT_GT(eight.at(0.0).curvature, 0.0);
  EXPECT_LT(eight.at(2.0 * quarter).curvature, 0.0);
}

TEST(Spline, GoesThroughItsPoints) {
  Draw draw(11);
  for (int k = 0; k < 20; ++k) {
    const auto points = random_points(draw);
    const core::Spline spline(points);
    for (const Point& p : points) {
      double nearest = 1.0;
      for (int i = 0; i < 20000; ++i) {
        const auto pose = spline.at(spline.length() * i / 20000).pose;
        nearest = std::min(nearest, std::hypot(pose.x - p.x, pose.y - p.y));
      }
      EXPECT_LE(nearest, spline.length() / 30000);
    }
  }
}

TEST(Polyline, IsStraightsAndArcsWithoutAGap) {
  Draw draw(13);
  for (int k = 0; k < 200; ++k) {
    const auto points = random_points(draw);
    const double radius = draw.between(0.05, 1.0) * core::Polyline::largest_radius(points);
    const core::Polyline path(points, radius);
    const double step = path.length() / 4000.0;
    PathPoint last = path.at(0.0);
    for (int i = 1; i <= 4100; ++i) {
      const PathPoint here = path.at(i * step);
      const double chord = core::distance(last.pose, here.pose);
      ASSERT_LE(chord, step * (1.0 + 1e-9));
      ASSERT_GE(chord, step * (1.0 - std::pow(step / radius, 2) / 20.0) - 1e-12);
      ASSERT_LE(std::abs(wrap_angle(here.pose.theta - last.pose.theta)), step / radius + 1e-12);
      ASSERT_TRUE(here.curvature == 0.0 || std::abs(std::abs(here.curvature) * radius - 1.0) < 1e-12);
      last = here;
    }
  }
}

TEST(Polyline, OfFourCornersIsTheRoundedRectangle) {
  const core::RoundedRectangle rectangle(1.3, 0.9, 0.119);
  const core::Polyline line({{-0.65, -0.45}, {0.65, -0.45}, {0.65, 0.45}, {-0.65, 0.45}}, 0.119);
  EXPECT_NEAR(line.length(), rectangle.length(), 1e-12);
  for (double s = 0.0; s < 4.2; s += 0.01) EXPECT_LE(core::distance(line.at(s).pose, rectangle.at(s).pose), 1e-12) << s;
  EXPECT_NEAR(core::Polyline::largest_radius({{-0.65, -0.45}, {0.65, -0.45}, {0.65, 0.45}, {-0.65, 0.45}}), 0.45,
              1e-12);
  EXPECT_EQ(core::Polyline::largest_radius({{-1, 0}, {1, 0}, {0, 0}}), 0.0);
}

}  // namespace
}  // namespace skein::test
