// Planned routes in the tick: crowds arrive, kicked robots come back, and a run repeats to the bit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "app/record/csv_reader.h"
#include "app/record/csv_writer.h"
#include "core/control/coordination_law.h"
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

/// The places of a crowd drive away from robots that wait for a way, turn, or drive round others. Those are on their
/// way.
TEST(PlannedRoutes, AreProgressThoughThePlaceDrivesAwayMeanwhile) {
  auto swap = load_experiment(experiments + "antipodal-swap-20.toml");
  ASSERT_TRUE(swap) << swap.error().front().message();
  swap->avoidance.kind = core::AvoidanceKind::plan;
  swap->duration = 45.0;
  int fell_behind = 0;
  std::vector<double> away(swap->robots.size(), 0.0);
  for (const TickRecord& row : test::simulate(*swap)) {
    for (const Event& event : row.events) EXPECT_FALSE((is<events::NoProgress, events::NoWay>(event))) << row.t;
    for (std::size_t i = 0; i < row.robots.size(); ++i) {
      const double now = core::distance(row.robots[i].truth, row.robots[i].nominal.pose);
      fell_behind += now > 0.2 && away[i] <= 0.2;
      away[i] = now;
    }
  }
  EXPECT_GE(fell_behind, 10);
}

TEST(PlannedRoutes, RepeatToTheBit) {
  const std::vector<TickRecord> first = test::simulate(crowd()), again = test::simulate(crowd());
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t k = 0; k < first.size(); ++k)
    for (std::size_t i = 0; i < first[k].robots.size(); ++i)
      ASSERT_EQ(first[k].robots[i].command, again[k].robots[i].command) << "tick " << k;
}

/// A robot on its route has no couplings. Its record has the gains with which the law was computed, of each pair.
TEST(PlannedRoutes, LeaveTheLawToBeComputedAgainFromTheRecord) {
  const Experiment e = good("duration = 8\n[avoidance]\nkind = 'plan'\n[[perturb]]\nt = 1\nrobot = 2\ndy = -0.15\n");
  std::stringstream file;
  CsvWriter writer(file, e);
  for (const TickRecord& row : test::simulate(e)) writer.record(row);
  auto reader = CsvReader::open(file, "run.csv");
  ASSERT_TRUE(reader) << reader.error();
  core::Gains gains = make_gains(e);
  core::LawPairs pairs(4);
  TickRecord row;
  int avoided = 0;
  while (reader->next(row).value()) {
    std::vector<core::TrackingError> errors;
    std::vector<core::Twist> reference;
    for (const RobotRecord& robot : row.robots) {
      errors.push_back(robot.error);
      reference.push_back(robot.reference.twist);
      avoided += robot.is(avoiding);
    }
    gains.k_xx = row.pair_gains[0];
    gains.k_tt = row.pair_gains[1];
    gains.k_yy = row.pair_gains[2];
    core::use_policy(gains, reference);
    std::vector<core::Twist> law(4);
    core::coordination_law(gains, errors, reference, law, pairs);
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_NEAR(row.robots[i].law.v, law[i].v, 1e-9) << "robot " << i + 1 << " at " << row.t << " s";
      ASSERT_NEAR(row.robots[i].law.omega, law[i].omega, 1e-9) << "robot " << i + 1 << " at " << row.t << " s";
    }
  }
  EXPECT_GT(avoided, 50) << "a test of nothing";
}

/// A hand puts a robot elsewhere while it is on its route, which would lead it back there.
TEST(PlannedRoutes, BeginWhereAHandHasPutTheRobot) {
  auto swap = load_experiment(experiments + "antipodal-swap-6.toml");
  ASSERT_TRUE(swap) << swap.error().front().message();
  swap->avoidance.kind = core::AvoidanceKind::plan;
  swap->perturbations = {{6.0, 1, 0.15, 0.10, 0.0}};
  swap->duration = 12.0;
  const std::vector<TickRecord> rows = test::simulate(*swap);
  double away = 0.0;
  for (const TickRecord& row : rows)
    if (row.t > 6.5) away = std::fmax(away, core::distance(row.robots[1].truth, row.robots[1].reference.pose));
  EXPECT_LT(away, 0.03) << "its route begins elsewhere";
}

