// The failure table of docs/safety.md, row by row: what happens, within which time, and then. Times are checked in
// virtual time; what threads and processes make of it, without a clock, on the wall clock. Rows that need a process or
// a window of their own are in safety_net_test.cpp, command_line_test.cpp and tests/ui.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "app/experiment/experiment_file.h"
#include "app/session/control_loop.h"
#include "app/session/link_watch.h"
#include "app/session/session.h"
#include "app/tick/control_tick.h"
#include "core/simulation/simulated_robot.h"
#include "tests/app/rows.h"
#include "tests/app/session/failure_links.h"
#include "tests/app/simulated_robots.h"
#include "tests/eventually.h"

namespace skein::app {
namespace {

Experiment others_go_on(std::vector<std::string> sets = {}) {
  sets.push_back("failure.link_lost=others_go_on");
  return parse_experiment(paper_experiment().source, "platoon.toml", sets).value();
}

using test::eventually;

/// Four ideal robots around a tick, one of which the test holds.
struct Group {
  explicit Group(const Experiment& e)
      : experiment(e), tick(e), robots(test::robots_at_their_references(e)), measured(e.robots.size()) {}
  const TickRecord& step(std::vector<OperatorCommand> commands = {}, EventList events = {}) {
    now += experiment.period();
    for (std::size_t i = 0; i < robots.size(); ++i) {
      robots[i].step(experiment.period());
      if (std::find(blind.begin(), blind.end(), i) == blind.end()) measured[i] = robots[i].measure(now);
    }
    TickInput input;
    input.now = now;
    input.measurements = measured;
    input.commands = commands;
    input.events = std::move(events);
    input.links = links;
    std::vector<core::Pose> truth;
    truth.reserve(robots.size());
    for (const core::SimulatedRobot& robot : robots) truth.push_back(robot.pose());
    input.truth = truth;
    const TickRecord& record = tick.step(input);
    for (std::size_t i = 0; i < robots.size(); ++i)
      if (i != adrift) robots[i].command(record.robots[i].wheels);
    rows.push_back(record);
    return rows.back();
  }
  void steps(int count) {
    for (int k = 0; k < count; ++k) step();
  }
  void start() { step({commands::Start{}}); }

