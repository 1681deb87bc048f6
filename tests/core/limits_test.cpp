// The box (14) and the wheels' diamond: always obeyed, signs kept, the turning rate served first.
#include "core/safety/limits.h"

#include <algorithm>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::CommandLimits;
using core::Twist;

CommandLimits random_limits(Draw& draw) {
  CommandLimits limits;
  limits.v_max = draw.between(0.01, 0.3);
  limits.omega_max = draw.decades(-1.0, 1.5);  // up to 31 rad/s: then the wheels are what limits the turn
  limits.drive.max_step_rate = draw.between(200.0, 1200.0);
  limits.drive.track = draw.between(0.03, 0.2);
  return limits;
}

TEST(CommandLimits, KeepBoxAndDiamondAndSigns) {
  holds("a limited twist is inside box and diamond, with the signs it had", [] {
    Draw draw(any_seed());
    const CommandLimits limits = random_limits(draw);
    const Twist wanted{draw.sign() * draw.decades(-3.0, 2.0), draw.sign() * draw.decades(-3.0, 3.0)};
    const Twist limited = limits.limit(wanted);
    RC_ASSERT(std::abs(limited.v) <= limits.v_max);
    RC_ASSERT(std::abs(limited.omega) <= limits.omega_max);
    const double wheel = limits.drive.max_wheel_speed();
    const double rounding = 1e-15;  // a few roundings of numbers below 1
    RC_ASSERT(std::abs(limited.v) + 0.5 * limits.drive.track * std::abs(limited.omega) <= wheel + rounding);
    const auto wheels = limits.drive.wheels(limited);
    RC_ASSERT(std::max(std::abs(wheels.left), std::abs(wheels.right)) <= limits.drive.max_step_rate + 1e-9);
    RC_ASSERT(limited.v * wanted.v >= 0.0);
    RC_ASSERT(limited.omega * wanted.omega >= 0.0);
    // Never more than was asked for; a second pass changes nothing.
    RC_ASSERT(std::abs(limited.v) <= std::abs(wanted.v) && std::abs(limited.omega) <= std::abs(wanted.omega));
    RC_ASSERT(limits.limit(limited) == limited);
  });
}

TEST(CommandLimits, ServeTheTurningRateFirst) {
  holds("omega is cut by nothing but its own limits; v gets all that is left", [] {
    Draw draw(any_seed());
    const CommandLimits limits = random_limits(draw);
    const Twist wanted{draw.between(-1.0, 1.0), draw.between(-40.0, 40.0)};
    const Twist limited = limits.limit(wanted);
    const double wheel = limits.drive.max_wheel_speed(), half = 0.5 * limits.drive.track;
    const double most_omega = std::min(limits.omega_max, wheel / half);
    RC_ASSERT(std::abs(std::abs(limited.omega) - std::min(std::abs(wanted.omega), most_omega)) <= 1e-14 * most_omega);
    const double most_v = std::min(limits.v_max, wheel - half * std::abs(limited.omega));
    RC_ASSERT(std::abs(std::abs(limited.v) - std::min(std::abs(wanted.v), std::max(0.0, most_v))) <= 1e-15);
  });
}

TEST(CommandLimits, LeaveATwistInsideThemAlone) {
  const CommandLimits epuck;
  for (const Twist twist : {Twist{0.05, 0.42}, {-0.08, -1.7}, {0.1, 1.0}, {0.0, 0.0}, {0.0, -1.7}})
    EXPECT_EQ(epuck.limit(twist), twist);
}

TEST(CommandLimits, OfTheEpuckBiteInTheCornerOfTheBox) {
  // |v| = v_max and |omega| = omega_max together ask 0.145 m/s of a wheel that gives 0.1288.
  const CommandLimits epuck;
  const Twist limited = epuck.limit({0.1, -1.7});
  EXPECT_EQ(limited.omega, -1.7);
  EXPECT_NEAR(limited.v, 0.1288 - 1.7 * 0.0265, 5e-5);
  EXPECT_EQ(epuck.limit({-0.1, -1.7}).v, -limited.v);
}

}  // namespace
}  // namespace skein::test
