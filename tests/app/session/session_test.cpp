// Whole sessions: every arrow of a run, in step on the virtual clock and on threads on the wall clock.
#include "app/session/session.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "tests/app/rows.h"
#include "tests/eventually.h"
#include "tests/places.h"

namespace skein::app {
namespace {

using test::Rows;

Experiment experiment_with(const std::vector<std::string>& sets) {
  auto experiment = parse_experiment(paper_experiment().source, "platoon.toml", sets);
  EXPECT_TRUE(experiment) << (experiment ? "" : experiment.error().front().message());
  return *experiment;
}

const std::vector<std::string> through_camera_and_protocol{
    "robot_defaults.link=loopback", "robot_defaults.model=epuck2", "camera.source=synthetic", "camera.calibration="};

using test::eventually;

TEST(Session, ThePapersExperimentOnTheVirtualClock) {
  Rows sink;
  auto session = Session::open(paper_experiment(), Session::Clock::virtual_, {false, {&sink}});
  ASSERT_TRUE(session) << session.error();
  EXPECT_EQ((*session)->run(), Phase::finished);
  ASSERT_EQ(sink.rows.size(), 2100u);
  EXPECT_EQ(sink.count<events::Perturb>(), 3);
  EXPECT_LT(sink.rows.back().tracking_error(), 2e-3);
  for (std::size_t k = 0; k < sink.rows.size(); ++k) ASSERT_EQ(sink.rows[k].tick, static_cast<std::int64_t>(k));
}

TEST(Session, TheSameSeedGivesTheSameBits) {
  const Experiment noisy =
      experiment_with({"simulation.pose_noise=0.001", "simulation.heading_noise=0.01", "simulation.latency=0.06",
                       "simulation.dropout=0.05", "simulation.slip=0.02", "robot_defaults.model=epuck1"});
  const auto commands = [](const Experiment& experiment) {
    Rows sink;
    auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&sink}});
    (*session)->run();
    std::vector<double> all;
    for (const TickRecord& row : sink.rows)
      for (const RobotRecord& robot : row.robots)
        all.insert(all.end(), {robot.truth.x, robot.command.v, robot.command.omega, robot.wheels.left});
    return all;
  };
  const std::vector<double> once = commands(noisy);
  EXPECT_EQ(once, commands(noisy));
  Experiment other = noisy;
  other.seed = 2;
  EXPECT_NE(once, commands(other));
}

TEST(Session, LoopbackInStepDrivesThroughCameraAndProtocol) {
  Rows sink;
  std::vector<std::string> sets = through_camera_and_protocol;
  sets.push_back("duration=6");
  sets.push_back("perturb.1.t=1");
  sets.push_back("perturb.2.t=1");
  sets.push_back("perturb.3.t=1");
  sets.push_back("perturb.1.dx=0.01");
  sets.push_back("perturb.1.dy=-0.01");
  sets.push_back("perturb.2.dx=0");
  sets.push_back("perturb.2.dy=0");
  sets.push_back("perturb.3.dx=0");
  sets.push_back("perturb.3.dy=0");
  auto session = Session::open(experiment_with(sets), Session::Clock::virtual_, {false, {&sink}});
  ASSERT_TRUE(session) << session.error();
  EXPECT_EQ((*session)->run(), Phase::finished);
  EXPECT_FALSE((*session)->failure()) << *(*session)->failure();
  ASSERT_EQ(sink.rows.size(), 150u);
  double squares = 0.0;
  int count = 0;
  for (const TickRecord& row : sink.rows)
    for (const RobotRecord& robot : row.robots) {
      ASSERT_FALSE(robot.is(lost));
      squares += std::pow(core::distance(robot.measurement.pose, robot.truth), 2);
      ++count;
    }
  EXPECT_LT(std::sqrt(squares / count), 0.3e-3) << "rms of the camera against the truth";
  EXPECT_LT(sink.rows.back().tracking_error(), 5e-3);
  (*session)->close();
  for (const RobotStatus& robot : (*session)->robots()) {
    EXPECT_TRUE(robot.stop_acknowledged) << robot.reason;
    EXPECT_GE(robot.exchanges, 150u);
  }
}