  Experiment experiment;
  ControlTick tick;
  std::vector<core::SimulatedRobot> robots;
  std::vector<core::Measurement> measured;
  std::vector<TickRecord> rows;
  std::vector<std::size_t> blind;  // robots that nobody sees
  std::vector<LinkInput> links;    // empty: nobody has one
  std::size_t adrift = 99;         // a robot that no command reaches
  double now = 0.0;
};

// --- A robot's link is lost: a connection that is gone at once, one that is silent after its bridge time ...
// ------------------------------------------------------------------------

TEST(FailureTable, ALostLinkIsKnownToTheGroupWithin100msOrItsBridgeTime) {
  for (const comms::FaultKind kind : {comms::FaultKind::burst, comms::FaultKind::disconnect})
    for (int offset = 0; offset < 40; offset += 3) {
      const double lost = 1.0 + 0.001 * offset;
      const double bridge = kind == comms::FaultKind::disconnect ? 0.0 : FailureSpec{}.link_bridge;
      test::FailureLinks links({{.kind = kind, .robot = 1, .at = lost, .duration = 3.0}});
      links.run_until(lost + bridge + 0.15);
      ASSERT_TRUE(links.lost_at) << offset;
      EXPECT_LE(*links.lost_at, lost + bridge + 0.06 + 1e-9) << "all stop; " << offset;
      EXPECT_NE(links.why.find("robot 2: the link is"), std::string::npos) << links.why;
      ASSERT_EQ(links.told().size(), 1u) << "or the tick is told, and holds the robot";
      EXPECT_LE(links.told()[0].first, lost + bridge + 0.1 + 1e-9) << offset;
      EXPECT_EQ(links.told()[0].second.substr(0, 7), "link r2");
      EXPECT_TRUE(links.session(0).up() && links.session(2).up());
    }
}

TEST(FailureTable, ALinkThatComesBackStopsItsRobotFirst) {
  for (const comms::FaultKind kind : {comms::FaultKind::burst, comms::FaultKind::disconnect}) {
    test::FailureLinks links({{.kind = kind, .robot = 1, .at = 1.0, .duration = 2.0}});
    links.run_until(2.9);
    EXPECT_FALSE(links.stands(1)) << "robots have no watchdog";
    bool stood = false;
    while (links.now() < 5.0 && !links.session(1).up()) {
      links.run_until(links.now() + 0.001, false);
      stood = stood || links.stands(1);
    }
    EXPECT_TRUE(links.session(1).up());
    EXPECT_TRUE(stood) << "before any command";
    links.run_until(5.0);
    ASSERT_FALSE(links.told().empty());
    EXPECT_EQ(links.told().back().second, "link r2 up");
  }
}

/// The operator releases a robot, and its link is lost before the tick comes: or it was up for a moment only, of which
/// the tick has not heard. Neither lets the robot drive once its link is back.
TEST(FailureTable, AReleaseFromBeforeALossLetsNoRobotDriveWhenItsLinkIsBack) {
  for (const bool known_lost : {false, true}) {
    Group group(others_go_on());
    group.start();
    group.steps(10);
    const auto told = [](LinkState state) {
      EventList events;
      events.add(events::Link{1, state});
      return events;
    };
    const std::vector<OperatorCommand> release{commands::Hold{1, false}};
    group.step({commands::Hold{1, true}});
    if (known_lost) group.step({}, told(LinkState::down));
    const TickRecord& row = group.step(release, known_lost ? EventList{} : told(LinkState::down));
    EXPECT_TRUE(row.events.contains<events::Release>(1) && row.events.contains<events::Hold>(1))
        << describe(row.events) << ": the log says what became of it";
    EXPECT_TRUE(row.robots[1].is(stopped));
    group.steps(10);
    EXPECT_TRUE(group.step({}, told(LinkState::up)).robots[1].is(stopped)) << "it waits for the operator";
    group.steps(10);
    EXPECT_TRUE(group.rows.back().robots[1].is(stopped));
    EXPECT_FALSE(group.step(release).robots[1].is(stopped));
  }
}

/// A reply that comes a little late is no loss: the robot is stopped and goes on, the group never hears of it.
TEST(FailureTable, AReplyLostOnceIsNoLostLink) {
  test::FailureLinks links({{.kind = comms::FaultKind::burst, .robot = 1, .at = 1.001, .duration = 0.05}});
  links.run_until(2.0);
  EXPECT_EQ(links.session(1).status(links.now()).timeouts, 1u);
  EXPECT_FALSE(links.lost_at) << links.why;
}

// --- ... and then: the others keep clear, uncoupled
// ---------------------------------------------------------------------

TEST(FailureTable, TheOthersKeepClearOfALostRobotAndAreNotCoupledToIt) {
  Group group(others_go_on({"avoidance.enabled=true", "shield.enabled=true"}));
  group.start();
  group.steps(50);
  group.step({commands::Hold{1, true}});
  group.steps(1500);  // a minute: the leader comes round and meets it as well
  const core::Pose stood = group.robots[1].pose();
  for (std::size_t k = 60; k < group.rows.size(); ++k) {
    ASSERT_GE(group.rows[k].min_distance, 0.07) << "tick " << k;
    ASSERT_EQ(group.rows[k].robots[1].wheels, core::WheelSpeeds{});
  }
  EXPECT_NEAR(group.rows[60].robots[1].pose.x, stood.x, 1e-6);
  EXPECT_TRUE(std::isnan(group.rows[60].robots[1].error.x)) << "an error that is none couples nobody";
}

/// Degrade before stopping: full speed for half of links.blind_distance, then slower, then held; never a word to the
/// group.
TEST(FailureTable, ARobotWhoseCommandsStayUnconfirmedIsSlowedThenHeldAndTheGroupGoesOn) {
  Group group(others_go_on());
  group.start();
  group.steps(50);
  const double budget = group.experiment.links.blind_distance;
  double slower = 1e9;
  for (const double share : {0.0, 0.25, 0.5, 0.6, 0.8, 0.99, 1.0, 3.0}) {
    group.links.assign(4, LinkInput{.linked = true, .blind_way = 0.0});
    group.links[1].blind_way = share * budget;
    const RobotRecord robot = group.step().robots[1];
    EXPECT_EQ(robot.is(late), share > 0.5) << share;
    EXPECT_EQ(robot.is(stopped), share >= 1.0) << share;
    EXPECT_EQ(robot.command == core::Twist{}, share >= 1.0) << share;
    if (share > 0.5 && share < 1.0) {
      EXPECT_LT(std::abs(robot.command.v), slower) << share;
      slower = std::abs(robot.command.v);
    }
    EXPECT_EQ(std::isnan(robot.error.x), share >= 1.0) << "nobody is coupled to one that is held";
    EXPECT_NE(group.rows.back().robots[0].wheels, core::WheelSpeeds{});
    EXPECT_EQ(group.rows.back().phase, Phase::running);
  }
}

/// A robot whose link died keeps its last speed. The others see it roll and do not drive into it.
TEST(FailureTable, TheOthersKeepClearOfARobotThatRollsOn) {
  int rolled = 0;
  for (int seed = 0; seed < 16; ++seed) {
    Group group(others_go_on({"avoidance.enabled=true", "shield.enabled=true", "reference.spacing=0.15"}));
    group.start();
    group.steps(100 + 120 * seed);
    group.links.assign(4, LinkInput{.linked = true, .blind_way = 0.0});
    group.adrift = 2;
    group.links[2].blind_way = 1.0;
    for (int k = 0; k < 75; ++k) {
      const TickRecord& row = group.step();
      for (const std::size_t i : {0u, 1u, 3u}) {
        const core::Pose &a = row.robots[i].truth, &b = row.robots[2].truth;
        const double gap = core::distance(a, b);
        // What the healthy robot itself adds: it must not drive towards the other within reach.
        const double towards =
            row.robots[i].command.v * ((b.x - a.x) * std::cos(a.theta) + (b.y - a.y) * std::sin(a.theta));
        if (gap >= 0.075 || k <= 10) continue;
        EXPECT_LE(towards, 1e-4) << "start " << seed << ", tick " << k << ", robot " << i;
      }
      rolled += row.robots[2].wheels == core::WheelSpeeds{} ? 1 : 0;
    }
  }
  EXPECT_GT(rolled, 1000) << "it is commanded to stand, and does not";
}

// --- A robot drives otherwise than it is told ------------------------------------------------------------------------

TEST(FailureTable, ARobotThatDisobeysIsToldToStandAndLeavesTheGroup) {
  for (const bool ignored : {false, true})
    for (int seed = 0; seed < 16; ++seed) {
      Group group(others_go_on({ignored ? "failure.runaway=ignored" : "failure.runaway=others_go_on"}));
      group.start();
      group.steps(100 + 120 * seed);
      group.adrift = 2;
      group.robots[2].command({-300.0 - 20.0 * seed, -400.0});
      group.steps(10);  // 0.4 s
      const TickRecord& row = group.rows.back();
      EXPECT_EQ(row.robots[2].is(stopped), !ignored) << seed;
      EXPECT_EQ(row.robots[2].wheels == core::WheelSpeeds{}, !ignored) << seed;
      EXPECT_EQ(std::isnan(row.robots[2].error.x), !ignored) << "nobody is coupled to it; " << seed;
      for (const std::size_t other : {0u, 1u, 3u}) EXPECT_FALSE(row.robots[other].is(stopped)) << seed;
    }
}

// On the average of the sights between, one that reverses stands. Who follows it closely has no time for that.
TEST(FailureTable, ARobotThatReversesIsKnownWithinFiveTicks) {
  for (const double steps : {-400.0, -500.0, -700.0})
    for (int seed = 0; seed < 8; ++seed) {
      Group group(others_go_on({"reference.speed=0.06"}));
      group.start();
      group.steps(100 + 50 * seed);
      group.adrift = 2;
      group.robots[2].command({steps, steps});
      int ticks = 1;
      while (!group.step().robots[2].is(stopped) && ticks < 20) ++ticks;
      EXPECT_LE(ticks, 5) << steps << " steps/s, " << seed;
    }
}

// It collides with nobody, and gets nowhere: the operator must know why.
TEST(FailureTable, ARobotThatSpinsOnTheSpotIsToldToStandUntilItDoes) {
  for (const double steps : {400.0, -400.0, 700.0, -700.0})
    for (int seed = 0; seed < 8; ++seed) {
      Group group(others_go_on());
      group.start();
      group.steps(100 + 240 * seed);
      group.adrift = 1;
      group.robots[1].command({-steps, steps});
      group.steps(15);  // 0.6 s
      EXPECT_TRUE(group.rows.back().robots[1].is(stopped)) << steps << " steps/s, " << seed;
      EXPECT_EQ(group.rows.back().robots[1].wheels, core::WheelSpeeds{}) << steps << " steps/s, " << seed;
      group.steps(100);
      EXPECT_TRUE(group.rows.back().robots[1].is(stopped)) << "it still spins: " << steps << " steps/s, " << seed;
      group.robots[1].command({});
      group.adrift = 99;
      group.steps(25);
      EXPECT_FALSE(group.rows.back().robots[1].is(stopped)) << steps << " steps/s, " << seed;
    }
}

// Its battery is empty, a wheel hangs: nobody may count on the speed that it is told to have.
TEST(FailureTable, NobodyDrivesIntoARobotThatStandsThoughItIsToldToDrive) {
  double nearest_if_ignored = 1.0;
  for (const bool ignored : {false, true})
    for (const std::size_t stuck : {0u, 1u, 2u, 3u})
      for (int seed = 0; seed < 6; ++seed) {
        Group group(others_go_on({ignored ? "failure.runaway=ignored" : "failure.runaway=others_go_on"}));
        group.start();
        group.steps(100 + 150 * seed);
        group.adrift = stuck;
        group.robots[stuck].command({});
        double nearest = 1.0;
        for (int k = 0; k < 500; ++k) {
          group.step();
          for (std::size_t i = 0; i < group.robots.size(); ++i)
            if (i != stuck)
              nearest = std::min(nearest, core::distance(group.robots[i].pose(), group.robots[stuck].pose()));
        }
        if (ignored)
          nearest_if_ignored = std::min(nearest_if_ignored, nearest);
        else
          EXPECT_GT(nearest, 0.07) << "robot " << stuck << ", seed " << seed;
      }
  EXPECT_LT(nearest_if_ignored, 0.07) << "the control: these would have met";
}

TEST(FailureTable, ARobotThatObeysAgainDrivesAgain) {
  Group group(others_go_on());
  group.start();
  group.steps(300);
  group.adrift = 2;
  group.robots[2].command({500, -100});
  group.steps(50);
  EXPECT_EQ(group.rows.back().robots[2].wheels, core::WheelSpeeds{});
  group.adrift = 99;
  group.steps(50);
  std::vector<std::string> said;
  for (const TickRecord& row : group.rows)
    for (const Event& event : row.events)
      if (is<events::Runaway, events::Obeys>(event)) said.push_back(describe(event).substr(0, 10));
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0], "runaway r3");
  EXPECT_EQ(said[1], "obeys r3");
  EXPECT_NE(group.rows.back().robots[2].wheels, core::WheelSpeeds{});
}

