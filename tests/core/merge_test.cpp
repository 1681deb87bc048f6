// Ways back to places that drive on, and clocks that fall behind and catch up.
#include "core/planning/merge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/control/gains.h"
#include "core/kinematics/unicycle.h"
#include "core/planning/planner.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Delay;
using core::Pose;
using core::ReferencePoint;
using core::Route;
using core::Twist;

/// Robots on a circle, each 12 cm of arc behind the next.
class Ring final : public core::Reference {
 public:
  explicit Ring(std::size_t robots) : robots_(robots) {}
  using core::Reference::at;
  std::size_t robots() const noexcept override { return robots_; }
  ReferencePoint at(std::size_t i, double t) const noexcept override {
    const double angle = (speed * t - 0.12 * static_cast<double>(i)) / radius;
    return {{radius * std::cos(angle), radius * std::sin(angle), core::wrap_angle(angle + 0.5 * core::pi)},
            {speed, speed / radius}};
  }
  core::ReferenceDemand demand(double k_y) const noexcept override { return {speed, speed / radius + k_y * speed}; }
  bool smooth() const noexcept override { return true; }
  std::vector<std::vector<Pose>> lines() const override { return {}; }

 private:
  static constexpr double radius = 0.5, speed = 0.05;
  std::size_t robots_;
};

TEST(Delay, StopsStandsAndCatchesUpOnAContinuousClock) {
  for (const double stands : {0.5, 1.2, 4.5})
    for (const double hurry : {0.1, 0.6, 2.0}) {
      const Delay delay(3.0, stands, hurry, 11.0);
      constexpr double step = 1e-3;
      double most = 0.0;
      const int last = static_cast<int>((delay.ends() - 1.0) / step);
      for (int k = 0; k <= last; ++k) {
        const double t = 2.0 + step * k;
        const double rate = delay.rate(t);
        most = std::max(most, delay.at(t));
        EXPECT_GE(rate, -1e-9) << "a clock never runs backwards";
        EXPECT_LE(rate, 1.0 + hurry + 1e-9);
        EXPECT_LE(std::abs(delay.rate(t + step) - rate), 11.0 * step + 1e-9);
        EXPECT_NEAR(delay.at(t + step) - delay.at(t), step * (1.0 - 0.5 * (rate + delay.rate(t + step))), 2e-3 * step);
      }
      EXPECT_NEAR(most, delay.most_behind(), 1e-3);
      EXPECT_GT(most, stands);
      EXPECT_EQ(delay.at(delay.ends()), 0.0);
      EXPECT_NEAR(delay.at(delay.ends() - 1e-4), 0.0, 1e-3);
    }
  EXPECT_EQ(Delay().at(1.0), 0.0);
  EXPECT_EQ(Delay().rate(1.0), 1.0);
}

TEST(Merge, MeetsThePlaceInPositionHeadingAndSpeedInsideTheBounds) {
  const Ring ring(1);
  core::Lattice lattice(arena, 0.0435, 0);
  core::Traffic traffic(1);
  core::Merge merge;
  Draw draw(1);
  for (int k = 0; k < 200; ++k) {
    core::Merge::Query query;
    const double t = draw.between(0.0, 60.0);
    const ReferencePoint place = ring.at(0, t);
    query.from = {place.pose.x + draw.between(-0.2, 0.2), place.pose.y + draw.between(-0.2, 0.2), draw.angle()};
    query.v = draw.chance(0.5) ? 0.0 : 0.05;
    query.t = t;
    query.pace = {0.0945, 1.566, 0.55, 12.0};
    Route route;
    const core::Merge::Way way = merge.find(query, ring, lattice, traffic, route);
    ASSERT_TRUE(way.found);
    const double straight = core::distance(place.pose, query.from);
    EXPECT_LE(way.joins, 2.0 * core::pi / 1.566 + 1.0 + straight / (0.0945 - 0.05)) << "turn, chase, turn";
    Pose pose = query.from;
    double v = query.v, end = 0.0;
    for (double s = 0.0; s + dt < way.joins + core::Merge::goes_on; s += dt, end = s) {
      const Twist twist = route.twist(s, dt);
      EXPECT_GE(twist.v, -1e-12);
      EXPECT_LE(twist.v, 0.0945 + 1e-9);
      EXPECT_LE(std::abs(twist.omega) + query.k_y * twist.v, 1.566 + 1e-6);
      EXPECT_LE(std::abs(twist.v - v), 0.03);
      v = twist.v;
      pose = core::advance(pose, twist, dt);
    }
    const ReferencePoint there = ring.at(0, t + way.joins + 0.2);
    const Pose reached = route.at(way.joins + 0.2).pose;
    EXPECT_LT(core::distance(reached, there.pose), 1e-3);
    EXPECT_LT(std::abs(core::wrap_angle(reached.theta - there.pose.theta)), 0.01);
    EXPECT_NEAR(route.twist(way.joins + 0.1, dt).v, 0.05, 1e-3);
    EXPECT_LT(core::distance(pose, route.at(end).pose), 2e-3) << "a unicycle drives it";
  }
}

