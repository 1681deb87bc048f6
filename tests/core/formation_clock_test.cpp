// The clock of a formation that waits for one of its robots.
#include "core/planning/formation_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "core/control/gains.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Delay;
using core::FormationClock;
using core::Pose;
using core::ReferencePoint;
using core::Twist;

/// Straight on, two robots beside each other.
class Abreast final : public core::Reference {
 public:
  using core::Reference::at;
  std::size_t robots() const noexcept override { return 2; }
  ReferencePoint at(std::size_t i, double t) const noexcept override {
    return {{0.05 * t, 0.2 * static_cast<double>(i), 0.0}, {0.05, 0.0}};
  }
  core::ReferenceDemand demand(double k_y) const noexcept override { return {0.05, k_y * 0.05}; }
  bool smooth() const noexcept override { return true; }
  std::vector<std::vector<Pose>> lines() const override { return {}; }
};

TEST(Delay, GoesOnFromAnyMomentWithoutAJump) {
  Draw draw(3);
  for (int k = 0; k < 500; ++k) {
    const double hurry = draw.between(0.05, 2.0), slope = draw.between(2.0, 12.0);
    const Delay first({1.0, 0.0, 0.0}, draw.between(0.2, 1.0), draw.between(0.0, 9.0), hurry, slope);
    const double t = draw.between(1.0, first.ends());
    const Delay::Moment now{t, first.at(t), 1.0 - first.rate(t)};
    const bool waits = draw.chance(0.5);
    // Whoever has slowed down is let go, or waits (again).
    if (!waits && now.falls < 0.0) continue;
    const Delay second = waits ? Delay(now, 0.8, 5.0, hurry, slope) : Delay(now, now.falls, 0.0, hurry, slope);
    ASSERT_NEAR(second.at(t), now.behind, 1e-12);
    ASSERT_NEAR(second.rate(t), first.rate(t), 1e-9);
    double before = second.at(t), last = second.rate(t);
    constexpr double step = 1e-2;
    for (double s = t + step; s < second.ends() + 1.0; s += step) {
      // The trapezoid of a rate whose slope changes by 2 slope at most is off by a quarter of slope step^2.
      ASSERT_NEAR(second.at(s) - before, step * (1.0 - 0.5 * (last + second.rate(s))),
                  0.25 * step * step * slope + 1e-9);
      ASSERT_LE(std::abs(second.rate(s) - last), slope * step + 1e-9);
      ASSERT_GE(second.rate(s), -1e-9);
      ASSERT_LE(second.rate(s), 1.0 + hurry + 1e-9);
      before = second.at(s), last = second.rate(s);
    }
    ASSERT_EQ(second.at(second.ends()), 0.0);
    ASSERT_NEAR(second.at(second.ends() - 1e-6), 0.0, 1e-6);
  }
}

TEST(FormationClock, RunsSlowlyWhileSomebodyIsAwayAndCatchesUp) {
  FormationClock clock;
  double t = 0.0, slowest = 1.0, fastest = 1.0, most = 0.0;
  for (; t < 2.0; t += dt) clock.step(t, false, 0.3, 5.0);
  EXPECT_EQ(clock.behind(t), 0.0);
  for (; t < 8.0; t += dt) clock.step(t, true, 0.3, 5.0), slowest = std::min(slowest, clock.rate(t));
  EXPECT_NEAR(slowest, FormationClock::slowly, 1e-9) << "Theorem 1 asks for v_ref other than 0";
  for (; t < 40.0; t += dt) {
    clock.step(t, false, 0.3, 5.0);
    fastest = std::max(fastest, clock.rate(t));
    most = std::max(most, clock.behind(t));
  }
  EXPECT_NEAR(most, 6.0 * (1.0 - FormationClock::slowly), 0.1);
  EXPECT_NEAR(fastest, 1.3, 1e-9);
  EXPECT_EQ(clock.behind(t), 0.0);
  EXPECT_EQ(clock.rate(t), 1.0);
}