TEST(FailureTable, NobodyIsTakenForARunawayWhoIsMovedOrBadlyMeasured) {
  for (const std::vector<std::string>& sets :
       {std::vector<std::string>{},
        {"simulation.pose_noise=0.002", "simulation.heading_noise=0.01745", "simulation.latency=0.08",
         "simulation.dropout=0.05", "simulation.slip=0.03", "robot_defaults.model=epuck2"},
        {R"(operator=[{t=5, does="kick r2 vx=0.6 vy=0.3"}, {t=20, does="move r1 x=0.3 y=0.3 theta=1"}])"}}) {
    Experiment e = others_go_on(sets);
    e.duration = 40.0;
    test::Rows rows;
    auto session = Session::open(e, Session::Clock::virtual_, {false, {&rows}});
    ASSERT_TRUE(session) << session.error();
    (*session)->run();
    EXPECT_EQ(rows.rows.size(), 1000u);
    EXPECT_EQ(rows.count<events::Runaway>(), 0);
  }
}

TEST(FailureTable, NobodyIsTakenForARunawayWhomAHandTurns) {
  for (const double angle : {0.8, 1.6, -2.4, 3.1}) {
    Group group(others_go_on());
    group.start();
    group.steps(150);
    const core::Pose pose = group.robots[1].pose();
    group.robots[1].place({pose.x, pose.y, core::wrap_angle(pose.theta + angle)});
    for (int k = 0; k < 50; ++k) EXPECT_FALSE(group.step().robots[1].is(stopped)) << angle;
  }
}

