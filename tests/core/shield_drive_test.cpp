// The shield over time: law, limits and shield at 25 Hz, robots that want through one another.
#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"
#include "core/safety/limits.h"
#include "core/safety/shield.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::CommandLimits;
using core::Pose;
using core::Shield;
using core::ShieldParameters;
using core::Twist;

const ShieldParameters parameters;
const CommandLimits limits;

/// The heading that the shield is told: the one at the start of the drive_tick, or that of the chord which the robot
/// drives within it, half the drive_tick's turn further. With the latter its conditions are exact for the sampled
/// robot.
enum class Heading { at_start, of_chord };

/// One drive_tick: commands through limits and shield, then exact arcs. Returns the least distance of any two
/// afterwards.
double drive_tick(Shield& shield, std::vector<Pose>& poses, std::vector<Twist>& commands,
                  Heading heading = Heading::at_start) {
  const std::size_t n = poses.size();
  std::vector<double> v_limit(n);
  for (std::size_t i = 0; i < n; ++i) {
    commands[i] = limits.limit(commands[i]);
    v_limit[i] = limits.v_limit(commands[i].omega);
  }
  std::vector<Pose> told = poses;
  if (heading == Heading::of_chord)
    for (std::size_t i = 0; i < n; ++i) told[i].theta += 0.5 * commands[i].omega * dt;
  std::array<bool, 16> touched{};
  shield.apply(parameters, {.poses = told, .v_limit = v_limit}, commands, {touched.data(), n});
  double least = 1e9;
  for (std::size_t i = 0; i < n; ++i) {
    poses[i] = core::advance(poses[i], commands[i], dt);
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, core::distance(poses[i], poses[j]));
  }
  return least;
}

/// Two robots straight at each other at v_max, offset to the side by up to D, from anywhere; each may turn as well.
struct HeadOn {
  std::vector<Pose> poses;
  std::array<double, 2> omega{};
};

HeadOn random_head_on(Draw& draw, bool turning) {
  const double direction = draw.angle(), offset = draw.between(-1.0, 1.0) * parameters.distance;
  const double start = draw.between(0.12, 0.4), along_x = std::cos(direction), along_y = std::sin(direction);
  HeadOn two;
  two.poses = {
      {0.0, 0.0, direction},
      {start * along_x - offset * along_y, start * along_y + offset * along_x, core::wrap_angle(direction + core::pi)}};
  if (turning) two.omega = {draw.between(-1.7, 1.7), draw.between(-1.7, 1.7)};
  return two;
}

double least_distance(HeadOn two, Heading heading) {
  Shield shield(2, 0);
  double least = 1e9;
  for (int k = 0; k < 250; ++k) {  // 10 s
    std::vector<Twist> commands{{0.1, two.omega[0]}, {0.1, two.omega[1]}};
    least = std::min(least, drive_tick(shield, two.poses, commands, heading));
  }
  return least;
}

TEST(ShieldDrive, TwoHeadOnAtFullSpeedStopInTime) {
  holds("driving straight, they never come within D", [] {
    Draw draw(any_seed());
    RC_ASSERT(least_distance(random_head_on(draw, false), Heading::at_start) >= parameters.distance - 1e-6);
  });
}

TEST(ShieldDrive, TwoHeadOnThatTurnLoseLittle) {
  // Each time a robot turns through the direction across the line between the two, the drive_tick in which it does so
  // may close v omega dt^2 / 2 = 0.14 mm that its heading at the start did not tell; 10 s of circling add a few of
  // these.
  holds("turning all the time, they never come within D - 3 mm", [] {
    Draw draw(any_seed());
    const double least = least_distance(random_head_on(draw, true), Heading::at_start);
    RC_LOG() << "least distance " << least << " m\n";
    RC_ASSERT(least >= parameters.distance - 0.003);
  });
}

TEST(ShieldDrive, TwoHeadOnThatTurnLoseNothingWithTheHeadingOfTheChord) {
  holds("told the heading half a drive_tick's turn ahead, they never come within D", [] {
    Draw draw(any_seed());
    const double least = least_distance(random_head_on(draw, true), Heading::of_chord);
    RC_LOG() << "least distance " << least << " m\n";
    RC_ASSERT(least >= parameters.distance - 1e-6);
  });
}

