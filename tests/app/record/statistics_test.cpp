// The sum of a run, on error histories whose settling times are known.
#include "app/record/statistics.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <nlohmann/json.hpp>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_reader.h"
#include "tests/app/fixture.h"

namespace skein::app {
namespace {

/// Two robots, a metre apart unless told otherwise, at 25 Hz.
class History {
 public:
  TickRecord row(double tracking = 0.0, double formation = 0.0, double distance = 1.0) {
    TickRecord r;
    r.phase = Phase::running;
    r.tick = tick_++;
    r.t = static_cast<double>(r.tick) / 25.0;
    r.period = 0.04;
    r.delta = {formation};
    r.min_distance = distance;
    r.robots.resize(2);
    r.robots[1].nominal.pose.x = distance;
    for (RobotRecord& robot : r.robots)
      robot.pose = robot.truth = robot.nominal.pose, robot.measurement.captured_at = r.t;
    r.robots[0].pose.y = tracking;
    return r;
  }
  void add(const TickRecord& r) { statistics_.record(r); }
  void add(int count, double tracking, double formation) {
    for (int k = 0; k < count; ++k) add(row(tracking, formation));
  }
  /// A hand, at the next row.
  void perturb(double tracking, double formation, const Event& event = events::Perturb{0, 0.1, 0.0, 0.0}) {
    TickRecord r = row(tracking, formation);
    r.events.add(event);
    add(r);
  }
  Statistics::Summary summary() const { return statistics_.summary(); }