/// Robots on the x axis, each 12 cm behind the next; the place of robot 1 begins at the origin.
class Column final : public core::Reference {
 public:
  static constexpr std::size_t count = 4;
  using core::Reference::at;
  std::size_t robots() const noexcept override { return count; }
  ReferencePoint at(std::size_t i, double t) const noexcept override {
    return {{0.05 * t + 0.12 * (1.0 - static_cast<double>(i)), 0.0, 0.0}, {0.05, 0.0}};
  }
  core::ReferenceDemand demand(double k_y) const noexcept override { return {0.05, k_y * 0.05}; }
  bool smooth() const noexcept override { return true; }
  std::vector<std::vector<Pose>> lines() const override { return {}; }
};

/// When robot `i` of the column joins its place, from where it stands, past the others, who begin on a delayed clock;
/// or if nobody else is there.
double joins(std::size_t i, const Pose& from, std::size_t most_work, const Delay& delay, bool crowded = true) {
  const Column column;
  const core::Lattice lattice({4.0, 1.0}, 0.0435, 0);
  core::Traffic traffic(Column::count);
  for (std::size_t j = 0; j < Column::count; ++j)
    if (j != i) traffic.follows(j, {column, 0.0, 45.0, delay});
  core::Merge merge;
  core::Merge::Query query;
  query.robot = i;
  query.from = from;
  query.pace = {0.0945, 1.566, 0.55, 12.0};
  query.keep = 0.082;
  query.watched = delay.ends();
  query.most_work = most_work;
  query.crowded = crowded;
  Route route;
  const core::Merge::Way way = merge.find(query, column, lattice, traffic, route);
  if (!way.found || !crowded) return way.joins;
  for (std::size_t k = 0; 0.1 * static_cast<double>(k) < way.joins; ++k)
    for (std::size_t j = 0; j < Column::count; ++j) {
      const Pose here = route.at(0.1 * static_cast<double>(k)).pose;
      const double apart = std::hypot(here.x - traffic.x(j, k), here.y - traffic.y(j, k));
      EXPECT_TRUE(j == i || apart > 0.08) << apart;
    }
  return way.joins;
}

TEST(Merge, StepsAsideForThoseWhoComeAndWaitsThereUntilTheyHavePassed) {
  constexpr double yields = 2.0;  // those who come [s]
  for (const double aside : {-0.05, 0.0, 0.05})
    for (const double ahead : {0.23, 0.25, 0.28}) {
      const Pose facing{ahead, aside, 3.0};
      EXPECT_LT(joins(2, facing, 1000, Delay(0.0, yields, 0.6, 11.0)), 8.0) << ahead << " " << aside;
    }
}

/// Once it entered the lane beside the column so near that it had to drive a loop first, and was up to 30 s later than
/// alone, or found nothing.
TEST(Merge, OvertakesAColumnFromBehindItsLastRobot) {
  for (std::size_t i = 0; i + 1 < Column::count; ++i)
    for (const double aside : {-0.2, -0.05, 0.0, 0.1})
      for (const double ahead : {-0.36, -0.5})
        for (const double heading : {0.0, 1.57, 3.14}) {
          const Pose from{ahead, aside, heading};
          const double alone = joins(i, from, 4000, Delay(), false);
          EXPECT_LT(joins(i, from, 1500, Delay()), alone + 4.0) << i << ": " << ahead << " " << aside << " " << heading;
        }
}

// Proposition 6 of docs/theory.md, from both sides.

TEST(Delay, ClocksThatDifferCostNoMoreThanIsDrivenInTheirDifference) {
  const Ring ring(4);
  const double speed = ring.at(0, 0.0).twist.v;
  holds("|d_ij - the formation's| <= v |delta_i - delta_j|, and 0 on one clock", [&] {
    Draw draw(any_seed());
    const auto any_delay = [&] {
      return Delay(draw.between(0.0, 3.0), draw.between(0.0, 5.0), draw.between(0.05, 2.0), draw.between(1.0, 20.0));
    };
    const Delay first = any_delay(), second = draw.chance(0.3) ? first : any_delay();
    const std::size_t i = static_cast<std::size_t>(draw.whole(0, 3)), j = (i + 1) % 4;
    for (double t = 0.0; t < 12.0; t += 0.5) {
      const double behind = first.at(t), other = second.at(t);
      const double apart = core::distance(ring.at(i, t - behind).pose, ring.at(j, t - other).pose);
      const double formation = core::distance(ring.at(i, t - behind).pose, ring.at(j, t - behind).pose);
      RC_ASSERT(std::abs(apart - formation) <= speed * std::abs(behind - other) + 1e-12);
    }
  });
}