TEST(ShieldDrive, ExactlyHeadOnTheyStopAtD) {
  std::vector<Pose> poses{{-0.2, 0.0, 0.0}, {0.2, 0.0, core::pi}};
  Shield shield(2, 0);
  for (int k = 0; k < 1000; ++k) {
    std::vector<Twist> commands{{0.1, 0.0}, {0.1, 0.0}};
    drive_tick(shield, poses, commands);
    ASSERT_GE(core::distance(poses[0], poses[1]), parameters.distance - 1e-9);
  }
  EXPECT_NEAR(core::distance(poses[0], poses[1]), parameters.distance, 1e-6) << "and no sooner than they must";
}

// Proposition 4 of docs/theory.md, and what it does not say.

/// Two robots whose commands act some ticks late. The shield is told the poses at which they are decided, or, with
/// `predicted`, those at which they act; each pose is off by up to `off` along x.
struct LateTwo {
  std::vector<Pose> poses;
  ShieldParameters shield{};
  std::size_t late = 0;  // [ticks]
  bool predicted = false;
  double off = 0.0;  // of each pose, towards the other robot or away from it [m]

  /// The least distance over some ticks in which wish(k, i) is what robot i wants, and error(k) in [-1, 1] the share
  /// of `off`.
  template <typename Wish, typename Error>
  double least(int ticks, Wish&& wish, Error&& error) {
    Shield keeps(2, 0);
    std::deque<std::array<Twist, 2>> under_way(late);
    double least = 1e9;
    for (int k = 0; k < ticks; ++k) {
      std::array<Twist, 2> commands{limits.limit(wish(k, 0)), limits.limit(wish(k, 1))};
      std::vector<Pose> told = poses;
      for (const auto& command : under_way)
        for (std::size_t i = 0; i < 2 && predicted; ++i) told[i] = core::advance(told[i], command[i], dt);
      for (std::size_t i = 0; i < 2; ++i) told[i].theta += 0.5 * commands[i].omega * dt;
      told[0].x += off * error(k), told[1].x -= off * error(k);
      const std::array<double, 2> v_limit{limits.v_limit(commands[0].omega), limits.v_limit(commands[1].omega)};
      std::array<bool, 2> touched{};
      keeps.apply(shield, {.poses = told, .v_limit = v_limit}, commands, touched);
      under_way.push_back(commands);
      for (std::size_t i = 0; i < 2; ++i) poses[i] = core::advance(poses[i], under_way.front()[i], dt);
      under_way.pop_front();
      least = std::min(least, core::distance(poses[0], poses[1]));
    }
    return least;
  }
};

std::vector<Pose> head_on(double apart) {
  return {{-0.5 * apart, 0.0, 0.0}, {0.5 * apart, 0.0, core::pi}};
}

TEST(ShieldDrive, LateCommandsOnOneLineLoseNoMoreThanIsDrivenMeanwhile) {
  holds("d >= D - (e_i + e_j) - 2 v_max tau", [] {
    Draw draw(any_seed());
    LateTwo two{head_on(draw.between(0.08, 0.2))};
    two.shield.gamma = draw.between(1.0, 1.0 / dt);
    two.late = static_cast<std::size_t>(any_of(0, 8));
    two.off = draw.between(0.0, 0.003);
    two.poses[1].x += 2.0 * two.off;
    const double least = two.least(
        250,
        [&](int, int) {
          return Twist{draw.chance(0.9) ? 0.1 : draw.between(-0.1, 0.1), 0.0};
        },
        [&](int) { return draw.chance(0.5) ? draw.sign() : draw.between(-1.0, 1.0); });
    const double tau = static_cast<double>(two.late) * dt;
    RC_ASSERT(least >= two.shield.distance - 2.0 * two.off - 2.0 * 0.1 * tau - 1e-9);
  });
}

TEST(ShieldDrive, LateCommandsOnOneLineLoseExactlyThat) {
  // The fastest shield, and the gap at which it still allows full speed: nothing has moved when the last command to
  // close it is given.
  for (std::size_t late = 0; late <= 8; ++late)
    for (const double off : {0.0, 0.002}) {
      LateTwo two{head_on(0.078 + 2.0 * 0.1 * dt - 2.0 * off)};
      two.shield.gamma = 1.0 / dt;
      two.late = late;
      two.off = off;
      const double least = two.least(
          50,
          [](int, int) {
            return Twist{0.1, 0.0};
          },
          [](int) { return -1.0; });
      const double bound = two.shield.distance - 2.0 * off - 2.0 * 0.1 * static_cast<double>(late) * dt;
      EXPECT_GE(least, bound - 1e-9) << late << ' ' << off;
      EXPECT_LT(least, bound + 1e-4) << late << ' ' << off;
    }
}

