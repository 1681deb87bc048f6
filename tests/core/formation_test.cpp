// Formations about a centre: (3) against differences of the poses, shapes, changes, stops.
#include "core/reference/formation.h"

#include <cmath>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Formation;
using core::Point;
using core::ReferencePoint;
using core::Shape;
using core::ShapeName;
using core::wrap_angle;

Shape random_shape(Draw& draw, std::size_t robots) {
  Shape shape;
  for (std::size_t i = 0; i < robots; ++i) shape.push_back({draw.between(-0.2, 0.2), draw.between(-0.2, 0.2)});
  return shape;
}

/// Three robots on an ellipse whose tightest bend is wider than the shape, with one change of shape from 3 s to 9 s.
Formation random_formation(Draw& draw) {
  auto path = std::make_shared<core::Ellipse>(draw.between(1.2, 2.0), draw.between(1.2, 2.0));
  return {path,
          draw.between(0.1, 0.3),
          draw.between(-1.0, 1.0),
          random_shape(draw, 3),
          {{3.0, 6.0, random_shape(draw, 3)}}};
}

TEST(Formation, HasTheVelocitiesOf3) {
  holds("v_ref and omega_ref are (3), by differences of the poses", [] {
    Draw draw(any_seed());
    const Formation formation = random_formation(draw);
    const auto i = static_cast<std::size_t>(draw.whole(0, 2));
    const double t = draw.between(0.0, 12.0), h = 1e-4;
    const ReferencePoint a = formation.at(i, t - h), b = formation.at(i, t), c = formation.at(i, t + h);
    const double dx = (c.pose.x - a.pose.x) / (2.0 * h), dy = (c.pose.y - a.pose.y) / (2.0 * h);
    const double v = std::hypot(dx, dy);
    if (v < 0.02) return;  // nearly a stop of this robot: differences say nothing of its heading
    RC_ASSERT(std::abs(b.twist.v - v) <= 1e-7);
    std::vector<ReferencePoint> all(3);
    formation.at(t, all);
    RC_ASSERT(all[i] == b);
    RC_ASSERT(std::abs(wrap_angle(b.pose.theta - std::atan2(dy, dx))) <= 1e-5);
    const double omega = wrap_angle(c.pose.theta - a.pose.theta) / (2.0 * h);
    RC_ASSERT(std::abs(b.twist.omega - omega) <= 1e-4 * (1.0 + std::abs(omega)));
  });
}

TEST(Formation, DemandsAtLeastWhatItAsksFor) {
  holds("demand is the most along the course", [] {
    Draw draw(any_seed());
    const Formation formation = random_formation(draw);
    const core::ReferenceDemand demand = formation.demand(11.0);
    for (int k = 0; k < 200; ++k) {
      const auto i = static_cast<std::size_t>(draw.whole(0, 2));
      const ReferencePoint p = formation.at(i, draw.between(0.0, 100.0));
      if (p.twist.v < 0.02) continue;  // where a robot nearly stops omega_ref has a peak that no sampling finds
      RC_ASSERT(p.twist.v <= demand.v);
      RC_ASSERT(std::abs(p.twist.omega) + 11.0 * p.twist.v <= demand.turning);
    }
  });
}

TEST(Formation, IsRigidBetweenItsChanges) {
  Draw draw(5);
  const Formation formation = random_formation(draw);
  const auto distance = [&](double t) { return core::distance(formation.at(0, t).pose, formation.at(1, t).pose); };
  for (double t = 0.0; t <= 3.0; t += 0.1) EXPECT_NEAR(distance(t), distance(0.0), 1e-12);
  for (double t = 9.0; t <= 30.0; t += 0.1) EXPECT_NEAR(distance(t), distance(9.0), 1e-12);
  // No jump in pose or velocity where a change begins or ends.
  for (double t : {3.0, 9.0}) {
    const ReferencePoint a = formation.at(2, t - 1e-6), b = formation.at(2, t + 1e-6);
    EXPECT_LE(core::distance(a.pose, b.pose), 2e-6);
    EXPECT_NEAR(a.twist.v, b.twist.v, 1e-5);
    EXPECT_NEAR(a.twist.omega, b.twist.omega, 1e-4);
  }
}

TEST(Formation, TurnsLikeADoor) {
  const Shape line{{0.0, 0.2}, {0.0, -0.2}};
  const Formation door(std::make_shared<core::Circle>(0.5), 0.05, 0.0, line, {});
  EXPECT_NEAR(door.at(0, 7.0).twist.v, 0.03, 1e-15);  // inside: radius 0.3
  EXPECT_NEAR(door.at(1, 7.0).twist.v, 0.07, 1e-15);
  EXPECT_NEAR(door.at(0, 7.0).twist.omega, 0.1, 1e-15);
  EXPECT_NEAR(door.at(1, 7.0).twist.omega, 0.1, 1e-15);
}

TEST(Formation, KeepsHeadingsThroughAStop) {
  const Shape shape{{0.1, 0.1}, {-0.1, 0.0}};
  const auto path = std::make_shared<core::Circle>(0.5);
  const Formation still(path, 0.0, 0.3, shape, {}), slow(path, 1e-6, 0.3, shape, {});
  for (std::size_t i : {0u, 1u}) {
    EXPECT_EQ(still.at(i, 5.0).twist, core::Twist{});
    EXPECT_NEAR(still.at(i, 0.0).pose.theta, slow.at(i, 0.0).pose.theta, 1e-9);
  }
}

TEST(Shapes, HaveTheirNeighboursASpacingApartAndTheirMiddleInTheCentre) {
  for (const ShapeName name : {ShapeName::line, ShapeName::column, ShapeName::diamond, ShapeName::v, ShapeName::circle})
    for (std::size_t n = 1; n <= 12; ++n) {
      const Shape shape = core::make_shape(name, n, 0.15);
      ASSERT_EQ(shape.size(), n);
      Point sum;
      double nearest = 1.0;
      for (std::size_t i = 0; i < n; ++i) {
        sum.x += shape[i].x, sum.y += shape[i].y;
        for (std::size_t j = i + 1; j < n; ++j)
          nearest = std::min(nearest, std::hypot(shape[i].x - shape[j].x, shape[i].y - shape[j].y));
      }
      EXPECT_NEAR(sum.x, 0.0, 1e-12);
      EXPECT_NEAR(sum.y, 0.0, 1e-12);
      if (n > 1) {
        EXPECT_NEAR(nearest, 0.15, 1e-12) << static_cast<int>(name) << " of " << n;
      }
    }
}

}  // namespace
}  // namespace skein::test