// --- A pose is older than the bridge time: within a tick. The camera is lost: within a tick of it
// ---------------------

TEST(FailureTable, APoseOlderThanTheBridgeTimeStopsItsRobotInThatTick) {
  Group group(others_go_on());
  group.start();
  group.steps(50);
  const double last_seen = group.now;
  while (group.now < last_seen + 1.0) {
    const core::Measurement kept = group.measured[1];
    group.blind = {1};
    const TickRecord& row = group.step();
    EXPECT_EQ(group.measured[1].captured_at, kept.captured_at);
    const bool old = row.robots[1].pose_age > group.experiment.estimation.bridge;
    ASSERT_EQ(row.robots[1].wheels == core::WheelSpeeds{}, old) << row.robots[1].pose_age;
    for (const std::size_t i : {0u, 2u, 3u}) ASSERT_NE(row.robots[i].wheels, core::WheelSpeeds{});
  }
}

TEST(FailureTable, ALostCameraStopsAllInTheTickAfterTheBridgeTime) {
  Group group(others_go_on());
  group.start();
  group.steps(50);
  group.blind = {0, 1, 2, 3};
  for (int k = 0; k < 25; ++k) {
    const TickRecord& row = group.step();
    for (const RobotRecord& robot : row.robots)
      ASSERT_EQ(robot.wheels == core::WheelSpeeds{}, robot.pose_age > group.experiment.estimation.bridge);
  }
  EXPECT_TRUE(group.rows.back().robots[0].is(lost));
}