/// Beside each other, at D, wanting to and fro and a little nearer: the shield lets them drive along the circle round
/// the place at which it was told the other.
std::vector<Pose> beside_each_other() {
  return {{0.0, 0.0, 0.25 * core::pi}, {0.078, 0.0, 0.75 * core::pi}};
}
Twist to_and_fro(int k, int i) {
  return {(k + i) % 2 == 0 ? 0.1 : -0.08, 0.0};
}

TEST(ShieldDrive, LateCommandsInThePlaneLoseEverMore) {
  LateTwo two{beside_each_other()};
  two.late = 1;
  const double least = two.least(100, to_and_fro, [](int) { return 0.0; });
  EXPECT_LT(least, two.shield.distance - 2.0 * 0.1 * (dt + dt)) << "no bound by v_max tau holds for all time";
}

TEST(ShieldDrive, LateCommandsLoseNothingWherePosesArePredicted) {
  LateTwo two{beside_each_other()};
  two.late = 1;
  two.predicted = true;
  EXPECT_GE(two.least(1000, to_and_fro, [](int) { return 0.0; }), two.shield.distance - 1e-6);
  holds("predicted to when the command acts, they never come within D", [] {
    Draw draw(any_seed());
    LateTwo turning{random_head_on(draw, false).poses};
    turning.late = static_cast<std::size_t>(any_of(0, 8));
    turning.predicted = true;
    std::array<Twist, 2> wish{};
    const double least = turning.least(
        250,
        [&](int k, int i) {
          Twist& own = wish[static_cast<std::size_t>(i)];
          if (k % 10 == 0) own = {draw.sign() * 0.1, draw.between(-1.7, 1.7)};
          return own;
        },
        [](int) { return 0.0; });
    RC_ASSERT(least >= turning.shield.distance - 1e-5);
  });
}

// Proposition 5 of docs/theory.md, from both sides.

/// How fast the gap of two may close at most whose speeds add up to `speeds`, where the shield allows `allowed` and
/// their directions are off by up to `angle`.
double fastest_closing(double allowed, double speeds, double angle) {
  if (!(speeds > 0.0)) return 0.0;
  return speeds * std::cos(std::max(0.0, std::acos(std::min(1.0, allowed / speeds)) - angle));
}

/// Where two robots are, and where the shield is told that they are.
struct Misjudged {
  std::vector<Pose> poses, told;
  ShieldParameters keeps{};

  double allowed() const { return keeps.gamma * std::max(0.0, core::distance(told[0], told[1]) - keeps.distance); }
  /// By the shield; changes `commands`. [m/s]
  double closing(std::vector<Twist>& commands) const {
    const std::array<double, 2> v_limit{0.1, 0.1};
    std::array<bool, 2> touched{};
    Shield shield(2, 0);
    shield.apply(keeps, {.poses = told, .v_limit = v_limit}, commands, touched);
    const double n_x = poses[0].x - poses[1].x, n_y = poses[0].y - poses[1].y;
    const auto along = [&](std::size_t i) {
      return commands[i].v * (n_x * std::cos(poses[i].theta) + n_y * std::sin(poses[i].theta));
    };
    return (along(1) - along(0)) / std::hypot(n_x, n_y);
  }
};

TEST(ShieldDrive, WrongPosesLetTheGapShrinkNoFasterThanTheirAngles) {
  holds("closing <= V cos(arccos(g / V) - phi - asin(E / d))", [] {
    Draw draw(any_seed());
    const double apart = draw.between(0.070, 0.1), off = draw.between(0.0, 0.01), turned = draw.between(0.0, 0.3);
    Misjudged two{{{0.0, 0.0, draw.angle()}, {apart, 0.0, draw.angle()}}, {}};
    two.told = two.poses;
    for (Pose& pose : two.told) {
      const double direction = draw.angle(), share = draw.chance(0.5) ? 1.0 : draw.between(0.0, 1.0);
      pose.x += share * off * std::cos(direction), pose.y += share * off * std::sin(direction);
      pose.theta += turned * (draw.chance(0.5) ? draw.sign() : draw.between(-1.0, 1.0));
    }
    std::vector<Twist> commands{{draw.between(-0.1, 0.1), 0.0}, {draw.between(-0.1, 0.1), 0.0}};
    const double closing = two.closing(commands), speeds = std::abs(commands[0].v) + std::abs(commands[1].v);
    RC_ASSERT(closing <= fastest_closing(two.allowed(), speeds, turned + std::asin(2.0 * off / apart)) + 1e-8);
  });
}

