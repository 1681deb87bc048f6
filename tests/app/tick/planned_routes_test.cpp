// Planned routes in the tick: crowds arrive, kicked robots come back, and a run repeats to the bit.
#include <gtest/gtest.h>

#include "tests/app/experiment_texts.h"
#include "tests/app/fixture.h"

namespace skein::app {
namespace {

Experiment crowd() {
  auto e = load_experiment(experiments + "crowd.toml");
  if (!e) ADD_FAILURE() << e.error().front().message();
  return e ? *e : Experiment{};
}

double farthest(const TickRecord& row) {
  double distance = 0.0;
  for (const RobotRecord& r : row.robots) distance = std::fmax(distance, core::distance(r.truth, r.nominal.pose));
  return distance;
}

double nearest(const std::vector<TickRecord>& rows) {
  double distance = 1e9;
  for (const TickRecord& row : rows) distance = std::fmin(distance, row.min_distance);
  return distance;
}

TEST(PlannedRoutes, BringACrowdToItsPlaces) {
  const std::vector<TickRecord> rows = test::simulate(crowd());
  EXPECT_LT(farthest(rows.back()), 0.01);
  EXPECT_GE(nearest(rows), 0.078);
}

TEST(PlannedRoutes, RepeatToTheBit) {
  const std::vector<TickRecord> first = test::simulate(crowd()), again = test::simulate(crowd());
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t k = 0; k < first.size(); ++k)
    for (std::size_t i = 0; i < first[k].robots.size(); ++i)
      ASSERT_EQ(first[k].robots[i].command, again[k].robots[i].command) << "tick " << k;
}

TEST(PlannedRoutes, BringAKickedRobotBackAndReleaseItsCouplingsMeanwhile) {
  Experiment e = paper_experiment();
  e.avoidance.kind = core::AvoidanceKind::plan;
  e.duration = 40.0;
  e.gain_changes.clear();
  e.perturbations = {{2.0, 1, 0.2, 0.15, 2.0}};
  const std::vector<TickRecord> rows = test::simulate(e);
  EXPECT_LT(farthest(rows.back()), 0.005);
  EXPECT_GE(nearest(rows), 0.078 - 1e-6);
  double least = 1.0;
  for (const TickRecord& row : rows) {
    least = std::fmin(least, row.pair_gain(core::GainName::k_xx, 0, 1));
    for (const RobotRecord& r : row.robots) EXPECT_TRUE(r.margins.hold()) << "(18) at " << row.t << " s";
  }
  EXPECT_EQ(least, 0.0);
  EXPECT_EQ(rows.back().pair_gain(core::GainName::k_xx, 0, 1), 0.008);
}

/// The paper's platoon, one robot of which is put elsewhere.
std::vector<TickRecord> kicked(bool formation_waits) {
  Experiment e = paper_experiment();
  e.avoidance.kind = core::AvoidanceKind::plan;
  e.avoidance.formation_waits = formation_waits;
  e.duration = 60.0;
  e.gain_changes.clear();
  e.perturbations = {{2.0, 1, 0.2, 0.15, 2.0}};
  return test::simulate(e);
}

TEST(PlannedRoutes, AFormationWaitsForItsRobotAndCatchesUp) {
  const std::vector<TickRecord> rows = kicked(true);
  double most = 0.0, slowest = 1.0, whole = -1.0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const TickRecord &row = rows[k], &before = rows[k - 1];
    most = std::fmax(most, row.lag);
    if (farthest(row) > 0.005)
      whole = -1.0;
    else if (whole < 0.0 && row.t > 2.0)
      whole = row.t;
    for (std::size_t i = 0; i < row.robots.size(); ++i) {
      const core::ReferencePoint &here = row.robots[i].nominal, &there = before.robots[i].nominal;
      slowest = std::fmin(slowest, here.twist.v);
      EXPECT_TRUE(row.robots[i].margins.hold()) << "(18) at " << row.t << " s";
      EXPECT_LE(std::abs(here.twist.v - there.twist.v), 0.012);
      EXPECT_LE(core::distance(here.pose, there.pose), 0.1 * 0.04 + 1e-9);
    }
  }
  EXPECT_GT(most, 2.0);
  EXPECT_EQ(rows.back().lag, 0.0) << "repaid";
  EXPECT_GT(slowest, 0.005) << "Theorem 1 asks for v_ref other than 0";
  EXPECT_GT(whole, 2.0);
  EXPECT_LT(whole, 12.0);
  EXPECT_LT(farthest(rows.back()), 0.005);
  for (const TickRecord& row : kicked(false)) ASSERT_EQ(row.lag, 0.0) << "who is not told to wait does not";
}

TEST(PlannedRoutes, AFormationThatWaitsRepeatsToTheBit) {
  const std::vector<TickRecord> first = kicked(true), again = kicked(true);
  for (std::size_t k = 0; k < first.size(); ++k)
    for (std::size_t i = 0; i < first[k].robots.size(); ++i)
      ASSERT_EQ(first[k].robots[i].command, again[k].robots[i].command) << "tick " << k;
}

TEST(PlannedRoutes, SayWhereThereIsNoWay) {
  Experiment e = crowd();
  e.duration = 10.0;
  const core::Pose place = make_reference(e)->at(0, 60.0).pose;
  e.obstacles = {{place.x, place.y, 0.05}};  // on its place
  int no_way = 0, no_progress = 0;
  for (const TickRecord& row : test::simulate(e))
    for (const Event& event : row.events) {
      no_way += is<events::NoWay>(event) && robot_of(event) == 0u;
      no_progress += is<events::NoProgress>(event) && robot_of(event) == 0u;
    }
  EXPECT_GE(no_way, 1);
  EXPECT_GE(no_progress, 1);
}

}  // namespace
}  // namespace skein::app