 private:
  static Experiment two_robots() {
    Experiment e;
    e.robots.resize(2);
    return e;
  }
  Statistics statistics_{two_robots()};
  std::int64_t tick_ = 0;
};

TEST(Statistics, FindsWhenErrorsSettledForGood) {
  History h;
  h.add(25, 0.0, 0.0);
  h.perturb(0.1, 0.1);     // at 1 s
  h.add(24, 0.1, 0.02);    // to 1.96 s
  h.add(25, 0.1, 0.008);   // from 2 s: formation below 1 cm
  h.add(25, 0.008, 0.02);  // from 3 s: and out of it again, while tracking is below 1 cm
  h.add(25, 0.004, -0.006);
  h.add(25, 0.004, -0.004);
  const PerturbationResult p = h.summary().perturbations.at(0);
  EXPECT_DOUBLE_EQ(p.t, 1.0);
  EXPECT_EQ(p.robot, 0);
  EXPECT_EQ(p.what, "perturb r1 dx=0.1 dy=0 dtheta=0");
  EXPECT_NEAR(*p.settling.formation_1cm, 3.0, 1e-9);
  EXPECT_NEAR(*p.settling.formation_5mm, 4.0, 1e-9);
  EXPECT_NEAR(*p.settling.tracking_1cm, 2.0, 1e-9);
  EXPECT_NEAR(*p.settling.tracking_5mm, 3.0, 1e-9);
  EXPECT_FALSE(p.formation_first());
}

/// Robots on the way to their starts: the run has no tick, and nothing has been measured of it.
TEST(Statistics, ARunThatIsStoppedBeforeItsStartHasNoTick) {
  History h;
  TickRecord on_the_way = h.row(0.5, 0.5);
  on_the_way.phase = Phase::staging;
  h.add(on_the_way);
  TickRecord stop = on_the_way;
  stop.phase = Phase::stopped;
  stop.events.add(events::Stop{});
  h.add(stop);
  const Statistics::Summary summary = h.summary();
  EXPECT_EQ(summary.ticks, 0);
  EXPECT_EQ(summary.duration, 0.0);
  EXPECT_TRUE(std::isnan(summary.final_error));
  EXPECT_TRUE(summary.stopped);
  ASSERT_EQ(summary.events.size(), 1U);
  EXPECT_EQ(summary.events.front().second, "stop");

  History running;
  running.add(3, 0.0, 0.0);
  TickRecord stopped = running.row();
  stopped.phase = Phase::stopped;
  running.add(stopped);
  EXPECT_EQ(running.summary().ticks, 4) << "the control: the tick that stops a run is one of it";
}

/// Of the same in a file, where the row looks like that of a run.
TEST(Statistics, ARowOfAFileThatStopsItsRunIsKnown) {
  const Experiment e = paper_experiment();
  TickRecord row;
  row.phase = Phase::running;
  find_end(e, row);
  EXPECT_EQ(row.phase, Phase::running) << "the control";
  row.events.add(events::Stop{});
  find_end(e, row);
  EXPECT_EQ(row.phase, Phase::stopped);
  row.phase = Phase::running;
  row.tick = e.ticks();
  find_end(e, row);
  EXPECT_EQ(row.phase, Phase::finished) << "on the way back to the starts";
}

TEST(Statistics, AFormationThatWaitsIsWholeOnItsOwnClockAndTracksOnTheExperiments) {
  Experiment e = paper_experiment();
  e.avoidance.formation_waits = true;
  const auto reference = make_reference(e);
  Statistics statistics(e);
  TickRecord row;
  row.phase = Phase::running;
  row.robots.resize(4);
  row.delta.assign(3, 0.0);
  // It stands from 1 s to 3 s, during which robot 1 is 10 cm off, and is on time again at 5 s.
  for (int k = 0; k < 200; ++k) {
    row.t = 0.04 * k;
    row.lag = row.t < 1.0 ? 0.0 : row.t < 3.0 ? row.t - 1.0 : row.t < 5.0 - 1e-9 ? 5.0 - row.t : 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      row.robots[i].nominal = reference->at(i, row.t - row.lag);
      row.robots[i].pose = row.robots[i].truth = row.robots[i].nominal.pose;
      row.robots[i].measurement.captured_at = row.t;
    }
    if (row.t >= 1.0 && row.t < 3.5) row.robots[0].pose.x += 0.1;
    row.events.clear();
    if (k == 25) row.events.add(events::Perturb{0, 0.1, 0.0, 0.0});
    statistics.record(row);
  }
  const Statistics::Summary summary = statistics.summary();
  const Settling& settling = summary.perturbations.at(0).settling;
  EXPECT_NEAR(settling.whole_1cm.value(), 1.0, 0.09) << "3.52 s less a lag of 1.48 s, from 1 s on";
  EXPECT_NEAR(settling.tracking_1cm.value(), 3.8, 0.05) << "0.2 s before it is on time it is within 1 cm";
  EXPECT_NEAR(settling.relative_1cm.value(), 2.52, 0.05);
  EXPECT_TRUE(summary.perturbations.at(0).relative_first());
  EXPECT_NEAR(summary.largest_lag.value(), 2.0, 0.05);
  EXPECT_EQ(summary.final_lag, 0.0);
  EXPECT_NE(as_lines(summary).find("perturbation_1_whole_1cm: 1.0"), std::string::npos) << as_lines(summary);
  EXPECT_NE(as_lines(summary).find("final_lag: 0.0"), std::string::npos);
}

TEST(Statistics, AWindowEndsAtTheNextPerturbation) {
  History h;
  h.perturb(0.1, 0.1);
  h.add(49, 0.1, 0.001);  // tracking never settles
  h.perturb(0.1, 0.1, events::Move{1, {0.1, 0.0, 0.0}});
  h.add(25, 0.001, 0.1);  // formation never settles
  const auto perturbations = h.summary().perturbations;
  ASSERT_EQ(perturbations.size(), 2u);
  EXPECT_NEAR(*perturbations[0].settling.formation_1cm, 0.04, 1e-9);
  EXPECT_FALSE(perturbations[0].settling.tracking_1cm);
  EXPECT_TRUE(perturbations[0].formation_first());
  EXPECT_NEAR(*perturbations[1].settling.tracking_1cm, 0.04, 1e-9);
  EXPECT_FALSE(perturbations[1].settling.formation_1cm);
  EXPECT_FALSE(perturbations[1].formation_first());
}

TEST(Statistics, ErrorsThatNeverLeftTheBandSettledAtOnceAndProveNothing) {
  History h;
  h.perturb(0.001, 0.001);
  h.add(10, 0.0, 0.0);
  const PerturbationResult p = h.summary().perturbations.at(0);
  EXPECT_EQ(p.settling.formation_5mm, 0.0);
  EXPECT_EQ(p.settling.tracking_1cm, 0.0);
  EXPECT_FALSE(p.formation_first());
}

TEST(Statistics, AHandThatCarriesARobotIsOneDisturbance) {
  History h;
  for (int k = 0; k < 50; ++k) h.perturb(0.1, 0.1, events::Move{0, {0.1, 0.0, 0.0}});  // until 1.96 s
  h.perturb(0.1, 0.1, events::Move{1, {0.1, 0.0, 0.0}});                               // 2 s
  h.add(24, 0.1, 0.0);
  h.add(25, 0.0, 0.0);
  const auto perturbations = h.summary().perturbations;
  ASSERT_EQ(perturbations.size(), 1u);
  EXPECT_DOUBLE_EQ(perturbations[0].t, 2.0);
  EXPECT_EQ(perturbations[0].what, "move r1 x=0.1 y=0 theta=0; move r2 x=0.1 y=0 theta=0");
  EXPECT_NEAR(*perturbations[0].settling.tracking_1cm, 1.0, 1e-9);
}

TEST(Statistics, TrackingIsMeasuredAgainstTheFormationNotAgainstWhatAvoidanceMadeOfIt) {
  History h;
  TickRecord r = h.row();
  r.robots[0].pose = {0.0, 0.3, 0.0};
  r.robots[0].reference.pose = r.robots[0].pose;  // avoiding: the reference is where the robot is
  r.robots[0].error = {0.0, 0.0, 0.0};
  h.add(r);
  EXPECT_DOUBLE_EQ(h.summary().final_error, 0.3);
}

/// Bytes that the program has taken from the heap.
std::size_t heap() {
  return ::mallinfo2().uordblks;
}

/// How many bytes eight hours of kidnaps take more than the first of them. `ticks`: from one to the next.
std::int64_t growth_after_one_hour(int ticks) {
  constexpr int hour = 3600 * 25;
  History history;
  TickRecord row = history.row();
  row.compute_time = 1e-5;
  std::size_t after_one_hour = 0;
  for (int k = 0; k < 8 * hour; ++k) {
    row.tick = k;
    row.t = k / 25.0;
    row.robots[0].pose_age = 0.03;
    row.events.clear();
    if (k % ticks == 0) row.events.add(events::Kidnap{static_cast<std::size_t>(k / ticks % 2), 0.2, 0.0, 0.0});
    history.add(row);
    if (k == hour) after_one_hour = heap();
  }
  return static_cast<std::int64_t>(heap()) - static_cast<std::int64_t>(after_one_hour);
}

TEST(Statistics, TakeNoMoreMemoryAfterEightHoursThanAfterOne) {
  EXPECT_LE(growth_after_one_hour(8), 64 * 1024) << "one disturbance after the other";
  EXPECT_LE(growth_after_one_hour(2), 64 * 1024) << "a single one that does not end";
}

TEST(Statistics, CountsEveryTouchOnce) {
  History h;
  for (const double d : {0.2, 0.0701, 0.0699, 0.0702, 0.0699, 0.0709, 0.0711, 0.0699, 0.2, 0.05, 0.05})
    h.add(h.row(0.0, 0.0, d));
  EXPECT_EQ(h.summary().collisions, 3);
  EXPECT_DOUBLE_EQ(h.summary().min_distance, 0.05);
}

TEST(Statistics, CountsTouchesOfAnyTwoNotOfNeighboursAlone) {
  Experiment e;
  e.robots.resize(4);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      Statistics statistics(e);
      TickRecord r;
      r.phase = Phase::running;
      r.robots.resize(4);
      for (std::size_t k = 0; k < 4; ++k) {
        RobotRecord& robot = r.robots[k];
        robot.nominal.pose.x = k == j ? 0.5 * static_cast<double>(i) + 0.06 : 0.5 * static_cast<double>(k);
        robot.pose = robot.truth = robot.nominal.pose;
        robot.measurement.captured_at = 0.0;
      }
      statistics.record(r);
      EXPECT_EQ(statistics.summary().collisions, 1) << i << ", " << j;
    }
}