TEST(FormationClock, WaitsForNobodyForEver) {
  FormationClock clock;
  for (double t = 0.0; t < 200.0; t += dt) clock.step(t, true, 0.3, 5.0);
  EXPECT_EQ(clock.behind(200.0), 0.0);
}

TEST(FormationClock, DoesNotWaitWhereItCouldNotCatchUp) {
  FormationClock clock;
  for (double t = 0.0; t < 5.0; t += dt) clock.step(t, true, 0.0, 5.0);
  EXPECT_EQ(clock.behind(5.0), 0.0);
}

/// Couplings that grow take the room by which the clock hurries: it does not run faster than the next tick's leave.
TEST(FormationClock, StaysBehindWhereCouplingsLeaveNothingToCatchUpWith) {
  for (const bool waits : {false, true}) {  // while the couplings grow
    FormationClock clock;
    double t = 0.0, room = 0.43;  // of which it takes 0.7
    for (; t < 6.0; t += dt) clock.step(t, true, 0.7 * room, 5.0);
    if (!waits)
      for (; t < 8.0; t += dt) clock.step(t, false, 0.7 * room, 5.0);
    for (; t < 12.0; t += dt) {
      clock.step(t, waits, 0.7 * room, 5.0);
      room = std::max(0.0, room - 0.016);
      ASSERT_LE(clock.rate(t + dt), 1.0 + room + 1e-9) << t;
    }
    for (; t < 14.0; t += dt) clock.step(t, false, 0.0, 5.0);
    const double behind = clock.behind(t);
    EXPECT_GT(behind, 1.0);
    for (; t < 100.0; t += dt) clock.step(t, false, 0.0, 5.0);
    EXPECT_NEAR(clock.behind(t), behind, 1e-6);
    EXPECT_NEAR(clock.rate(t), 1.0, 1e-9);
    for (; t < 140.0; t += dt) clock.step(t, false, 0.3, 5.0);
    EXPECT_EQ(clock.behind(t), 0.0) << "there is room again";
  }
}

/// Nor where the wait ends because it has lasted long enough, while the robot is still away.
TEST(FormationClock, DoesNotHurryAfterItsLongestWaitWhereCouplingsHaveLeftNothing) {
  for (const double slope : {5.0, 50.0}) {
    FormationClock clock;
    double t = 0.0, fastest = 0.0;
    for (; t < 100.0; t += dt) {
      clock.step(t, true, t < 10.0 ? 0.3 : 0.0, slope);
      for (double s = t; s < t + dt; s += 0.1 * dt) fastest = std::max(fastest, clock.rate(s));
    }
    EXPECT_NEAR(fastest, 1.0, 1e-6) << slope;
    EXPECT_NEAR(clock.behind(t), FormationClock::longest_wait * (1.0 - FormationClock::slowly), 0.2);
    for (; t < 200.0; t += dt) clock.step(t, true, 0.3, slope);
    EXPECT_EQ(clock.behind(t), 0.0) << "there is room again";
  }
}

// Proposition 7 of docs/theory.md, from both sides.

/// The most that a clock is ever behind. [s]
double most_behind(double slope) {
  return FormationClock::most_behind + FormationClock::longest_wait * (1.0 - FormationClock::slowly) + 0.64 / slope;
}
/// How long after the beginning of its last wait it is on time again, if it may always hurry by `hurry`. [s]
double back_after(double hurry, double slope) {
  return FormationClock::longest_wait + (1.6 + 1.5 * hurry) / slope + most_behind(slope) / hurry;
}