/// The robot at the origin and one to its right are told `measured` from each other. In truth the second is 2 `off` to
/// the side, and both are turned by `turned`, so that both errors of direction add up. With 0.1 m/s each they close in
/// at `closing` [m/s] as told, or more slowly where they drive straight at each other in truth.
Misjudged misjudged(double measured, double off, double turned, double closing) {
  const double aside = std::max(std::acos(std::min(1.0, closing / 0.2)), turned + std::atan(2.0 * off / measured));
  Misjudged two;
  two.told = {{0.0, 0.0, aside}, {measured, 0.0, core::wrap_angle(aside + core::pi)}};
  two.poses = {{0.0, -off, aside - turned}, {measured, off, core::wrap_angle(aside + core::pi - turned)}};
  return two;
}

TEST(ShieldDrive, WrongPosesLetTheGapShrinkExactlyThatFast) {
  for (const double measured : {0.072, 0.078, 0.083, 0.1, 0.2})
    for (const double off : {0.0, 0.001, 0.004})
      for (const double turned : {0.0, 0.05, 0.3})
        for (const double gamma : {4.0, 1.0 / dt}) {
          const double allowed = gamma * std::max(0.0, measured - ShieldParameters{}.distance);
          Misjudged two = misjudged(measured, off, turned, allowed);
          two.keeps.gamma = gamma;
          const double angle = turned + std::asin(2.0 * off / core::distance(two.poses[0], two.poses[1]));
          std::vector<Twist> commands{{0.1, 0.0}, {0.1, 0.0}};
          const double closing = two.closing(commands), bound = fastest_closing(allowed, 0.2, angle);
          EXPECT_LE(closing, bound + 1e-8) << measured << ' ' << off << ' ' << turned << ' ' << gamma;
          EXPECT_GT(closing, bound - 1e-6) << measured << ' ' << off << ' ' << turned << ' ' << gamma;
        }
}

/// Two robots that drive along the circle round the middle between them, as they are told, and are told headings that
/// are off by `turned`. Returns when their bodies touch. [s]
double touch_after(double turned) {
  Misjudged two{{{0.0, 0.0, 0.0}, {0.078, 0.0, 0.0}}, {}};
  double t = 0.0;
  for (double apart = 0.078; apart >= 0.07 && t < 60.0; t += dt) {
    const double to_other = std::atan2(two.poses[1].y - two.poses[0].y, two.poses[1].x - two.poses[0].x);
    for (std::size_t i = 0; i < 2; ++i)
      two.poses[i].theta = to_other + (i == 0 ? 0.0 : core::pi) + 0.5 * core::pi - turned;
    two.told = two.poses;
    for (Pose& pose : two.told) pose.theta += turned;
    const double v = 0.5 * apart * std::sin(turned) / dt;
    std::vector<Twist> commands{{v, 0.0}, {v, 0.0}};
    two.closing(commands);
    for (std::size_t i = 0; i < 2; ++i) two.poses[i] = core::advance(two.poses[i], commands[i], dt);
    apart = core::distance(two.poses[0], two.poses[1]);
  }
  return t;
}

TEST(ShieldDrive, HeadingErrorsOfOneSignUseUpAnyMargin) {
  // Slowly enough, a tick leaves cos(phi) of the distance.
  for (const double turned : {0.02, 0.05})
    EXPECT_NEAR(touch_after(turned), dt * std::log(0.070 / 0.078) / std::log(std::cos(turned)), dt) << turned;
  EXPECT_NEAR(touch_after(0.05), 3.5, dt);
  EXPECT_GE(touch_after(0.0), 60.0) << "control";
}

/// Eight robots in a pen, each driven by a will of its own that changes every second. Returns the least distance.
double erratic_crowd(std::uint64_t seed, Heading heading) {
  Draw draw(seed);
  std::vector<Pose> poses;
  for (int i = 0; i < 8; ++i) poses.push_back({0.12 * (i % 3), 0.12 * (i / 3), draw.angle()});
  Shield shield(8, 0);
  std::vector<Twist> wish(8);
  double least = 1e9;
  for (int k = 0; k < 1500; ++k) {
    if (k % 25 == 0)
      for (Twist& twist : wish) twist = {draw.sign() * 0.1, draw.between(-1.7, 1.7)};
    std::vector<Twist> commands = wish;
    for (std::size_t i = 0; i < 8; ++i)  // the pen: outside, turn towards the middle
      if (std::hypot(poses[i].x - 0.12, poses[i].y - 0.12) > 0.3) {
        const double home = std::atan2(0.12 - poses[i].y, 0.12 - poses[i].x);
        commands[i] = {0.1, 4.0 * core::wrap_angle(home - poses[i].theta)};
      }
    least = std::min(least, drive_tick(shield, poses, commands, heading));
  }
  return least;
}

