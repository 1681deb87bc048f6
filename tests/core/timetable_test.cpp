// Trajectories through places at given times: where they should be when, smooth, at rest at both ends.
#include "core/reference/timetable.h"

#include <cmath>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::ReferencePoint;
using core::TimedPoint;
using core::wrap_angle;

TEST(Timetable, IsWhereItShouldBeAndMovesByThreeThere) {
  holds("the places in time, (3) by differences, continuous accelerations, rest at the ends", [] {
    Draw draw(any_seed());
    std::vector<TimedPoint> points;
    const int n = static_cast<int>(draw.whole(2, 8));
    double t = draw.between(0.0, 5.0);
    for (int k = 0; k < n; ++k, t += draw.between(2.0, 4.0))
      points.push_back({t, {0.3 * k + draw.between(-0.05, 0.05), draw.between(-0.2, 0.2)}});
    const core::Timetable table(points);
    for (const TimedPoint& point : points) {
      const core::Pose pose = table.at(point.t).pose;
      RC_ASSERT(std::hypot(pose.x - point.place.x, pose.y - point.place.y) <= 1e-12);
    }
    RC_ASSERT(table.at(points.front().t).twist == core::Twist{});
    RC_ASSERT(table.at(points.back().t + 1.0).twist == core::Twist{});
    // The headings at rest are those of setting off and of coming to rest.
    for (const auto& [at, near] :
         {std::pair{points.front().t, points.front().t + 1e-4}, std::pair{points.back().t, points.back().t - 1e-4}})
      RC_ASSERT(std::abs(wrap_angle(table.at(at).pose.theta - table.at(near).pose.theta)) <= 1e-2);

    const double h = 1e-5, s = draw.between(points.front().t + 0.1, points.back().t - 0.1);
    const ReferencePoint a = table.at(s - h), b = table.at(s), c = table.at(s + h);
    if (b.twist.v < 0.01) return;
    const double dx = (c.pose.x - a.pose.x) / (2.0 * h), dy = (c.pose.y - a.pose.y) / (2.0 * h);
    RC_ASSERT(std::abs(b.twist.v - std::hypot(dx, dy)) <= 1e-8);
    RC_ASSERT(std::abs(wrap_angle(b.pose.theta - std::atan2(dy, dx))) <= 1e-4);
    const double omega = wrap_angle(c.pose.theta - a.pose.theta) / (2.0 * h);
    RC_ASSERT(std::abs(b.twist.omega - omega) <= 1e-3 * (1.0 + std::abs(omega)));
    RC_ASSERT(std::abs(c.twist.v - 2.0 * b.twist.v + a.twist.v) / h <= 1e-2);  // the acceleration does not jump
    const core::ReferenceDemand demand = table.demand(11.0);
    RC_ASSERT(b.twist.v <= demand.v * 1.05);
  });
}

}  // namespace
}  // namespace skein::test