TEST(Statistics, TheTruePosesTouchEvenIfTheSeenOnesDoNot) {
  History h;
  TickRecord r = h.row();
  r.robots[1].truth = {0.06, 0.0, 0.0};
  h.add(r);
  EXPECT_EQ(h.summary().collisions, 1);
}

TEST(Statistics, ARobotThatWasNeverSeenTouchesNobody) {
  History h;
  TickRecord r = h.row(0.0, 0.0, 0.0);
  for (RobotRecord& robot : r.robots) robot = RobotRecord{};
  h.add(r);
  EXPECT_EQ(h.summary().collisions, 0);
}

TEST(Statistics, SumsUpTheRun) {
  History h;
  for (const double compute : {1e-5, 9e-5, 2e-5}) {
    TickRecord r = h.row(0.02, -0.03);
    r.compute_time = compute;
    r.period = 0.04 + compute;
    h.add(r);
  }
  TickRecord r = h.row(0.01, -0.02);
  r.events.add(events::DeadlineMissed{2});
  r.events.add(events::Stop{});
  r.phase = Phase::stopped;
  h.add(r);
  const Statistics::Summary s = h.summary();
  EXPECT_EQ(s.ticks, 4);
  EXPECT_DOUBLE_EQ(s.duration, 0.16);
  EXPECT_DOUBLE_EQ(s.final_error, 0.01);
  EXPECT_DOUBLE_EQ(s.final_formation_error, 0.02);
  EXPECT_EQ(s.missed_deadlines, 2);
  EXPECT_DOUBLE_EQ(s.median_compute, 2e-5);
  EXPECT_DOUBLE_EQ(s.largest_compute, 9e-5);
  EXPECT_DOUBLE_EQ(s.largest_period, 0.04009);
  EXPECT_TRUE(s.stopped);
  ASSERT_EQ(s.events.size(), 2u);
  EXPECT_EQ(s.events[1].second, "stop");
}

