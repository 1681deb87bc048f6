// What the group does when a robot's link is lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "app/control_tick.h"
#include "app/experiment_file.h"
#include "app/link_watch.h"
#include "app/session.h"
#include "core/simulation/simulated_robot.h"

namespace skein::app {
namespace {

using comms::LinkState;

Experiment others_go_on(std::vector<std::string> sets = {}) {
  sets.push_back("failure.link_lost=others_go_on");
  return parse_experiment(paper_experiment().source, "platoon.toml", sets).value();
}

/// Four ideal robots around a tick, one of which the test holds.
struct Group {
  explicit Group(const Experiment& e) : experiment(e), tick(e), measured(e.robots.size()) {
    const auto reference = make_reference(e);
    for (std::size_t i = 0; i < e.robots.size(); ++i) {
      robots.emplace_back(e.robots[i].drive, e.robots[i].motor, e.simulation, e.seed, i);
      robots.back().place(reference->at(i, 0.0).pose);
    }
  }
  const TickRecord& step(std::vector<OperatorCommand> commands = {}) {
    now += experiment.period();
    for (std::size_t i = 0; i < robots.size(); ++i) {
      robots[i].step(experiment.period());
      measured[i] = robots[i].measure(now);
    }
    TickInput input;
    input.now = now;
    input.measurements = measured;
    input.commands = commands;
    const TickRecord& record = tick.step(input);
    for (std::size_t i = 0; i < robots.size(); ++i) robots[i].command(record.robots[i].wheels);
    rows.push_back(record);
    return rows.back();
  }
  void steps(int count) {
    for (int k = 0; k < count; ++k) step();
  }
  void start() { step({{OperatorCommand::Kind::start, {}, 0.0}}); }

  Experiment experiment;
  ControlTick tick;
  std::vector<core::SimulatedRobot> robots;
  std::vector<core::Measurement> measured;
  std::vector<TickRecord> rows;
  double now = 0.0;
};

TEST(Held, TheOthersKeepClearOfTheOneThatStands) {
  Group group(others_go_on({"avoidance.enabled=true", "shield.enabled=true"}));
  group.start();
  group.steps(50);
  group.step({{.kind = OperatorCommand::Kind::hold, .number = 1}});
  group.steps(1500);  // a minute: the leader comes round and meets it as well
  const core::Pose stood = group.robots[1].pose();
  for (std::size_t k = 60; k < group.rows.size(); ++k) {
    ASSERT_GE(group.rows[k].min_distance, 0.07) << "tick " << k;
    ASSERT_EQ(group.rows[k].robots[1].wheels, core::WheelSpeeds{});
  }
  EXPECT_NEAR(group.rows[60].robots[1].pose.x, stood.x, 1e-6);
}

TEST(LinkWatch, ToldOnceWhenALinkIsLostAndWhenItIsBack) {
  LinkWatch watch({0, 2}, 0.2, true);
  std::vector<comms::LinkStatus> links(2);
  const auto look = [&](LinkState state, double out_for) {
    links[0].state = LinkState::up;
    links[1].state = state;
    links[1].out_for = out_for;
    const auto lost = watch.look(links);
    EventList events;
    watch.tell(events);
    return std::pair(lost, events);
  };
  EXPECT_TRUE(look(LinkState::up, 0.0).second.empty());
  EXPECT_TRUE(look(LinkState::stale, 0.19).second.empty()) << "within the bridge time";
  const auto [sentence, events] = look(LinkState::stale, 0.21);
  ASSERT_TRUE(sentence);
  EXPECT_NE(sentence->find("robot 3: the link is stale"), std::string::npos) << *sentence;
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(describe(*events.begin()), "link r3 stale");
  EXPECT_TRUE(look(LinkState::down, 0.3).second.empty()) << "it was lost before";
  EXPECT_TRUE(look(LinkState::synchronising, 0.1).second.empty()) << "not back yet";
  const auto back = look(LinkState::up, 0.0);
  ASSERT_EQ(back.second.size(), 1u);
  EXPECT_EQ(describe(*back.second.begin()), "link r3 up");
}

// --- A session
// --------------------------------------------------------------------------------------------------------

template <typename Condition>
bool eventually(Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
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

TEST(Session, OthersGoOnWithoutARobotWhoseLinkIsLost) {
  Watched run(others_go_on(loopback), {broken});
  run.session->start();
  ASSERT_TRUE(eventually([&] { return run.heard("link r2"); })) << run.said;
  ASSERT_TRUE(eventually([&] { return run.look().robots[1].is(stopped); }));
  EXPECT_TRUE(run.heard("hold r2")) << run.said;
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

TEST(Session, AllStopWhenALinkIsLostUnlessTheFileSaysOtherwise) {
  Watched run(parse_experiment(paper_experiment().source, "platoon.toml", loopback).value(), {broken});
  run.session->start();
  ASSERT_TRUE(eventually([&] { return run.look().phase == Phase::stopped; })) << run.said;
  ASSERT_TRUE(run.session->failure());
  EXPECT_NE(run.session->failure()->find("robot 2: the link is"), std::string::npos) << *run.session->failure();
  EXPECT_TRUE(run.heard("stop"));
}

TEST(Session, TellsWhoTheRobotsAreAndHowTheirLinksDo) {
  Watched run(others_go_on(loopback), {});
  run.session->start();
  ASSERT_TRUE(eventually([&] {
    const LinkRecord& link = run.look().robots[0].link;
    return run.newest.tick > 10 && link.state == LinkState::up && link.battery > 0.0 && link.left_steps > 0.0 &&
           link.round_trip > 0.0;
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