TEST(FormationClock, IsNeverFartherBehindAndBackInTimeWhateverRobotsDo) {
  holds("0.2 <= rate <= 1 + h, behind <= 76 s + 0.64 / a, back after 20 s + (1.6 + 1.5 h) / a + (76 s + 0.64 / a) / h",
        [] {
          Draw draw(any_seed());
          const double slope = draw.between(0.7, 20.0), hurry = draw.between(FormationClock::least_hurry, 1.0);
          FormationClock clock;
          double t = 0.0;
          const auto step = [&](bool away, double lasts) {
            clock.step(t, away, hurry, slope);
            for (int k = 0; k < 3; ++k, t += lasts / 3.0) {
              RC_ASSERT(clock.behind(t) <= most_behind(slope) + 1e-9);
              RC_ASSERT(clock.rate(t) >= FormationClock::slowly - 1e-9);
              RC_ASSERT(clock.rate(t) <= 1.0 + hurry + 1e-9);
            }
          };
          for (int k = 0; k < 8; ++k)
            for (const bool away : {true, false}) {
              const double until = t + draw.between(dt, away ? 40.0 : 3.0);
              while (t < until) step(away, draw.chance(0.5) ? dt : draw.between(dt, 5.0));
            }
          if (clock.behind(t) >= FormationClock::most_behind) return;
          const double back = t + back_after(hurry, slope), lasts = 0.02 * (back - t);
          while (t < back) step(true, lasts);
          RC_ASSERT(clock.behind(back) == 0.0);
        });
}

/// A clock that is 0.1 us less than 60 s behind and catches up at 1 + `hurry` when a robot leaves its place.
struct FarBehind {
  FormationClock clock;
  double t = 0.0;  // when the robot leaves [s]

  FarBehind(double hurry, double slope) {
    while (clock.behind(t) < FormationClock::most_behind) {
      clock.step(t, false, hurry, slope);
      clock.step(t += dt, true, hurry, slope);
      t += FormationClock::longest_wait;
    }
    clock.step(t, false, hurry, slope);
    double before = t, after = t + most_behind(slope) / hurry;
    for (int k = 0; k < 100; ++k) {
      t = 0.5 * (before + after);
      if (clock.behind(t) < FormationClock::most_behind - 1e-7)
        after = t;
      else
        before = t;
    }
    t = after;
    clock.step(t, true, hurry, slope);
  }
};

TEST(FormationClock, CanBeAsFarBehindAndForAsLong) {
  for (const double slope : {2.8, 5.0, 20.0}) {
    // The less it has just made up, the farther behind it falls.
    const FarBehind slow(FormationClock::least_hurry, slope);
    double behind = 0.0;
    for (double s = 0.0; s < 25.0; s += 1e-3) behind = std::max(behind, slow.clock.behind(slow.t + s));
    EXPECT_LE(behind, most_behind(slope) + 1e-9) << slope;
    EXPECT_GT(behind, most_behind(slope) - 1e-4) << slope;
    for (const double hurry : {FormationClock::least_hurry, 0.3, 0.9}) {
      const FarBehind last(hurry, slope);
      EXPECT_GT(last.clock.behind(last.t + back_after(hurry, slope) - 1e-4), 0.0) << slope << ' ' << hurry;
      EXPECT_EQ(last.clock.behind(last.t + back_after(hurry, slope)), 0.0) << slope << ' ' << hurry;
    }
  }
  EXPECT_NEAR(most_behind(5.0), 76.1, 0.05);
  EXPECT_NEAR(back_after(FormationClock::least_hurry, 5.0), 3826.7, 0.05);
}

TEST(FormationClock, IsNotOnTimeAgainWhileRobotsGoOnLeavingTheirPlaces) {
  FormationClock clock;
  double t = 0.0;
  for (int k = 0; k < 250000; ++k, t += dt) clock.step(t, std::fmod(t, 80.0) < 30.0, FormationClock::least_hurry, 5.0);
  EXPECT_GT(clock.behind(t), FormationClock::most_behind - 2.0) << "after 10,000 s";
}

