// The paths: what their arc length, heading and curvature promise, checked along the whole lap.
#include "core/reference/path.h"

#include <cmath>
#include <memory>
#include <vector>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Circle;
using core::Path;
using core::PathPoint;
using core::pi;
using core::RoundedRectangle;
using core::wrap_angle;

TEST(RoundedRectangle, OfTheCaseStudyIs4196MillimetresLong) {
  const RoundedRectangle path(1.3, 0.9, 0.119);
  EXPECT_NEAR(path.length(), 4.196, 5e-4);
  EXPECT_NEAR(path.length(), 2.0 * (1.3 + 0.9) - (8.0 - 2.0 * pi) * 0.119, 1e-14);
  EXPECT_NEAR(path.length() / 0.05, 83.9, 0.05);  // one lap at v_ref
  EXPECT_DOUBLE_EQ(path.largest_curvature(), 1.0 / 0.119);
}

TEST(RoundedRectangle, RunsCounterClockwiseFromTheStartOfTheBottomStraight) {
  const RoundedRectangle path(1.3, 0.9, 0.119);
  const PathPoint start = path.at(0.0);
  EXPECT_NEAR(start.pose.x, -0.65 + 0.119, 1e-15);
  EXPECT_EQ(start.pose.y, -0.45);
  EXPECT_EQ(start.pose.theta, 0.0);
  // The middles of the straights: right, up, left, down.
  const double side = 1.3 - 0.238, height = 0.9 - 0.238, corner = 0.5 * pi * 0.119;
  const auto middle = [&](double s) { return path.at(s).pose; };
  EXPECT_NEAR(middle(0.5 * side).x, 0.0, 1e-15);
  const auto right = middle(side + corner + 0.5 * height);
  EXPECT_NEAR(right.x, 0.65, 1e-15);
  EXPECT_NEAR(right.y, 0.0, 1e-15);
  EXPECT_NEAR(right.theta, 0.5 * pi, 1e-15);
  const auto top = middle(1.5 * side + 2.0 * corner + height);
  EXPECT_NEAR(top.x, 0.0, 1e-15);
  EXPECT_NEAR(top.y, 0.45, 1e-15);
  EXPECT_NEAR(top.theta, pi, 1e-15);
  EXPECT_NEAR(middle(2.0 * side + 3.0 * corner + 1.5 * height).theta, -0.5 * pi, 1e-15);
  // The first corner's middle, on the circle about (0.531, -0.331).
  const auto bend = path.at(side + 0.5 * corner);
  EXPECT_NEAR(bend.pose.x, 0.531 + 0.119 * std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(bend.pose.y, -0.331 - 0.119 * std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(bend.pose.theta, 0.25 * pi, 1e-15);
  EXPECT_NEAR(bend.curvature, 1.0 / 0.119, 1e-12);
}

std::unique_ptr<Path> random_path(Draw& draw) {
  if (draw.chance(0.3)) return std::make_unique<Circle>(draw.between(0.05, 2.0));
  const double width = draw.between(0.2, 3.0), height = draw.between(0.2, 3.0);
  const double half = 0.5 * std::min(width, height);
  // In one case of ten the shorter straights shrink to nothing: a stadium.
  return std::make_unique<RoundedRectangle>(width, height, draw.chance(0.1) ? half : draw.between(0.1, 1.0) * half);
}

TEST(Path, HasUnitSpeedItsHeadingIsTheTangentAndItsCurvatureTheTurn) {
  holds("|dp/ds| = 1, theta the tangent, curvature = dtheta/ds", [] {
    Draw draw(any_seed());
    const auto path = random_path(draw);
    const double s = draw.between(-3.0, 3.0) * path->length(), h = 1e-5;
    const PathPoint here = path->at(s), before = path->at(s - h), after = path->at(s + h);
    // Where a joint lies between, a central difference is off by h times the curvature at most.
    const double joint = here.curvature == before.curvature && here.curvature == after.curvature ? 0.0 : 1.0;
    const double bend = path->largest_curvature();
    const double dx = (after.pose.x - before.pose.x) / (2.0 * h), dy = (after.pose.y - before.pose.y) / (2.0 * h);
    const double rounding = 2e-9;  // s, up to 40 m, is known to 7e-15 m, the positions to 1e-15 m; over 2e-5 m
    RC_ASSERT(std::abs(std::hypot(dx, dy) - 1.0) <= rounding + (joint + bend * h) * bend * h);
    RC_ASSERT(std::abs(wrap_angle(std::atan2(dy, dx) - here.pose.theta)) <= rounding + (joint + bend * h) * bend * h);
    RC_ASSERT(here.pose.theta > -pi && here.pose.theta <= pi);
    if (joint == 0.0) {
      const double turn = wrap_angle(after.pose.theta - before.pose.theta) / (2.0 * h);
      RC_ASSERT(std::abs(turn - here.curvature) <= 2e-9 * (1.0 + bend));
    }
    RC_ASSERT(std::abs(here.curvature) <= bend);
  });
}

TEST(Path, HasNoGapAnywhereOnTheLap) {
  Draw draw(7);
  for (int k = 0; k < 20; ++k) {
    const auto path = random_path(draw);
    const double step = path->length() / 5000.0;
    PathPoint last = path->at(0.0);
    for (int i = 1; i <= 10000; ++i) {  // two laps
      const PathPoint here = path->at(i * step);
      const double chord = core::distance(last.pose, here.pose);
      ASSERT_LE(chord, step * (1.0 + 1e-9));
      // Two chords' worth of sagitta at most: s = 2R sin(step / 2R), or less where a joint lies inside.
      ASSERT_GE(chord, step * (1.0 - std::pow(step * path->largest_curvature(), 2) / 20.0) - 1e-12);
      ASSERT_LE(std::abs(wrap_angle(here.pose.theta - last.pose.theta)), step * path->largest_curvature() + 1e-12);
      last = here;
    }
  }
}

TEST(Path, WrapsWhateverTheSignAndSizeOfS) {
  holds("at(s + k length) is at(s)", [] {
    Draw draw(any_seed());
    const auto path = random_path(draw);
    const double s = draw.between(0.0, 1.0) * path->length();
    const double turns = draw.whole(-1000, 1000);
    const PathPoint here = path->at(s), there = path->at(s + turns * path->length());
    // s + turns * length carries a rounding of 1000 laps of up to 13 m: 2e-12.
    RC_ASSERT(core::distance(here.pose, there.pose) <= 1e-11);
    RC_ASSERT(std::abs(wrap_angle(here.pose.theta - there.pose.theta)) <= 1e-11 * path->largest_curvature() + 1e-14);
  });
}

TEST(Path, IsContinuousThroughSZero) {
  const RoundedRectangle rectangle(1.3, 0.9, 0.119);
  const Circle circle(0.4);
  for (const Path* path : std::vector<const Path*>{&rectangle, &circle}) {
    const PathPoint zero = path->at(0.0);
    for (double tiny = 1e-3; tiny > 1e-30; tiny /= 10.0)
      for (double s : {-tiny, path->length() - tiny, path->length() + tiny, tiny}) {
        const PathPoint near = path->at(s);
        EXPECT_LE(core::distance(near.pose, zero.pose), tiny + 1e-15) << s;
        EXPECT_LE(std::abs(wrap_angle(near.pose.theta - zero.pose.theta)), tiny / 0.119 + 1e-14) << s;
      }
  }
}

TEST(Circle, StartsOnTheRightAndTurnsLeft) {
  const Circle circle(0.4);
  EXPECT_DOUBLE_EQ(circle.length(), 0.8 * pi);
  const PathPoint start = circle.at(0.0), quarter = circle.at(0.2 * pi);
  EXPECT_DOUBLE_EQ(start.pose.x, 0.4);
  EXPECT_DOUBLE_EQ(start.pose.theta, 0.5 * pi);
  EXPECT_NEAR(quarter.pose.y, 0.4, 1e-15);
  EXPECT_NEAR(quarter.pose.theta, pi, 1e-15);
  EXPECT_DOUBLE_EQ(quarter.curvature, 2.5);
}

}  // namespace
}  // namespace skein::test
