// A simulation that is stepped, or goes at another speed than real time.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include "app/experiment/experiment_file.h"
#include "app/session/session.h"
#include "tests/app/rows.h"
#include "tests/eventually.h"

namespace skein::app {
namespace {

using namespace std::chrono_literals;

using test::Rows;

using test::eventually;

/// The phase and the tick of the newest record that `drain` brings.
struct Watch {
  explicit Watch(Session& of) : session(of) {}
  bool sees(const std::function<bool(const TickRecord&)>& what) {
    return eventually([&] {
      bool seen = false;
      session.drain([&](const TickRecord& record) {
        newest = record;
        seen = seen || what(record);
      });
      return seen;
    });
  }
  Session& session;
  TickRecord newest;
};

TEST(Pace, GivesTheRunOfTheVirtualClockAndSkipsNoTick) {
  Experiment experiment = paper_experiment();
  experiment.duration = 30.0;
  Rows in_step, paced;
  auto virtual_session = Session::open(experiment, Session::Clock::virtual_, {false, {&in_step}});
  (*virtual_session)->run();
  auto session = Session::open(experiment, Session::Clock::wall, {false, {&paced}});
  ASSERT_TRUE((*session)->set_speed(50.0).has_value());
  // The first tick at the new speed: what came before ran in real time.
  Watch watch(**session);
  ASSERT_TRUE(watch.sees([](const TickRecord& record) { return std::isnan(record.compute_time); }));
  EXPECT_TRUE((*session)->start());
  ASSERT_TRUE(watch.sees([](const TickRecord& record) { return record.phase == Phase::finished; }));
  (*session)->close();
  ASSERT_EQ(paced.rows.size(), in_step.rows.size());
  for (std::size_t k = 0; k < paced.rows.size(); ++k) {
    ASSERT_EQ(paced.rows[k].tick, in_step.rows[k].tick);
    for (std::size_t i = 0; i < paced.rows[k].robots.size(); ++i) {
      // Not the bits: its clock began at another time.
      ASSERT_NEAR(paced.rows[k].robots[i].truth.x, in_step.rows[k].robots[i].truth.x, 1e-6) << paced.rows[k].t;
      ASSERT_NEAR(paced.rows[k].robots[i].truth.y, in_step.rows[k].robots[i].truth.y, 1e-6) << paced.rows[k].t;
    }
  }
  EXPECT_EQ((*session)->dropped_rows(), 0u);
}

TEST(Pace, AtSpeed1ASimulationIsTheSameHoweverBusyTheMachineIs) {
  Experiment experiment = paper_experiment();
  experiment.duration = 2.0;
  // The largest distance of a tick from its time, in real time. [s]
  const auto off = [&](bool paced) {
    Rows rows;
    auto session = Session::open(experiment, Session::Clock::wall, {.sinks = {&rows}, .paced = paced});
    EXPECT_TRUE((*session)->start());
    Watch watch(**session);
    EXPECT_TRUE(watch.sees([](const TickRecord& record) { return record.phase == Phase::finished; }));
    EXPECT_TRUE((*session)->timing_so_far().has_value()) << "how late ticks are is said of both";
    (*session)->close();
    const auto ticks = static_cast<std::size_t>(rows.rows.back().tick - rows.rows.front().tick + 1);
    EXPECT_EQ(paced ? rows.rows.size() : ticks, 50u) << "by the wall clock a busy machine misses some, and counts them";
    double largest = 0.0;
    for (std::size_t k = 0; k < rows.rows.size(); ++k) {
      const double due = rows.rows.front().now + static_cast<double>(k) * experiment.period();
      largest = std::max(largest, std::abs(rows.rows[k].now - due));
    }
    return largest;
  };
  EXPECT_LT(off(true), 1e-9);
  EXPECT_GT(off(false), 1e-9) << "control: by the wall clock every tick is a little late";
}

TEST(Pace, StepsFromReadyAndFromPaused) {
  const Experiment experiment = paper_experiment();
  Rows rows;
  auto session = Session::open(experiment, Session::Clock::wall, {false, {&rows}});
  Watch watch(**session);
  for (int tick = 1; tick <= 3; ++tick) {
    ASSERT_TRUE((*session)->step().has_value());
    ASSERT_TRUE(watch.sees([&](const TickRecord& r) { return r.phase == Phase::paused && r.tick == tick; })) << tick;
  }
  EXPECT_TRUE((*session)->resume());
  ASSERT_TRUE(watch.sees([](const TickRecord& r) { return r.phase == Phase::running && r.tick > 5; }));
  ASSERT_TRUE((*session)->step().has_value());  // nothing to step from: it runs on
  const std::int64_t now = watch.newest.tick;
  ASSERT_TRUE(watch.sees([&](const TickRecord& r) { return r.phase == Phase::running && r.tick > now + 5; }));
  (*session)->close();
}

TEST(Pace, IsRefusedWhereSomethingLivesInRealTime) {
  auto session = Session::open(paper_experiment(), Session::Clock::wall);
  EXPECT_FALSE((*session)->set_speed(0.0).has_value());
  EXPECT_FALSE((*session)->set_speed(51.0).has_value());
  EXPECT_FALSE((*session)->set_speed(std::nan("")).has_value());
  EXPECT_EQ((*session)->speed(), 1.0);
  Experiment linked = paper_experiment();
  linked.robots[1].link = RobotSpec::Link::loopback;
  EXPECT_NE(real_time_reason(linked).value_or("").find("robot 2"), std::string::npos);
  Experiment seen = paper_experiment();
  seen.camera.source = "synthetic";
  EXPECT_NE(real_time_reason(seen).value_or("").find("camera"), std::string::npos);
  EXPECT_FALSE(real_time_reason(paper_experiment()).has_value());
}

}  // namespace
}  // namespace skein::app
