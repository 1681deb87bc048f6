// From any start the errors converge in closed loop, at the rate and inside the limits of a real run.
#include <algorithm>
#include <memory>

#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"
#include "core/reference/platoon.h"
#include "core/safety/limits.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

TEST(Convergence, FromAnyStartAtTwentyFiveHertzInsideTheLimits) {
  const auto path = std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119);
  constexpr double dt = 0.04;
  // With a start a metre off and six robots, of which each has 1 cm/s left for its own tracking, a minute is the rule;
  // ten are patience.
  constexpr int patience = 600 * 25, stay = 5 * 25;
  constexpr double arrived = 5e-3;  // [m]

  holds("from any start the errors converge, and stay small", [&] {
    Draw draw(any_seed());
    const auto n = static_cast<std::size_t>(draw.whole(1, 6));
    const core::Platoon platoon(path, n, 0.12, 0.05, draw.between(0.0, 4.0));
    core::Gains gains = core::paper_gains(n);
    gains.coupling = draw.chance(0.5) ? core::Coupling::paper : core::Coupling::bounded;
    gains.saturation = draw.chance(0.5) ? core::Saturation::tanh : core::Saturation::algebraic;
    core::CommandLimits limits;
    std::vector<core::Pose> poses;
    for (std::size_t i = 0; i < n; ++i) {
      const core::Pose there = platoon.at(i, 0.0).pose;
      const double away = draw.between(0.0, 1.0), direction = draw.angle();
      poses.push_back({there.x + away * std::cos(direction), there.y + away * std::sin(direction), draw.angle()});
    }
    std::vector<core::TrackingError> errors(n);
    std::vector<core::Twist> reference(n), command(n);
    int inside = 0, step = 0;
    for (; step < patience && inside < stay; ++step) {
      double largest = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        const core::ReferencePoint point = platoon.at(i, step * dt);
        reference[i] = point.twist;
        errors[i] = core::tracking_error(point.pose, poses[i]);
        largest = std::max(largest, std::hypot(errors[i].x, errors[i].y));
      }
      inside = largest < arrived ? inside + 1 : 0;
      core::use_all_authority(gains, reference);
      core::coordination_law(gains, errors, reference, command);
      for (std::size_t i = 0; i < n; ++i) {
        const core::Twist limited = limits.limit(command[i]);
        RC_ASSERT(std::abs(limited.v) <= limits.v_max && std::abs(limited.omega) <= limits.omega_max);
        poses[i] = core::advance(poses[i], limited, dt);
      }
    }
    RC_ASSERT(inside == stay);
  });
}

}  // namespace
}  // namespace skein::test