TEST(Delay, ClocksThatDifferCanCostExactlyThat) {
  const Column column;
  for (const double stands : {0.5, 1.2, 2.0}) {
    const Delay delay(1.0, stands, 0.6, 11.0);
    double least = 1e9;  // robot 0 yields, robot 1 behind it does not
    for (double t = 0.0; t < delay.ends(); t += 1e-3)
      least = std::min(least, core::distance(column.at(0, t - delay.at(t)).pose, column.at(1, t).pose));
    const double bound = 0.12 - column.at(0, 0.0).twist.v * delay.most_behind();
    EXPECT_GE(least, bound - 1e-9) << stands;
    EXPECT_LT(least, bound + 1e-4) << stands;
  }
}

/// A column that grows longer: how far apart two of it are tells the time, and so does where each of them is.
class Lengthening final : public core::Reference {
 public:
  static constexpr std::size_t count = 5;
  using core::Reference::at;
  std::size_t robots() const noexcept override { return count; }
  ReferencePoint at(std::size_t i, double t) const noexcept override {
    return {{speed(i) * t - 0.12 * static_cast<double>(i), 0.0, 0.0}, {speed(i), 0.0}};
  }
  core::ReferenceDemand demand(double k_y) const noexcept override { return {0.05, k_y * 0.05}; }
  bool smooth() const noexcept override { return true; }
  std::vector<std::vector<Pose>> lines() const override { return {}; }

  static double clock_at(std::size_t i, double x) { return (x + 0.12 * static_cast<double>(i)) / speed(i); }

 private:
  static double speed(std::size_t i) { return 0.05 - 0.001 * static_cast<double>(i); }
};

/// Robots that drive exactly where the planner wants them, after one of them was put elsewhere.
struct Yielding {
  int ticks = 0;          // in which two or more yield
  double differ = 0.0;    // clocks of those that yield at once, at most [s]
  double behind = 0.0;    // such a clock, at most [s]
  double distance = 0.0;  // of two that yield, from the formation's at their clock's time [m]
  double jump = 0.0;      // of a reference of one that yields, from where its speed leads [m]
};
Yielding put_elsewhere(std::size_t robot, double ahead, double aside, double heading) {
  const Lengthening column;
  constexpr std::size_t n = Lengthening::count;
  core::Gains gains = core::paper_gains(n);
  for (core::PairTable* table : {&gains.k_xx, &gains.k_tt, &gains.k_yy}) table->fill(0.0);
  core::Planner planner({n, 0, {4.0, 1.0}, 0.078, 60.0}, column);
  std::vector<Pose> poses(n);
  std::vector<ReferencePoint> nominal(n), followed(n);
  std::vector<Twist> last(n);
  const std::vector<std::uint8_t> nobody(n);
  Yielding all;
  for (int k = 0; k * dt < 12.0; ++k) {
    const double t = k * dt;
    column.core::Reference::at(t, nominal);
    for (std::size_t i = 0; i < n; ++i)
      poses[i] = k == 0 ? nominal[i].pose : core::advance(followed[i].pose, last[i], dt);
    if (k == 50) poses[robot] = {poses[robot].x + ahead, aside, heading};
    planner.step({t, false, poses, last, nobody, nobody, {}, 0.0}, gains, dt, nominal, followed);
    std::vector<std::size_t> yield;
    for (std::size_t i = 0; i < n; ++i) {
      last[i] = followed[i].twist;
      if (planner.state(i) == core::Planner::State::yielding) yield.push_back(i);
    }
    all.ticks += yield.size() > 1;
    for (const std::size_t i : yield) {
      const double clock = Lengthening::clock_at(i, followed[i].pose.x);
      all.behind = std::max(all.behind, t - clock);
      all.jump = std::max(all.jump, core::distance(followed[i].pose, poses[i]));
      for (const std::size_t j : yield) {
        all.differ = std::max(all.differ, std::abs(clock - Lengthening::clock_at(j, followed[j].pose.x)));
        all.distance =
            std::max(all.distance, std::abs(core::distance(followed[i].pose, followed[j].pose) -
                                            core::distance(column.at(i, clock).pose, column.at(j, clock).pose)));
      }
    }
  }
  return all;
}

TEST(Planner, ThoseWhoYieldHaveOneClockAndTheFormationsDistances) {
  int ticks = 0;
  double behind = 0.0;
  for (const std::size_t robot : {1, 2, 3})
    for (const double ahead : {0.25, 0.4})
      for (const double aside : {-0.05, 0.02}) {
        const Yielding all = put_elsewhere(robot, ahead, aside, 3.0);
        ticks += all.ticks;
        behind = std::max(behind, all.behind);
        EXPECT_LT(all.differ, 1e-9) << robot << ' ' << ahead << ' ' << aside;
        EXPECT_LT(all.distance, 1e-12) << robot << ' ' << ahead << ' ' << aside;
        EXPECT_LT(all.jump, 1e-3) << robot << ' ' << ahead << ' ' << aside;
      }
  EXPECT_GT(ticks, 100);
  EXPECT_GT(behind, 1.0);
}

}  // namespace
}  // namespace skein::test
