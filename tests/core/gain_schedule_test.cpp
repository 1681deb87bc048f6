// Coupling gains that change during a run: never by a jump, and never past what the reference leaves.
#include "core/control/gain_schedule.h"

#include <algorithm>
#include <memory>

#include "core/reference/platoon.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::CouplingGains;
using core::GainName;
using core::Gains;
using core::GainSchedule;
using core::PairTable;
using core::ReferenceDemand;

PairTable random_table(Draw& draw, std::size_t n) {
  PairTable table(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) table.set(i, j, draw.between(0.0, 0.1));
  return table;
}

CouplingGains random_couplings(Draw& draw, std::size_t n) {
  return {random_table(draw, n), random_table(draw, n), random_table(draw, n)};
}

GainName random_name(Draw& draw) {
  return core::gain_names[static_cast<std::size_t>(draw.whole(0, 2))];
}

/// The largest difference of two tables of n robots.
double difference(const PairTable& a, const PairTable& b, std::size_t n) {
  double largest = 0.0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) largest = std::max(largest, std::abs(a(i, j) - b(i, j)));
  return largest;
}

TEST(GainSchedule, StandsStillUntilItIsTold) {
  Draw draw(1);
  const CouplingGains start = random_couplings(draw, 4);
  GainSchedule schedule(start);
  for (int k = 0; k < 10; ++k) schedule.step(0.04);
  EXPECT_EQ(schedule.now(), start);
  EXPECT_EQ(schedule.target(), start);
}

TEST(GainSchedule, RampsEveryPairOverTheTimeGiven) {
  holds("each pair on its own straight line from here to there, all there at once; the other gains stay", [] {
    const int robots = any_of(2, 6);
    const auto n = static_cast<std::size_t>(robots);
    Draw draw(any_seed());
    const CouplingGains start = random_couplings(draw, n);
    GainSchedule schedule(start);
    const GainName name = random_name(draw);
    const PairTable target = random_table(draw, n);
    const double seconds = draw.between(0.1, 5.0), dt = 0.04;
    schedule.ramp(name, target, seconds);
    const auto ticks = static_cast<int>(std::ceil(seconds / dt));
    for (int k = 1; k <= ticks + 1; ++k) {
      schedule.step(dt);
      const double way = std::min(1.0, k * dt / seconds);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
          const double from = core::table(start, name)(i, j);
          const double expected = from + way * (target(i, j) - from);
          RC_ASSERT(std::abs(core::table(schedule.now(), name)(i, j) - expected) <= 1e-14);
        }
    }
    RC_ASSERT(core::table(schedule.now(), name) == target);
    for (const GainName other : core::gain_names)
      if (other != name) RC_ASSERT(core::table(schedule.now(), other) == core::table(start, other));
  });
}

TEST(GainSchedule, NeverMovesFasterThanItsRate) {
  holds("move: at most rate dt a step, whatever was asked for in between, and it arrives", [] {
    const int robots = any_of(2, 6);
    const auto n = static_cast<std::size_t>(robots);
    Draw draw(any_seed());
    GainSchedule schedule(random_couplings(draw, n));
    const GainName name = random_name(draw);
    const double rate = draw.decades(-3.0, 0.0), dt = draw.between(0.001, 0.1);
    double value = 0.0;
    for (int k = 0; k < 100; ++k) {
      if (draw.chance(0.1) || k == 0) schedule.move(name, value = draw.between(0.0, 0.2), rate);
      const PairTable before = core::table(schedule.now(), name);
      schedule.step(dt);
      RC_ASSERT(difference(before, core::table(schedule.now(), name), n) <= rate * dt * (1.0 + 1e-12) + 1e-16);
    }
    for (double t = 0.0; t < 0.2 / rate + dt; t += dt) schedule.step(dt);
    RC_ASSERT(core::table(schedule.now(), name) == PairTable(n, value));
  });
}

TEST(GainSchedule, ARampOfNoTimeIsThereAfterOneStep) {
  const PairTable start(3, 0.025), target(3, 0.01);
  GainSchedule schedule({PairTable(3, 0.008), start, PairTable(3, 0.08)});
  schedule.ramp(GainName::k_tt, target, 0.0);
  schedule.step(0.0);  // an unlimited rate times no time must not make a NaN
  EXPECT_TRUE(schedule.now().k_tt == start || schedule.now().k_tt == target);
  schedule.step(0.04);
  EXPECT_EQ(schedule.now().k_tt, target);
}