TEST(Session, OnTheWallClockTheOperatorIsObeyed) {
  Rows sink;
  auto opened = Session::open(paper_experiment(), Session::Clock::wall, {false, {&sink}});
  ASSERT_TRUE(opened) << opened.error();
  Session& session = **opened;
  TickRecord latest;
  const auto drain = [&] { return session.drain([&](const TickRecord& record) { latest = record; }), true; };
  ASSERT_TRUE(eventually([&] { return drain() && latest.robots.size() == 4; })) << "poses flow before the start";
  EXPECT_EQ(latest.phase, Phase::ready);

  EXPECT_TRUE(session.start());
  ASSERT_TRUE(eventually([&] { return drain() && latest.tick >= 5; }));
  ASSERT_TRUE(session.move_robot(1, {0.2, 0.2, 0.0}));
  EXPECT_TRUE(session.set_gain(core::GainName::k_xx, 0.01));
  ASSERT_TRUE(eventually([&] { return drain() && core::distance(latest.robots[1].truth, {0.2, 0.2, 0.0}) < 0.05; }));
  EXPECT_TRUE(session.pause());
  ASSERT_TRUE(eventually([&] { return drain() && latest.phase == Phase::paused; }));
  EXPECT_TRUE(session.resume());
  ASSERT_TRUE(eventually([&] { return drain() && latest.phase == Phase::running; }));
  session.stop();
  ASSERT_TRUE(eventually([&] { return drain() && latest.phase == Phase::stopped; }));
  for (const RobotRecord& robot : latest.robots) EXPECT_EQ(robot.wheels, core::WheelSpeeds{});
  session.close();

  // The log of the run has them.
  EXPECT_EQ(sink.count<events::Start>(), 1);
  EXPECT_EQ(sink.count<events::Move>(), 1);
  EXPECT_EQ(sink.count<events::Gain>(), 1);
  EXPECT_EQ(sink.count<events::Pause>(), 1);
  EXPECT_EQ(sink.count<events::Resume>(), 1);
  EXPECT_EQ(sink.count<events::Stop>(), 1);
  EXPECT_FALSE(session.failure());
}

TEST(Session, StartsNobodyWhoHasNotBeenSeen) {
  auto session = Session::open(experiment_with({"simulation.dropout=1"}), Session::Clock::wall);  // no pose ever comes
  ASSERT_TRUE(session) << session.error();
  int turns = 0;
  bool started = false;
  (*session)->run([&] {
    (*session)->drain([&](const TickRecord& record) { started = started || record.phase != Phase::ready; });
    return ++turns < 100;
  });
  EXPECT_GE(turns, 100) << "the run waits";
  EXPECT_FALSE(started);
}

TEST(Session, DrivesARobotThatIsElsewhereToItsStartFirst) {
  auto session = Session::open(experiment_with({"staging.automatic=true"}), Session::Clock::wall);
  ASSERT_TRUE(session) << session.error();
  TickRecord latest;
  const auto drain = [&] {
    (*session)->drain([&](const TickRecord& record) {
      if (latest.robots.empty() || latest.phase == Phase::ready) latest = record;
    });
    return true;
  };
  ASSERT_TRUE(eventually([&] { return drain() && !latest.robots.empty(); }));
  const core::Pose start = latest.robots[3].truth;
  ASSERT_TRUE((*session)->move_robot(3, {start.x - 0.1, start.y, start.theta}));
  ASSERT_TRUE(eventually([&] { return drain() && core::distance(latest.robots[3].pose, start) > 0.05; }));
  (*session)->run([&] { return drain() && latest.phase == Phase::ready; });
  EXPECT_EQ(latest.phase, Phase::staging);
}

TEST(Session, StopReachesEveryRobotOnTheWallClock) {
  auto opened = Session::open(experiment_with(through_camera_and_protocol), Session::Clock::wall);
  ASSERT_TRUE(opened) << opened.error();
  Session& session = **opened;
  TickRecord latest;
  const auto drain = [&] { return session.drain([&](const TickRecord& record) { latest = record; }), true; };
  EXPECT_TRUE(session.start());
  ASSERT_TRUE(eventually([&] {
    return drain() && latest.tick > 5 && std::abs(latest.robots[0].command.v) > 0.01 && !latest.robots[0].is(lost);
  }));
  session.stop();
  ASSERT_TRUE(eventually([&] {
    const std::vector<RobotStatus> robots = session.robots();
    return std::all_of(robots.begin(), robots.end(), [](const RobotStatus& robot) { return robot.stop_acknowledged; });
  }));
  // They stand, and stay where they are.
  ASSERT_TRUE(eventually([&] { return drain() && latest.phase == Phase::stopped; }));
  const core::Pose where = latest.robots[0].truth;
  const double when = latest.now;
  ASSERT_TRUE(eventually([&] { return drain() && latest.now > when + 0.2; }));
  EXPECT_EQ(latest.robots[0].truth, where);
}