TEST(Statistics, EndWithTheRunWhateverIsDoneAfterIt) {
  History h;
  h.add(50, 0.002, 0.001);
  TickRecord after = h.row(0.3, 0.2, 0.05);
  after.phase = Phase::finished;
  after.events.add(events::Move{0, {0.3, 0.0, 0.0}});
  h.add(after);
  const Statistics::Summary s = h.summary();
  EXPECT_EQ(s.ticks, 50);
  EXPECT_DOUBLE_EQ(s.duration, 2.0);
  EXPECT_DOUBLE_EQ(s.final_error, 0.002);
  EXPECT_DOUBLE_EQ(s.final_formation_error, 0.001);
  EXPECT_DOUBLE_EQ(s.min_distance, 1.0);
  EXPECT_EQ(s.collisions, 0);
  EXPECT_TRUE(s.perturbations.empty());
  EXPECT_EQ(s.events.size(), 1u);
}

TEST(Statistics, ARunWithoutARowHasNoValues) {
  const Statistics::Summary s = History().summary();
  EXPECT_TRUE(std::isnan(s.final_error));
  EXPECT_NE(as_lines(s).find("final_error: none\n"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(as_json(s))["final_error"].is_null());
}

TEST(Expectations, HoldForThePaper) {
  const Experiment e = paper_experiment();
  for (const bool guarded : {true, false}) {
    Experiment tried = e;
    tried.avoidance.enabled = tried.shield.enabled = guarded;
    Statistics statistics(tried);
    for (const TickRecord& row : test::simulate(tried)) statistics.record(row);
    const Statistics::Summary s = statistics.summary();
    EXPECT_EQ(failed_expectations(e.expect, s), std::vector<std::string>{});
    ASSERT_EQ(s.perturbations.size(), 3u);
    for (const PerturbationResult& p : s.perturbations)
      EXPECT_GT(*p.settling.tracking_1cm - *p.settling.formation_1cm, 0.5) << "the claim holds clearly";
  }
}

TEST(Expectations, SayByHowMuchTheyFailed) {
  Statistics::Summary s;
  s.final_error = 0.0123;
  s.min_distance = 0.06;
  s.collisions = 2;
  s.perturbations.push_back({18.0, 1, "perturb r2", {5.0, {}, 3.0, {}}});
  s.perturbations.push_back({30.0, 1, "perturb r2", {2.0, {}, {}, {}}});
  EXPECT_EQ(
      failed_expectations({0.01, 0.07, {}, true, 0}, s),
      (std::vector<std::string>{
          "expect.final_error: expected at most 0.01 m, found 0.0123 m, which is 0.0023 m too much",
          "expect.min_distance: expected at least 0.07 m, found 0.06 m, which is 0.01 m too little",
          "expect.collisions: expected at most 0, found 2",
          "expect.formation_first: expected true, but after \"perturb r2\" at 18 s the formation settled to 1 cm after "
          "5.00 s and the tracking after 3.00 s"}));
  EXPECT_EQ(failed_expectations({}, s), std::vector<std::string>{});
  EXPECT_EQ(failed_expectations({0.0123, 0.06, {}, {}, 2}, s), std::vector<std::string>{});
  EXPECT_EQ(failed_expectations({{}, {}, {}, false, {}}, s).size(), 1u);
  s.final_error = s.min_distance = none;
  EXPECT_EQ(failed_expectations({0.01, 0.07, {}, {}, {}}, s).size(), 2u) << "no value is no success";
}

TEST(Statistics, ARobotThatIsNeverSeenMakesErrorsUnknownAndNotZero) {
  History h;
  for (int k = 0; k < 50; ++k) {
    TickRecord r = h.row();
    r.robots[1].pose = {none, none, none};
    r.delta = {none};
    h.add(r);
  }
  EXPECT_TRUE(std::isnan(h.summary().final_error));
  EXPECT_TRUE(std::isnan(h.summary().final_formation_error));
  EXPECT_TRUE(std::isnan(h.summary().arrived));
  EXPECT_EQ(failed_expectations({0.1, {}, 25.0, {}, {}}, h.summary()).size(), 2u);
}

TEST(Statistics, NobodyArrivesBecauseTheReferencesWereStopped) {
  History stopped;
  const auto add = [&](Phase phase, double v) {
    TickRecord r = stopped.row();
    r.phase = phase;
    for (RobotRecord& robot : r.robots) robot.nominal.twist = {v, 0.0};
    stopped.add(r);
  };
  add(Phase::running, 0.05);
  add(Phase::paused, 0.0);
  add(Phase::stopped, 0.0);
  EXPECT_TRUE(std::isnan(stopped.summary().arrived));
}

TEST(Summary, PrintsNoSignBeforeAZero) {
  Statistics::Summary s;
  s.loop_delay = -1e-9;
  EXPECT_NE(as_lines(s).find("loop_delay: 0.0\n"), std::string::npos) << as_lines(s);
}

TEST(Summary, ReadsAsLinesAndAsJson) {
  Statistics::Summary s;
  s.name = "a \"name\"";
  s.ticks = 2100;
  s.duration = 84.0;
  s.final_error = 0.00123456789;
  s.collisions = 1;
  s.not_stopped = {0, 2};
  s.perturbations.push_back({18.0, 1, "perturb r2", {4.2400000000000002, {}, 6.84, 7.76}});
  s.events = {{0.0, "start"}, {18.0, "perturb r2"}};
  EXPECT_EQ(
      as_lines(s),
      "name: a \"name\"\nticks: 2100\nduration: 84.0\nfinal_error: 0.001235\nfinal_formation_error: none\n"
      "arrived: none\nmin_distance: none\nobstacle_gap: none\noutside: 0.0\ncollisions: 1\nmissed_deadlines: "
      "0\ndropped_rows: "
      "0\ncamera_outages: 0\ncamera_damaged: 0\nvideo_frames: 0\nvideo_dropped: "
      "0\nlargest_period: none\nmedian_compute: "
      "none\n"
      "largest_compute: none\nloop_delay: none\ndelay_margin: none\nstopped: false\nnot_stopped: 1 "
      "3\nperturbation_1_t: 18.0\nperturbation_1_robot: 2\n"
      "perturbation_1_what: perturb r2\nperturbation_1_formation_1cm: 4.24\nperturbation_1_formation_5mm: none\n"
      "perturbation_1_tracking_1cm: 6.84\nperturbation_1_tracking_5mm: 7.76\nperturbation_1_relative_1cm: none\n"
      "perturbation_1_relative_5mm: none\nperturbation_1_formation_first: true\nperturbation_1_relative_first: false\n"
      "perturbation_1_others_away: 0.0\nevents: 2\n");
  const auto json = nlohmann::json::parse(as_json(s));
  EXPECT_EQ(json["name"], s.name);
  EXPECT_EQ(json["final_error"], 0.001235);
  EXPECT_EQ(json["not_stopped"], nlohmann::json({1, 3}));
  EXPECT_EQ(json["perturbations"][0]["formation_1cm"], 4.24);
  EXPECT_TRUE(json["perturbations"][0]["formation_5mm"].is_null());
  EXPECT_EQ(json["events"][1]["what"], "perturb r2");
}

TEST(Summary, HasTheTimingCertificateOfARunInRealTime) {
  Statistics::Summary s;
  s.timing.emplace();
  EXPECT_EQ(as_lines(s).find("timing_"), std::string::npos) << "no tick ran at real-time speed";
  for (int k = 0; k < 1000; ++k) s.timing->tick.add(1e-4), s.timing->bare.add(5e-5);
  s.timing->tick.add(0.002);
  s.timing->no_priority = "not permitted";
  const std::string lines = as_lines(s);
  EXPECT_NE(lines.find("timing_tick_late_largest: 0.002\n"), std::string::npos) << lines;
  EXPECT_NE(lines.find("timing_bare_thread_late_p999: "), std::string::npos) << lines;
  EXPECT_NE(lines.find("timing_real_time_priority: none\ntiming_no_priority: not permitted\n"), std::string::npos)
      << lines;
  EXPECT_NEAR(nlohmann::json::parse(as_json(s))["timing"]["tick"]["p99"].get<double>(), 1e-4, 5e-6);
  s.timing->priority = 20;
  EXPECT_NE(as_lines(s).find("timing_real_time_priority: 20\n"), std::string::npos);
  EXPECT_EQ(as_lines(s).find("no_priority"), std::string::npos);
  EXPECT_EQ(as_lines(s).find("cpu_latency"), std::string::npos) << "a run of simulated robots asks for none";
  s.timing->cpu_latency = 3;
  EXPECT_NE(as_lines(s).find("timing_cpu_latency_limit: 3e-06\n"), std::string::npos) << as_lines(s);
  s.timing->cpu_latency.reset();
  s.timing->no_cpu_latency = "not permitted";
  EXPECT_NE(as_lines(s).find("timing_no_cpu_latency_limit: not permitted\n"), std::string::npos) << as_lines(s);
  EXPECT_EQ(as_lines(s).find("memory"), std::string::npos) << "a run of simulated robots asks for no lock";
  s.timing->memory_locked = true;
  EXPECT_NE(as_lines(s).find("timing_memory_locked: true\n"), std::string::npos) << as_lines(s);
  s.timing->memory_locked = false;
  s.timing->no_memory_lock = "not permitted";
  EXPECT_NE(as_lines(s).find("timing_no_memory_lock: not permitted\n"), std::string::npos) << as_lines(s);
}

TEST(Statistics, CountCollisionsWithWhatTheOperatorPutsDown) {
  History h;
  h.add(5, 0.0, 0.0);
  EXPECT_EQ(h.summary().collisions, 0);
  TickRecord r = h.row();
  r.events.add(events::PutObstacle{0, {0.0, 0.05, 0.03}});  // its edge 20 mm from the first robot's midpoint
  h.add(r);
  h.add(5, 0.0, 0.0);
  EXPECT_EQ(h.summary().collisions, 1);
  EXPECT_NEAR(h.summary().obstacle_gap, 0.02 - core::standard_radius, 1e-12);
  r = h.row();
  r.events.add(events::PutObstacle{0, {0.0, 0.05, 0.0}});  // taken away, and put down again
  h.add(r);
  r = h.row();
  r.events.add(events::PutObstacle{0, {0.0, 0.05, 0.03}});
  h.add(r);
  EXPECT_EQ(h.summary().collisions, 2);
}

TEST(Statistics, FindHowFarBodiesAreOverTheEdge) {
  History h;
  h.add(5, 0.0, 0.0);
  Expectations inside;
  inside.inside = true;
  EXPECT_EQ(h.summary().outside, 0.035) << "the second robot stands at x = 1 m, the edge";
  EXPECT_EQ(failed_expectations(inside, h.summary()).size(), 1u);
  Statistics alone{Experiment{}};
  EXPECT_TRUE(failed_expectations(inside, alone.summary()).empty());
}

}  // namespace
}  // namespace skein::app