/// The gains of (36) with these couplings and the most that the reference ever asks: k_x and k_theta at their least.
core::Margins margins_at(Gains gains, const CouplingGains& couplings, const ReferenceDemand& demand, std::size_t i) {
  gains.k_xx = couplings.k_xx, gains.k_tt = couplings.k_tt, gains.k_yy = couplings.k_yy;
  const core::Twist reference{demand.v, demand.turning - gains.k_y * demand.v};
  const std::vector<core::Twist> all(gains.robots(), reference);
  core::use_all_authority(gains, all);
  return core::margins(gains, i, reference);
}

TEST(GainLimit, LeavesTheTrackingShareAndNotMore) {
  holds("at the limit every robot keeps tracking_share, and one of them no more than that", [] {
    const int robots = any_of(2, 8);
    const auto n = static_cast<std::size_t>(robots);
    Draw draw(any_seed());
    Gains gains = core::paper_gains(n);
    for (std::size_t i = 0; i < n; ++i)
      gains.v_max[i] = draw.between(0.08, 0.2), gains.omega_max[i] = draw.between(1.7, 4);
    const ReferenceDemand demand{0.05, 0.42 + 11.0 * 0.05};
    CouplingGains couplings{PairTable(n), PairTable(n, draw.between(0.0, 0.04)), PairTable(n, draw.between(0.0, 0.04))};
    const GainName name = random_name(draw);
    const double limit = core::gain_limit(name, gains, couplings, demand);
    RC_ASSERT(limit > 0.0);
    core::table(couplings, name).fill(limit);
    double least = 1e9;
    for (std::size_t i = 0; i < n; ++i) {
      RC_ASSERT(margins_at(gains, couplings, demand, i).hold());
      Gains at = gains;
      at.k_xx = couplings.k_xx, at.k_tt = couplings.k_tt, at.k_yy = couplings.k_yy;
      const std::vector<core::Twist> all(n, {demand.v, demand.turning - gains.k_y * demand.v});
      core::use_all_authority(at, all);
      least = std::min(least, name == GainName::k_xx ? at.k_x[i] / at.v_max[i] : at.k_theta[i] / at.omega_max[i]);
    }
    RC_ASSERT(std::abs(least - core::tracking_share) <= 1e-12);
  });
}

TEST(GainLimit, IsNeverNegative) {
  const Gains gains = core::paper_gains(4);
  const CouplingGains none{PairTable(4), PairTable(4), PairTable(4)};
  for (const GainName name : core::gain_names) {
    EXPECT_EQ(core::gain_limit(name, gains, none, {1.0, 100.0}), 0.0);
    EXPECT_EQ(core::gain_limit(name, core::paper_gains(1), {PairTable(1), PairTable(1), PairTable(1)}, {}), 0.0);
  }
}

TEST(GainLimit, AdmitsTheCaseStudy) {
  const Gains gains = core::paper_gains(4);
  const CouplingGains paper{gains.k_xx, gains.k_tt, gains.k_yy};
  const core::Platoon platoon(std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119), 4, 0.12, 0.05, 1.6);
  const ReferenceDemand demand = platoon.demand(gains.k_y);
  EXPECT_GT(core::gain_limit(GainName::k_xx, gains, paper, demand), 0.008);
  EXPECT_GT(core::gain_limit(GainName::k_tt, gains, paper, demand), 0.025);
  EXPECT_GT(core::gain_limit(GainName::k_yy, gains, paper, demand), 0.08);
}

TEST(ReferenceDemand, OfAPlatoonIsTheMostAlongItsLap) {
  const core::Platoon platoon(std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119), 4, 0.12, 0.05, 1.6);
  double v = 0.0, turning = 0.0;
  for (double t = 0.0; t < 84.0; t += 0.04)
    for (std::size_t i = 0; i < 4; ++i) {
      const core::Twist twist = platoon.at(i, t).twist;
      v = std::max(v, std::abs(twist.v));
      turning = std::max(turning, std::abs(twist.omega) + 11.0 * std::abs(twist.v));
    }
  EXPECT_DOUBLE_EQ(platoon.demand(11.0).v, v);
  EXPECT_DOUBLE_EQ(platoon.demand(11.0).turning, turning);
}

}  // namespace
}  // namespace skein::test