// --- The tick misses deadlines or throws: within 100 ms
// ----------------------------------------------------------------

TEST(FailureTable, ASilentControlThreadStopsTheRobotsWithin100ms) {
  test::FailureLinks links({});
  links.run_until(1.041);  // the last tick was at 1.04 s
  for (std::size_t i = 0; i < links.robots; ++i) EXPECT_FALSE(links.stands(i));
  links.run_until(1.142, false);
  for (std::size_t i = 0; i < links.robots; ++i) {
    EXPECT_TRUE(links.stands(i)) << i;
    EXPECT_TRUE(links.session(i).stop_acknowledged());
    EXPECT_NE(links.session(i).status(links.now()).reason.find("no command for 0.1 s"), std::string::npos);
  }
}

TEST(FailureTable, ATickThatThrowsStopsTheRobots) {
  Experiment experiment =
      parse_experiment(paper_experiment().source, "platoon.toml", {"robot_defaults.link=loopback"}).value();
  experiment.links.command_silence = 1e3;  // the links do not do it by themselves
  SessionClock clock(true);
  auto plant = Plant::open(experiment, clock, {});
  ASSERT_TRUE(plant) << plant.error();
  std::atomic<int> rows{0};
  ControlLoop loop(experiment, clock, **plant, [&rows](const TickRecord&) {
    if (++rows == 20) throw std::runtime_error("a tick that throws");
  });
  ASSERT_TRUE(loop.post(commands::Start{}));
  loop.start_thread();
  ASSERT_TRUE(eventually([&] { return loop.failed(); }));
  EXPECT_NE(loop.reason().find("a tick that throws"), std::string::npos);
  ASSERT_TRUE(eventually([&] {
    const auto robots = (*plant)->robots();
    return std::all_of(robots.begin(), robots.end(), [](const RobotStatus& r) { return r.stop_acknowledged; });
  }));
  loop.end_thread();
}