/// One that was held is behind its place when it is let go: it drives back on a route at once, before it has begun to
/// follow its place and must be stopped again.
TEST(PlannedRoutes, BringARobotBackThatIsLetGo) {
  const Experiment e = good(
      "duration = 20\nperturb = []\n[avoidance]\nkind = 'plan'\n[[operator]]\nt = 5\ndoes = 'hold r2'\n"
      "[[operator]]\nt = 5.6\ndoes = 'release r2'\n");
  double began = 0.0, ended = 0.0;
  for (const TickRecord& row : test::simulate(e)) {
    if (!row.robots[1].is(avoiding)) continue;
    if (began == 0.0) began = row.t;
    ended = row.t;
  }
  EXPECT_NEAR(began, 5.6, 0.05);
  EXPECT_LT(ended, 7.0);
}

/// In a V of mixed robots the first is held, while the second and third overtake it, and let go. It pressed on between
/// those two, each new route began beyond the robot beside it, and the shield pushed that one on with it, for good.
TEST(PlannedRoutes, LetARobotPassThatTheShieldPushesOn) {
  for (const int from : {5, 8, 11}) {
    const Experiment e = good(fmt::format(
        "duration = 60\nperturb = []\n[reference]\nkind = 'formation'\nspeed = 0.019\nspacing = 0.13\nshape = 'v'\n"
        "path = {{ shape = 'ellipse', width = 1.582, height = 0.906 }}\n[avoidance]\nkind = 'plan'\n"
        "[controller]\ncoupling = 'bounded'\n[arena]\nwidth = 2.4\nheight = 1.8\n"
        "[[operator]]\nt = {}\ndoes = 'hold r1'\n[[operator]]\nt = {}\ndoes = 'release r1'\n"
        "[[robot]]\n[[robot]]\n[[robot]]\nmodel = 'open'\n[[robot]]\nmodel = 'open'\n[[robot]]\n",
        from, from + 8));
    EXPECT_LT(farthest(test::simulate(e).back()), 0.01) << from;
  }
}

/// The places of a V of large robots leave no way between the second and the third, from where the first, which was
/// held, is to pass. It never gets there, on routes that begin anew every second, and nothing was said of it.
TEST(PlannedRoutes, AreNoProgressIfTheyNeverMeetTheirPlace) {
  std::string text =
      "duration = 32\nperturb = []\n[reference]\nkind = 'formation'\nspeed = 0.025\nspacing = 0.154\nshape = 'v'\n"
      "path = { shape = 'ellipse', width = 1.051, height = 0.984 }\n[avoidance]\nkind = 'plan'\n"
      "[controller]\ncoupling = 'bounded'\n[controller.gains]\nk_xx = 0.004\nk_tt = 0.01\nk_yy = 0.03\n"
      "[arena]\nwidth = 2.4\nheight = 1.8\n"
      "[[operator]]\nt = 3.19\ndoes = 'hold r1'\n[[operator]]\nt = 9.62\ndoes = 'release r1'\n";
  for (int k = 0; k < 6; ++k) text += "[[robot]]\nmodel = 'open'\n";
  const std::vector<TickRecord> rows = test::simulate(good(text));
  ASSERT_GT(core::distance(rows.back().robots[0].truth, rows.back().robots[0].nominal.pose), 0.1)
      << "a test of nothing";
  double said = 0.0;
  for (const TickRecord& row : rows)
    if (row.events.contains<events::NoProgress>(0)) said = row.t;
  EXPECT_GT(said, 17.5);
  EXPECT_LT(said, 30.0);
}

/// All stand until they have ways. Whoever keeps its first is not planned any more.
TEST(PlannedRoutes, AreNotChangedOnTheWayIfTheFileSaysSo) {
  const auto work_on_the_way = [](bool improve) {
    auto swap = load_experiment(experiments + "antipodal-swap-20.toml");
    if (!swap) ADD_FAILURE() << swap.error().front().message();
    Experiment e = *swap;
    e.avoidance.kind = core::AvoidanceKind::plan;
    e.avoidance.improve = improve;
    e.duration = 10.0;
    std::size_t nodes = 0;
    bool drive = false;
    for (const TickRecord& row : test::simulate(e)) {
      if (drive) nodes += row.planning;
      for (const RobotRecord& robot : row.robots) drive = drive || robot.reference.twist.v > 0.0;
    }
    EXPECT_TRUE(drive);
    return nodes;
  };
  EXPECT_EQ(work_on_the_way(false), 0u);
  EXPECT_GT(work_on_the_way(true), 0u);
}