/// Every stage of a real-time loop with camera and links is known, none is negative, and the parts make the whole.
TEST(Session, TellsHowLongEveryStageTook) {
  auto session = Session::open(
      experiment_with({"robot_defaults.link=loopback", "camera.source=synthetic", "failure.link_bridge=2"}),
      Session::Clock::wall);
  ASSERT_TRUE(session) << session.error();
  // A busy machine's robots may answer after the next tick: then nothing is known of that stage.
  const auto is_complete = [](const Latency& latency) {
    return !std::isnan(latency.total) && !std::isnan(latency[Stage::acknowledge]);
  };
  TickRecord complete;
  ASSERT_TRUE(eventually([&] {
    (*session)->drain([&](const TickRecord& record) {
      if (is_complete(record.latency)) complete = record;
    });
    return is_complete(complete.latency);
  }));
  double sum = 0.0;
  for (std::size_t stage = 0; stage < stages; ++stage) {
    EXPECT_GE(complete.latency.of[stage], 0.0) << word(static_cast<Stage>(stage));
    sum += complete.latency.of[stage];
  }
  sum -= complete.latency[Stage::capture] + complete.latency[Stage::acknowledge];
  EXPECT_NEAR(complete.latency.total, sum, 1e-9);
}

TEST(Session, ARobotThatIsNotThereIsNamed) {
  const auto calibration = test::in_source("resources/cameras/overhead.toml");
  auto session = Session::open(experiment_with({"robot.4.link=serial:/dev/nowhere", "robot.4.model=epuck2",
                                                "camera.source=images:/nowhere", "camera.calibration=" + calibration}),
                               Session::Clock::wall);
  ASSERT_FALSE(session);
  EXPECT_NE(session.error().find("robot 4"), std::string::npos) << session.error();
  EXPECT_NE(session.error().find("/dev/nowhere"), std::string::npos) << session.error();
}

TEST(Session, ACalibrationThatIsMissingIsNamedBeforeARobotIsReached) {
  auto session = Session::open(experiment_with({"robot.4.link=serial:/dev/nowhere", "robot.4.model=epuck2",
                                                "camera.source=images:/nowhere", "camera.calibration=cal.toml"}),
                               Session::Clock::wall);
  ASSERT_FALSE(session);
  EXPECT_NE(session.error().find("cal.toml: cannot be read"), std::string::npos) << session.error();
  EXPECT_EQ(session.error().find("robot 4"), std::string::npos) << session.error();
}

TEST(Session, ACameraThatIsNotThereIsNamed) {
  Experiment experiment = paper_experiment();
  experiment.camera.source = "images:/nowhere";
  auto session = Session::open(experiment, Session::Clock::wall);
  ASSERT_FALSE(session);
  EXPECT_NE(session.error().find("calibration"), std::string::npos) << session.error();
}

TEST(Session, ASinkThatFailsStopsTheRun) {
  class Full final : public RecordSink {
   public:
    void record(const TickRecord& record) override {
      if (record.tick >= 20) throw std::runtime_error("no space left on device");  // a tick that is late has none
    }
  };
  for (const auto clock : {Session::Clock::wall, Session::Clock::virtual_}) {
    Full full;
    auto session = Session::open(paper_experiment(), clock, {false, {&full}});
    ASSERT_TRUE(session);
    EXPECT_EQ((*session)->run(), Phase::stopped);
    ASSERT_TRUE((*session)->failure());
    EXPECT_NE((*session)->failure()->find("no space left"), std::string::npos);
  }
}

TEST(Session, TheKeepOnQuestionStopsAVirtualRun) {
  Rows sink;
  auto session = Session::open(paper_experiment(), Session::Clock::virtual_, {false, {&sink}});
  ASSERT_TRUE(session);
  EXPECT_EQ((*session)->run([&] { return sink.rows.size() < 100; }), Phase::stopped);
  EXPECT_LT(sink.rows.size(), 130u);
  EXPECT_EQ(sink.count<events::Stop>(), 1);
}

TEST(Session, RealRobotsAreNotMovedByHandOnTheScreen) {
  auto session = Session::open(paper_experiment(), Session::Clock::wall);
  ASSERT_TRUE(session);
  EXPECT_FALSE((*session)->move_robot(7, {}));
  EXPECT_TRUE((*session)->move_robot(0, {}));
}

}  // namespace
}  // namespace skein::app