TEST(FailureTable, TheCommandsOfATickInFlightDoNotPassAStop) {
  const Experiment experiment = paper_experiment();
  SessionClock clock(false);
  auto plant = Plant::open(experiment, clock, {});
  ASSERT_TRUE(plant) << plant.error();
  const std::vector<core::WheelSpeeds> drive(4, {500.0, 500.0});
  std::vector<core::Measurement> newest(4);
  std::vector<core::Pose> before(4), after(4);
  FrameTimes frame;
  (*plant)->measure(0.0, newest, before, frame);
  (*plant)->act(drive);
  (*plant)->measure(0.04, newest, after, frame);
  EXPECT_NEAR(core::distance(before[0], after[0]), 0.04 * 500.0 * core::DifferentialDrive{}.metres_per_step(), 1e-6);
  (*plant)->stop();
  (*plant)->act(drive);
  (*plant)->measure(0.08, newest, before, frame);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(before[i], after[i]) << i;
}

// --- STOP: within 40 ms, repeated until acknowledged
// ---------------------------------------------------------------------

TEST(FailureTable, StopStandsWithin40msAndIsRepeatedUntilItIsAcknowledged) {
  std::vector<comms::Fault> faults{{.kind = comms::FaultKind::latency, .median = 0.01, .p99 = 0.02},
                                   {.kind = comms::FaultKind::burst, .robot = 3, .at = 0.995, .duration = 0.4}};
  test::FailureLinks links(faults);
  links.run_until(1.0);
  links.stop();
  links.run_until(1.04, false);
  for (const std::size_t i : {0u, 1u, 2u}) EXPECT_TRUE(links.stands(i)) << i;
  EXPECT_FALSE(links.stands(3)) << "nothing reaches it";
  links.run_until(1.7 + 0.04, false);
  EXPECT_TRUE(links.stands(3)) << "after 0.1, 0.3 and 0.7 s: the first repetition that got through";
  EXPECT_GE(links.session(3).status(links.now()).timeouts, 3u);
  links.run_until(2.0, false);
  for (std::size_t i = 0; i < links.robots; ++i) EXPECT_TRUE(links.session(i).stop_acknowledged()) << i;
}

// --- Garbage, half lines, swallowed bytes, a restart: resynchronised within 1 s, counted, said
// ----------------------------

TEST(FailureTable, WhatGarblesALinkIsMendedCountedAndSaid) {
  using enum comms::FaultKind;
  const comms::Fault garbage{.kind = corruption, .at = 1.0, .duration = 0.3, .share = 0.5},
      half_a_line{.kind = stuck, .at = 1.0005, .duration = 0.0},
      swallowed{.kind = loss, .at = 1.0, .duration = 0.3, .share = 0.7},
      restart{.kind = reboot, .at = 1.0, .duration = 0.1},
      late{.kind = latency, .at = 1.0, .duration = 0.3, .median = 0.8, .p99 = 1.2};
  for (const comms::Fault& fault : {garbage, half_a_line, swallowed, restart, late}) {
    SCOPED_TRACE(word(fault.kind));
    test::FailureLinks links({fault}, 100.0);
    links.run_until(1.0);
    std::vector<std::uint64_t> before;
    for (std::size_t i = 0; i < links.robots; ++i) before.push_back(links.session(i).status(links.now()).exchanges);
    links.run_until(fault.end() + 1.5);
    std::uint64_t counted = 0;
    for (std::size_t i = 0; i < links.robots; ++i) {
      const comms::LinkStatus status = links.session(i).status(links.now());
      EXPECT_TRUE(links.session(i).up()) << i;
      EXPECT_GT(status.exchanges, before[i] + 5) << i << ": it is driven again";
      const std::uint64_t times = status.resynchronisations + status.timeouts;
      EXPECT_EQ(times > 0, !status.reason.empty()) << i;
      counted += times;
    }
    EXPECT_GE(counted, 1u);  // of half a line some halves do no harm
  }
}