/// Beside a larger one: two small robots 0.12 m from each other, and one 1 cm from the edge. While all were planned as
/// if they had the largest body there was no way to the one, and the other turned on the spot for ever.
TEST(PlannedRoutes, BringSmallRobotsToPlacesThatALargeOneHasNoRoomFor) {
  const Experiment e = good(
      "duration = 40\nreference.kind = 'independent'\nreference.speed = 0.09\nreference.may_meet = true\n"
      "avoidance.kind = 'plan'\ncontroller.k_y = 4\ncontroller.gains = { k_xx = 0, k_tt = 0, k_yy = 0 }\n"
      "staging.automatic = false\n"
      "[[robot]]\nmodel = 'khepera4'\nstart = [0, -0.4, 0]\n"
      "trajectory = { path = { shape = 'line', from = [0, -0.4], to = [0, 0.5] } }\n"
      "[[robot]]\nstart = [-0.6, 0, 0]\n"
      "trajectory = { path = { shape = 'line', from = [-0.6, 0], to = [0.6, 0] } }\n"
      "[[robot]]\nstart = [0.6, 0.3, 3]\n"
      "trajectory = { path = { shape = 'line', from = [0.6, 0.3], to = [0.6, -0.12] } }\n"
      "[[robot]]\nstart = [0.3, -0.4, 3]\n"
      "trajectory = { path = { shape = 'line', from = [0.3, -0.4], to = [-0.955, 0.1] } }\n");
  const std::vector<TickRecord> rows = test::simulate(e);
  EXPECT_LT(farthest(rows.back()), 0.005);
  for (const TickRecord& row : rows)
    for (const Event& event : row.events) EXPECT_FALSE(is<events::NoWay>(event)) << row.t;
}

