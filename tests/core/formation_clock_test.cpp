// The clock of a formation that waits for one of its robots.
#include "core/planning/formation_clock.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "core/control/gains.h"
#include "draw.h"
#include "lab.h"

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

TEST(FormationClock, HurriesInsideTheBoundsAlone) {
  const core::Gains gains = core::paper_gains(2);
  const Abreast abreast;
  const double rate = 1.0 + FormationClock::hurry(gains, abreast.demand(gains.k_y));
  ASSERT_GT(rate, 1.05);
  core::Gains left = gains;
  const std::array<Twist, 2> twists{Twist{rate * 0.05, 0.0}, Twist{rate * 0.05, 0.0}};
  core::use_policy(left, twists);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_TRUE(core::margins(left, i, twists[i]).hold());
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