// --- The same, as the program's threads do it
// ------------------------------------------------------------------------------

TEST(LinkWatch, ToldOnceWhenALinkIsLostAndWhenItIsBack) {
  LinkWatch watch({0, 2}, 0.2, true);
  std::vector<comms::LinkStatus> links(2);
  const auto look = [&](comms::LinkState state, double out_for) {
    links[0].state = comms::LinkState::up;
    links[1].state = state;
    links[1].out_for = out_for;
    const auto lost = watch.update(links);
    EventList events;
    watch.tell(events);
    return std::pair(lost, events);
  };
  EXPECT_TRUE(look(comms::LinkState::up, 0.0).second.empty());
  EXPECT_TRUE(look(comms::LinkState::stale, 0.19).second.empty()) << "within the bridge time";
  const auto [sentence, events] = look(comms::LinkState::stale, 0.21);
  ASSERT_TRUE(sentence);
  EXPECT_NE(sentence->find("robot 3: the link is stale"), std::string::npos) << *sentence;
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(describe(*events.begin()), "link r3 stale");
  EXPECT_TRUE(look(comms::LinkState::down, 0.3).second.empty()) << "it was lost before";
  EXPECT_TRUE(look(comms::LinkState::synchronising, 0.1).second.empty()) << "not back yet";
  const auto back = look(comms::LinkState::up, 0.0);
  ASSERT_EQ(back.second.size(), 1u);
  EXPECT_EQ(describe(*back.second.begin()), "link r3 up");
}

/// Ticks may be rare, and the thread that looks at the links may get no time.
TEST(LinkWatch, TellsOfALossThatIsOverBeforeItIsAskedFor) {
  LinkWatch watch({0}, 0.2, true);
  std::vector<comms::LinkStatus> links(1);
  const auto update = [&](comms::LinkState state) { return links[0].state = state, watch.update(links); };
  const auto told = [&] {
    EventList events;
    watch.tell(events);
    return describe(events);
  };
  links[0].reconnects = 1;  // while the session was opened
  EXPECT_FALSE(update(comms::LinkState::up));
  EXPECT_EQ(told(), "");
  update(comms::LinkState::down);
  ++links[0].reconnects;
  EXPECT_FALSE(update(comms::LinkState::up));
  EXPECT_EQ(told(), "link r1 down");
  update(comms::LinkState::up);
  EXPECT_EQ(told(), "link r1 up");

  ++links[0].reconnects;  // between two looks
  const auto lost = update(comms::LinkState::up);
  ASSERT_TRUE(lost);
  EXPECT_EQ(*lost, "robot 1: the link was down");
  EXPECT_EQ(told(), "link r1 down");
  EXPECT_FALSE(update(comms::LinkState::up));
  EXPECT_EQ(told(), "link r1 up");
}

/// The session's rows as they come.
struct Watched {
  explicit Watched(const Experiment& experiment, std::vector<comms::Fault> faults) {
    SessionOptions options;
    options.faults = std::move(faults);
    session = Session::open(experiment, Session::Clock::wall, options).value();
    newest.robots.resize(experiment.robots.size());  // until the first record comes
  }
  const TickRecord& look() {
    session->drain([this](const TickRecord& record) {
      newest = record;
      for (const Event& event : record.events) said += describe(event) + "; ";
    });
    return newest;
  }
  bool heard(const std::string& words) { return look(), said.find(words) != std::string::npos; }

  std::unique_ptr<Session> session;
  TickRecord newest;
  std::string said;
};

const std::vector<std::string> loopback{"robot_defaults.link=loopback", "failure.link_bridge=1"};
const comms::Fault broken{.kind = comms::FaultKind::disconnect, .robot = 1, .at = 1.0, .duration = 2.0};