TEST(PlannedRoutes, LeaveARobotAtItsPlaceThatWasOutOfSightForAMoment) {
  const Experiment e = good(
      "duration = 60\nreference.kind = 'independent'\nreference.speed = 0.09\navoidance.kind = 'plan'\n"
      "controller.gains = { k_xx = 0, k_tt = 0, k_yy = 0 }\nestimation.bridge = 0.12\n"
      "simulation = { pose_noise = 0.001, dropout = 0.3 }\n"
      "[[robot]]\ntrajectory = { path = { shape = 'line', from = [-0.3, 0.1], to = [0.3, 0.1] } }\n"
      "[[robot]]\ntrajectory = { path = { shape = 'line', from = [-0.3, -0.3], to = [0.3, -0.3] } }\n");
  double turned = 0.0;
  int losses = 0;
  for (const TickRecord& row : test::simulate(e)) {
    if (row.t < 20.0) continue;  // both rest from 15 s on
    for (const Event& event : row.events) losses += is<events::Lost>(event) ? 1 : 0;
    for (const RobotRecord& r : row.robots) turned += std::abs(r.command.omega) * e.period();
  }
  EXPECT_GT(losses, 3);
  EXPECT_LT(turned, 0.5) << "of two robots in 40 s";
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

/// The paper's platoon with an obstacle on its lane, so long that each robot passes it once. Where one of them is
/// farthest from its place, and how often somebody leaves it.
struct Passed {
  double farthest = 0.0;
  std::size_t leaves = 0;
};
Passed pass_an_obstacle(const core::Obstacle& obstacle) {
  Experiment e = paper_experiment();
  e.avoidance.kind = core::AvoidanceKind::plan;
  e.duration = 80.0;
  e.gain_changes.clear();
  e.perturbations.clear();
  e.obstacles = {obstacle};
  Passed result;
  std::vector<bool> away(e.robots.size());
  for (const TickRecord& row : test::simulate(e)) {
    result.farthest = std::fmax(result.farthest, farthest(row));
    for (std::size_t i = 0; i < away.size(); ++i) {
      const core::Pose& body = row.robots[i].truth;
      EXPECT_GT(std::hypot(body.x - obstacle.x, body.y - obstacle.y), obstacle.radius + e.robots[i].radius);
      const bool now = row.robots[i].is(avoiding);
      if (now && !away[i]) ++result.leaves;
      away[i] = now;
    }
  }
  return result;
}

/// A way that joins its place in front of the obstacle ends there: who took it again and again was 69 cm late, and left
/// its place 41 times.
TEST(PlannedRoutes, LeadPastAnObstacleBeforeTheyJoinTheirPlaces) {
  for (const core::Obstacle& obstacle :
       {core::Obstacle{0.0, 0.45, 0.05}, core::Obstacle{0.1, 0.52, 0.073}, core::Obstacle{-0.2, 0.38, 0.04}}) {
    const Passed passed = pass_an_obstacle(obstacle);
    EXPECT_LT(passed.farthest, 0.25) << obstacle.y;
    EXPECT_LE(passed.leaves, 8u) << obstacle.y;
  }
}

/// The paper's platoon, of which one or two robots are put elsewhere.
std::vector<TickRecord> kicked(bool formation_waits, double start, const std::vector<Perturbation>& hands) {
  Experiment e = paper_experiment();
  e.avoidance.kind = core::AvoidanceKind::plan;
  e.avoidance.formation_waits = formation_waits;
  e.duration = 60.0;
  e.gain_changes.clear();
  e.reference.start = start;
  e.perturbations = hands;
  return test::simulate(e);
}

std::vector<TickRecord> kicked(bool formation_waits) {
  return kicked(formation_waits, ReferenceSpec{}.start, {{2.0, 1, 0.2, 0.15, 2.0}});
}

/// Since when everybody is within 5 mm of its place; infinity: not at the end.
double whole_from(const std::vector<TickRecord>& rows) {
  constexpr double never = std::numeric_limits<double>::infinity();
  double whole = never;
  for (const TickRecord& row : rows) whole = farthest(row) > 0.005 ? never : std::fmin(whole, row.t);
  return whole;
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

/// Couplings that grow while the robot is on its way, or while the formation catches up, leave less to catch up with.
TEST(PlannedRoutes, AFormationThatCatchesUpKeepsTheConditionsWhileItsCouplingsGrow) {
  for (const double t : {2.5, 4.5, 6.5, 8.0}) {
    Experiment e = paper_experiment();
    e.avoidance.kind = core::AvoidanceKind::plan;
    e.avoidance.formation_waits = true;
    e.duration = 30.0;
    GainChange more{};
    more.t = t;
    more.ramp = 1.0;
    more[core::GainName::k_xx] = core::PairTable(e.robots.size(), 0.0148);
    e.gain_changes = {more};
    e.perturbations = {{2.0, 1, 0.2, 0.15, 2.0}};
    const std::vector<TickRecord> rows = test::simulate(e);
    for (const TickRecord& row : rows)
      for (const RobotRecord& r : row.robots) ASSERT_TRUE(r.margins.hold()) << "(18) at " << row.t << " s";
    EXPECT_LT(whole_from(rows), 12.0) << t;
    EXPECT_GT(rows.back().lag, 0.5) << "control: nothing is left to catch up with";
  }
}

TEST(PlannedRoutes, AWayThatTookATicksWorkIsNotLookedForWithTheRestOfIt) {
  for (const auto& rows : {kicked(true, 1.151955, {{2.0, 0, -0.068279, -0.355861, -0.099167}}),
                           kicked(true, 1.185628, {{2.0, 0, 0.054823, -0.371326, 0.79346}})}) {
    EXPECT_LT(whole_from(rows), 12.0);
    EXPECT_GE(nearest(rows), 0.078 - 1e-6);
  }
}

TEST(PlannedRoutes, AFormationThatWaitsDoesNotStandInItsRobotsWayForAsLong) {
  const std::array<double, 4> starts{1.6192, 2.1626, 1.3426, 1.4949};
  const std::array<std::vector<Perturbation>, 4> hands{{{{2.0, 2, 0.24024, -0.29507, 2.99618}},
                                                        {{2.0, 1, -0.27139, -0.0324, -1.95975}},
                                                        {{2.0, 2, -0.0874, 0.27529, -0.80389},  //
                                                         {2.0, 0, 0.15726, -0.31759, 0.7716}},
                                                        {{2.0, 2, -0.04776, 0.34828, 3.05387}}}};
  for (std::size_t k = 0; k < starts.size(); ++k) EXPECT_LT(whole_from(kicked(true, starts[k], hands[k])), 12.0);
}

TEST(PlannedRoutes, AGoodWayIsTakenBeforeItIsGone) {
  for (const auto& rows : {kicked(false, 4.029543,
                                  {{2.0, 2, 0.146489, -0.003801, -2.877501},  //
                                   {2.0, 0, -0.243699, -0.064302, 2.939516}}),
                           kicked(false, 2.467171,
                                  {{2.0, 0, 0.2382, 0.234008, 2.703204},  //
                                   {2.0, 1, 0.055793, 0.119813, 0.645372}})}) {
    EXPECT_LT(whole_from(rows), 15.0);
    EXPECT_GE(nearest(rows), 0.078 - 1e-6);
  }
}

TEST(PlannedRoutes, WhoStandsWhileAWayIsSearchedIsNotDrivenBack) {
  // The search takes several ticks, in each of which the robots brake from what they do by then.
  const std::vector<TickRecord> rows = kicked(false, 0.289605,
                                              {{2.0, 0, 0.287928, 0.106738, 0.233876},  //
                                               {2.0, 1, -0.040543, -0.060942, 1.277793}});
  for (const TickRecord& row : rows) {
    if (row.t < 2.0 || row.t > 2.2) continue;
    EXPECT_LT(std::abs(row.robots[0].error.x), 1e-3) << "at " << row.t << " s";
    EXPECT_GE(row.robots[0].command.v, -1e-3) << "at " << row.t << " s";
  }
}

TEST(PlannedRoutes, AFormationThatWaitsRepeatsToTheBit) {
  const std::vector<TickRecord> first = kicked(true), again = kicked(true);
  for (std::size_t k = 0; k < first.size(); ++k)
    for (std::size_t i = 0; i < first[k].robots.size(); ++i)
      ASSERT_EQ(first[k].robots[i].command, again[k].robots[i].command) << "tick " << k;
}

/// A hand puts three robots into a corner, touching one another. Two of them, with no way at first, waited for an
/// attempt of their own and were never planned together with the third.
TEST(PlannedRoutes, LeadOutOfAPileInACorner) {
  struct Drive {
    const char *start, *end;
  };
  constexpr std::array<Drive, 8> drives{{{"-0.1556, -0.4066, 1.786", "0.0781, 0.4401"},
                                         {"-0.4876, -0.6313, 1.224", "0.7464, -0.1386"},
                                         {"-0.6758, -0.3959, -2.370", "0.0900, 0.1943"},
                                         {"0.1941, -0.2426, -1.795", "-0.8379, -0.6172"},
                                         {"0.4932, 0.6152, 1.763", "0.3942, -0.3457"},
                                         {"0.7451, -0.0942, -1.658", "-0.8809, 0.1108"},
                                         {"0.5178, -0.2732, -2.562", "-0.5160, 0.4161"},
                                         {"0.8620, 0.5709, -1.822", "0.8704, 0.3000"}}};
  std::string text =
      "seed = 572711\nduration = 80\n[arena]\nwidth = 2.0\nheight = 1.5\n[reference]\nkind = 'independent'\nspeed = "
      "0.09\n"
      "may_meet = true\n[controller]\nk_y = 4.0\n[controller.gains]\nk_xx = 0.0\nk_tt = 0.0\nk_yy = 0.0\n[avoidance]\n"
      "kind = 'plan'\n[staging]\nautomatic = false\n[[obstacle]]\nx = -0.3287\ny = -0.0165\nradius = "
      "0.0735\n[[obstacle]]\n"
      "x = 0.3526\ny = -0.1737\nradius = 0.0761\n";
  for (const Drive& drive : drives) {
    const std::string start = drive.start;
    text +=
        fmt::format("[[robot]]\nstart = [{}]\ntrajectory = {{ path = {{ shape = 'line', from = [{}], to = [{}] }} }}\n",
                    start, start.substr(0, start.rfind(',')), drive.end);
  }
  for (const char* moved :
       {"r6 x=-0.96 y=-0.71 theta=1.23", "r2 x=-0.88295 y=-0.70168 theta=2.12", "r1 x=-0.9337 y=-0.64298 theta=-0.34"})
    text += fmt::format("[[operator]]\nt = 11.55\ndoes = 'move {}'\n", moved);
  const std::vector<TickRecord> rows = test::simulate(good(text));
  EXPECT_LT(farthest(rows.back()), 0.01);
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

TEST(PlannedRoutes, LeadPastAnObstacleOnTheLaneWithoutAJumpOrAReport) {
  Experiment e = paper_experiment();
  e.avoidance.kind = core::AvoidanceKind::plan;
  e.perturbations.clear();
  e.gain_changes.clear();
  e.duration = 45.0;
  e.obstacles = {{0.0, 0.45, 0.05}};
  double aside = 0.0;
  std::vector<double> before;
  for (const TickRecord& row : test::simulate(e)) {
    for (const Event& event : row.events) EXPECT_FALSE((is<events::NoProgress, events::NoWay>(event))) << row.t;
    aside = std::fmax(aside, farthest(row));
    for (std::size_t i = 0; i < row.robots.size(); ++i) {
      const double was = before.empty() ? row.robots[i].command.v : before[i];
      EXPECT_LE(std::abs(row.robots[i].command.v - was), 0.03) << row.t;
      EXPECT_GE(row.robots[i].command.v, -0.005) << row.t;
      EXPECT_TRUE(row.robots[i].margins.hold()) << "(18) at " << row.t << " s";
    }
    before.resize(row.robots.size());
    for (std::size_t i = 0; i < row.robots.size(); ++i) before[i] = row.robots[i].command.v;
  }
  EXPECT_LE(aside, 0.05 + 0.043 + 0.008);
}

}  // namespace
}  // namespace skein::app