/// What (18f, g) leave, as a share of the references' speed, shrinks evenly from `room` to 0, by `less` a tick, while a
/// clock catches up. By how much the clock runs faster than it may, at most.
double runs_too_fast(double room, double less, double slope) {
  FormationClock clock;
  double t = 0.0, most = -1.0;
  for (; t < 10.0; t += dt) clock.step(t, true, 0.7 * room, slope);
  for (; t < 12.0; t += dt) clock.step(t, false, 0.7 * room, slope);
  EXPECT_NEAR(clock.rate(t), 1.0 + 0.7 * room, 1e-9);
  for (; t < 16.0; t += dt) {
    room = std::max(0.0, room - less);
    most = std::max(most, clock.rate(t) - (1.0 + room));
    clock.step(t, false, 0.7 * room, slope);
  }
  return most;
}

TEST(FormationClock, SlowsDownInTimeWhereCouplingsGrowNoFasterThanItsRateMayChange) {
  holds("by at most 0.3 of what is left in the first tick, and by at most a in a second: rate <= 1 + what is left", [] {
    Draw draw(any_seed());
    const double room = draw.between(0.05, 1.0), slope = draw.between(2.0, 20.0);
    const double less = std::min(0.3 * room, slope * dt) * (draw.chance(0.3) ? 1.0 : draw.between(0.0, 1.0));
    RC_ASSERT(runs_too_fast(room, less, slope) <= 1e-9);
  });
  EXPECT_GT(runs_too_fast(0.4, 0.301 * 0.4, 5.0), 1e-4) << "too much in the first tick";
  EXPECT_GT(runs_too_fast(0.4, 0.3 * 0.4, 0.98 * 0.3 * 0.4 / dt), 1e-4) << "too steep";
  EXPECT_NEAR(runs_too_fast(0.42, 0.42, 5.0), 0.7 * 0.42, 1e-9) << "at once";
}

TEST(FormationClock, HurriesInsideTheBoundsAlone) {
  const core::Gains gains = core::paper_gains(2);
  const Abreast abreast;
  const double rate = 1.0 + FormationClock::hurry(gains, abreast.demand(gains.k_y));
  ASSERT_GT(rate, 1.05);
  core::Gains left = gains;
  const std::array<Twist, 2> twists{Twist{rate * 0.05, 0.0}, Twist{rate * 0.05, 0.0}};
  core::use_policy(left, twists);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_TRUE(core::margins(left, i, twists[i]).hold());
  // It takes 0.7 of what there is beyond the references and the share that is reserved for tracking: 11 mm/s are left.
  const double reserved = core::tracking_share * gains.v_max[0], all = 1.0 + (rate - 1.0) / 0.7;
  EXPECT_NEAR(left.k_x[0] - reserved, 0.3 * (all - 1.0) * 0.05, 1e-12);
  EXPECT_NEAR(left.k_x[0] - reserved, 0.0111, 1e-6);
  const std::array<Twist, 2> fastest{Twist{all * 0.05, 0.0}, Twist{all * 0.05, 0.0}};
  core::use_policy(left, fastest);
  EXPECT_NEAR(left.k_x[0], reserved, 1e-12);
  EXPECT_EQ(FormationClock::hurry(gains, {0.2, 0.2 * gains.k_y}), 0.0);
}

TEST(WaitingReference, KeepsTheFormationAndSaysHowFastItDrives) {
  FormationClock clock;
  const core::WaitingReference reference(std::make_unique<Abreast>(), clock);
  double t = 0.0;
  for (; t < 20.0; t += dt) {
    clock.step(t, t > 1.0 && t < 6.0, 0.4, 5.0);
    const ReferencePoint here = reference.at(0, t), there = reference.at(1, t), next = reference.at(0, t + 1e-4);
    ASSERT_NEAR(core::distance(here.pose, there.pose), 0.2, 1e-12);
    ASSERT_NEAR((next.pose.x - here.pose.x) / 1e-4, here.twist.v, 2e-4);
  }
  EXPECT_EQ(reference.at(0, t), Abreast().at(0, t)) << "on time again, to the bit";
}

}  // namespace
}  // namespace skein::test