TEST(ShieldDrive, ManyErraticRobotsNeverTouch) {
  // Bodies touch at 70 mm.
  double least = 1e9, least_by_chord = 1e9;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    least = std::min(least, erratic_crowd(seed, Heading::at_start));
    least_by_chord = std::min(least_by_chord, erratic_crowd(seed, Heading::of_chord));
  }
  EXPECT_GE(least, parameters.distance - 0.003);
  EXPECT_LE(least, parameters.distance + 0.002) << "they did come close";
  EXPECT_GE(least_by_chord, parameters.distance - 1e-6);
}

TEST(ShieldDrive, ARobotThatIsTooNearIsFreeToLeave) {
  std::vector<Pose> poses{{0.0, 0.0, 0.0}, {0.072, 0.0, core::pi}};  // nose to nose, 6 mm too near
  Shield shield(2, 0);
  std::vector<Twist> commands{{-0.1, 0.0}, {0.0, 0.0}};
  drive_tick(shield, poses, commands);
  EXPECT_EQ(commands[0].v, -0.1);
  EXPECT_NEAR(core::distance(poses[0], poses[1]), 0.076, 1e-12);
}

/// Robots driven by a will of their own that changes every second, and turned by hand now and then, never leave the
/// arena: a body that begins inside stays inside, and standing is always allowed.
TEST(ShieldDrive, NobodyLeavesTheArena) {
  ShieldParameters arena;
  arena.half_width = 0.4;
  arena.half_height = 0.3;
  double farthest = -1.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed);
    constexpr std::size_t n = 4;
    std::vector<Pose> poses{{0.3, 0.2, draw.angle()}, {-0.3, 0.2, draw.angle()}, {0.3, -0.2, draw.angle()}, {}};
    std::vector<Twist> wish(n);
    Shield shield(n, 0);
    std::array<bool, n> touched{};
    for (int k = 0; k < 1500; ++k) {
      if (k % 25 == 0)
        for (Twist& twist : wish) twist = {draw.sign() * 0.1, draw.between(-1.7, 1.7)};
      if (k % 40 == 0) poses[static_cast<std::size_t>(k / 40) % n].theta = draw.angle();
      std::vector<Twist> commands = wish;
      std::vector<double> v_limit(n);
      std::vector<Pose> told = poses;
      for (std::size_t i = 0; i < n; ++i) {
        commands[i] = limits.limit(commands[i]);
        v_limit[i] = limits.v_limit(commands[i].omega);
        told[i].theta += 0.5 * commands[i].omega * dt;
      }
      shield.apply(arena, {.poses = told, .v_limit = v_limit}, commands, touched);
      for (std::size_t i = 0; i < n; ++i) {
        poses[i] = core::advance(poses[i], commands[i], dt);
        farthest = std::max({farthest, std::abs(poses[i].x) + core::standard_radius - arena.half_width,
                             std::abs(poses[i].y) + core::standard_radius - arena.half_height});
      }
    }
  }
  EXPECT_LE(farthest, 0.0);
  EXPECT_GE(farthest, -0.0081) << "they did come to the edge, and as near as the shield lets them";
}

TEST(ShieldDrive, ARobotOverTheEdgeComesBackAndNoFartherOut) {
  ShieldParameters arena;
  arena.half_width = 0.4;
  arena.half_height = 0.3;
  const std::vector<Pose> poses{{0.5, 0.0, 0.0}};
  Shield shield(1, 0);
  std::array<bool, 1> touched{};
  std::vector<Twist> out{{0.1, 0.0}}, back{{-0.1, 0.0}};
  const std::vector<double> v_limit{0.1};
  shield.apply(arena, {.poses = poses, .v_limit = v_limit}, out, touched);
  EXPECT_NEAR(out[0].v, 0.0, 1e-9);
  shield.apply(arena, {.poses = poses, .v_limit = v_limit}, back, touched);
  EXPECT_EQ(back[0].v, -0.1);
}

}  // namespace
}  // namespace skein::test