TEST(FailureTable, OthersGoOnWithoutARobotWhoseLinkIsLost) {
  Watched run(others_go_on(loopback), {broken});
  EXPECT_TRUE(run.session->start());
  ASSERT_TRUE(eventually([&] { return run.heard("link r2"); })) << run.said;
  ASSERT_TRUE(eventually([&] { return run.look().robots[1].is(stopped); }));
  EXPECT_TRUE(run.heard("hold r2")) << run.said;
  std::string alarms;
  EXPECT_TRUE(eventually([&] {
    for (const std::string& one : run.session->alarms()) alarms += one + '\n';
    return alarms.find("robot 2: the link is") != std::string::npos;
  })) << "nobody is told: "
      << alarms;
  EXPECT_EQ(run.newest.phase, Phase::running);
  EXPECT_FALSE(run.session->failure());
  EXPECT_FALSE(run.session->hold_robot(1, false)) << "its link is lost";
  ASSERT_TRUE(eventually([&] { return run.heard("link r2 up"); })) << run.said;
  EXPECT_TRUE(run.look().robots[1].is(stopped)) << "it waits for the operator";
  EXPECT_TRUE(run.session->hold_robot(1, false));
  EXPECT_TRUE(eventually([&] { return run.heard("release r2") && !run.look().robots[1].is(stopped); })) << run.said;
  EXPECT_GE(run.session->robots()[1].reconnects, 1u);
  run.session->close();
  for (const RobotStatus& robot : run.session->robots()) EXPECT_TRUE(robot.stop_acknowledged);
}

TEST(FailureTable, AllStopWhenALinkIsLostUnlessTheFileSaysOtherwise) {
  Watched run(parse_experiment(paper_experiment().source, "platoon.toml", loopback).value(), {broken});
  EXPECT_TRUE(run.session->start());
  ASSERT_TRUE(eventually([&] { return run.look().phase == Phase::stopped; })) << run.said;
  ASSERT_TRUE(run.session->failure());
  EXPECT_NE(run.session->failure()->find("robot 2: the link is"), std::string::npos) << *run.session->failure();
  EXPECT_TRUE(run.heard("stop"));
}

/// The window keeps the session open: who is out of reach as the run ends would drive on, and nobody would know.
TEST(FailureTable, ARunThatEndsByItselfStopsEveryRobotUntilItAcknowledges) {
  std::vector<std::string> brief = loopback;
  brief.insert(brief.end(), {"duration=1", "perturb=[]", "failure.link_bridge=10"});
  Watched run(others_go_on(brief), {{.kind = comms::FaultKind::burst, .robot = 1, .at = 0.6, .duration = 4.0}});
  EXPECT_TRUE(run.session->start());
  ASSERT_TRUE(eventually([&] { return run.look().phase == Phase::finished; }));
  ASSERT_TRUE(eventually([&] { return run.session->robots()[0].stop_acknowledged; }))
      << "it stands, and is not known to";
  ASSERT_TRUE(eventually([&] { return run.session->robots()[1].stop_acknowledged; })) << "it is back in reach";
  EXPECT_EQ(run.look().phase, Phase::finished);
}

TEST(Session, TellsWhoTheRobotsAreAndHowTheirLinksDo) {
  Watched run(others_go_on(loopback), {});
  EXPECT_TRUE(run.session->start());
  ASSERT_TRUE(eventually([&] {
    const LinkRecord& link = run.look().robots[0].link;
    return run.newest.tick > 10 && link.state == LinkState::up && link.battery > 0.0 && link.left_steps > 0.0 &&
           link.round_trip > 0.0 && link.round_trip_p99 >= link.round_trip && link.bytes > 0.0 && link.losses >= 0.0;
  }));
  const RobotStatus robot = run.session->robots()[0];
  EXPECT_EQ(robot.version, "Version 2.0 January 2018 GCtronic");
  EXPECT_NEAR(robot.battery, 3.9, 0.01);
  EXPECT_GT(robot.bytes_sent, 0u);
  EXPECT_GT(robot.bytes_received, 0u);
  EXPECT_GE(robot.round_trip_p99, robot.round_trip);
}

}  // namespace
}  // namespace skein::app
