// `skein camera latency` on an emulated robot under a synthetic camera whose stamps are late: how late they are is
// found to a millisecond, and what a robot is predicted agrees with where it is once that is corrected.
#include "app/tools/camera_latency.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "app/calibration/calibration_file.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"
#include "tests/core/wandering_stamps.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tracker/tracker.h"

namespace skein::app {
namespace {

using test::Rows;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* one_under_it = "[robot_defaults]\nlink = \"loopback\"\n[[robot]]\nstart = [-0.3, 0.2, 0.5]\n";
constexpr const char* two_under_it =
    "[robot_defaults]\nlink = \"loopback\"\n[[robot]]\nstart = [-0.3, 0.2, 0.5]\n[[robot]]\nstart = [0.3, -0.2, 2.0]\n";

using Answer = tl::expected<LatencyMeasurement, std::string>;

/// Of robot 1 in a lab that is `truth`, measured by somebody who thinks that it is `believed`.
Answer measure(const Experiment& truth, const Experiment& believed, std::vector<comms::Fault> faults = {},
               std::function<bool()> keep_on = {}, double seconds = 6.0) {
  SessionClock clock(false);
  SessionOptions options;
  options.faults = std::move(faults);
  auto plant = Plant::open(truth, clock, options);
  EXPECT_TRUE(plant) << plant.error();
  Answer answer = measure_latency(**plant, clock, believed, 0, seconds, std::move(keep_on));
  (*plant)->close();
  for (const RobotStatus& status : (*plant)->robots()) EXPECT_TRUE(status.stop_acknowledged);
  return answer;
}

Experiment lab(const Sets& more = {}, const char* robots = one_under_it) {
  Sets sets{"camera.source=synthetic"};
  sets.insert(sets.end(), more.begin(), more.end());
  return good(robots, sets);
}

Answer measure(const Experiment& experiment) {
  return measure(experiment, experiment);
}

TEST(CameraLatency, IsFoundToAMillisecond) {
  for (const double planted : {0.0, 0.007, 0.02, 0.04}) {
    const Answer found = measure(lab({fmt::format("camera.stamps_late={}", planted)}));
    ASSERT_TRUE(found) << found.error();
    ASSERT_EQ(found->cameras.size(), 1u);
    const CameraLatency& camera = found->cameras[0];
    EXPECT_THAT(camera.doubt, IsEmpty());
    EXPECT_NEAR(camera.late, planted, 1e-3);
    EXPECT_LT(camera.sigma, 5e-4);
    EXPECT_NEAR(camera.scale, 1.0, 0.01);
    EXPECT_GT(camera.poses, 150u);
    EXPECT_GT(found->turned, 5.0);
    EXPECT_EQ(found->round_trip, 0.0) << "in lock-step";
    std::cout << "planted_ms: " << 1e3 * planted << ", found_ms: " << 1e3 * camera.late
              << ", standard_deviation_ms: " << 1e3 * camera.sigma << ", halves_ms: " << 1e3 * camera.halves[0] << " "
              << 1e3 * camera.halves[1] << ", heading_rms_mrad: " << 1e3 * camera.heading_rms << "\n";
  }
}

/// What is corrected already is not found again, and what is wrong with the wheels in the file is no latency.
TEST(CameraLatency, IsWhatTheFileDoesNotCorrectYet) {
  const Answer corrected = measure(lab({"camera.stamps_late=0.02", "camera.latency=0.02"}));
  ASSERT_TRUE(corrected) << corrected.error();
  EXPECT_NEAR(corrected->cameras[0].late, 0.0, 1e-3);

  Experiment truth = lab({"camera.stamps_late=0.02"});
  const Experiment believed = truth;
  truth.robots[0].drive.track *= 0.95;
  const Answer wrong_wheels = measure(truth, believed);
  ASSERT_TRUE(wrong_wheels) << wrong_wheels.error();
  EXPECT_NEAR(wrong_wheels->cameras[0].late, 0.02, 1e-3);
  EXPECT_NEAR(wrong_wheels->cameras[0].scale, 1.0 / 0.95, 0.01);
}

TEST(CameraLatency, IsFoundOfEachCamera) {
  const Answer found = measure(lab({"camera.stamps_late=0.01", "camera.also=[{source=\"synthetic\", stamps_late=0.03}]",
                                    "robot.1.start=[0.0, 0.0, 0.0]"}));
  ASSERT_TRUE(found) << found.error();
  ASSERT_EQ(found->cameras.size(), 2u);
  EXPECT_NEAR(found->cameras[0].late, 0.01, 1e-3);
  EXPECT_NEAR(found->cameras[1].late, 0.03, 1e-3);

  const Answer one_sees_it = measure(lab({"camera.also=[{source=\"synthetic\"}]", "robot.1.start=[-0.7, 0.0, 0.0]"}));
  ASSERT_TRUE(one_sees_it) << one_sees_it.error();
  EXPECT_THAT(one_sees_it->cameras[0].doubt, IsEmpty());
  EXPECT_THAT(one_sees_it->cameras[1].doubt, HasSubstr("is the robot in this camera's view"));
}

CameraLatency turn_at(double row, double late, double sigma = 1e-4) {
  CameraLatency turn;
  turn.row = row, turn.late = late, turn.sigma = sigma;
  return turn;
}

/// Stamps that are 10 ms late, and rows of 25 us of which the calibration knows 10.
TEST(CameraRows, AreTheSlopeOfTheLatencyOverTheRows) {
  const auto late = [](double row) { return 0.010 + (10e-6 - 25e-6) * row; };
  const CameraRows two = judge_rows({turn_at(100, late(100)), turn_at(860, late(860))}, 10e-6, 960);
  EXPECT_THAT(two.doubt, IsEmpty());
  EXPECT_NEAR(two.row_time, 25e-6, 1e-9);
  EXPECT_NEAR(two.late, 0.010, 1e-9);
  EXPECT_NEAR(two.row_time_sigma, 1e-4 * std::sqrt(2.0) / 760.0, 1e-9);

  CameraLatency odd = turn_at(480, late(480) + 1e-3);
  const CameraRows off_the_line = judge_rows({turn_at(100, late(100)), odd, turn_at(860, late(860))}, 10e-6, 960);
  EXPECT_GT(off_the_line.row_time_sigma, 4.0 * two.row_time_sigma) << "turns that disagree say less";
  odd.doubt = "nothing";
  EXPECT_NEAR(judge_rows({turn_at(100, late(100)), odd, turn_at(860, late(860))}, 10e-6, 960).row_time, 25e-6, 1e-9);

  const CameraRows global = judge_rows({turn_at(100, 0.010), turn_at(860, 0.01005)}, 0.0, 960);
  EXPECT_THAT(global.doubt, IsEmpty());
  EXPECT_EQ(global.row_time, 0.0) << "noise alone";
}

TEST(CameraRows, AreNotToldWhereTheTurnsDoNotTell) {
  EXPECT_THAT(judge_rows({turn_at(100, 0.01)}, 0.0, 960).doubt, HasSubstr("1 of 1 turns tell a latency"));
  EXPECT_THAT(judge_rows({turn_at(400, 0.01), turn_at(600, 0.01)}, 0.0, 960).doubt,
              HasSubstr("at the rows 400 to 600 of 960; needed for the row time: 320 rows apart or more"));
  EXPECT_THAT(judge_rows({turn_at(100, 0.01, 1e-3), turn_at(860, 0.01)}, 0.0, 960).doubt,
              HasSubstr("turns leave a row time of -"));
  EXPECT_THAT(judge_rows({turn_at(100, 0.0), turn_at(860, 0.019)}, 0.0, 960).doubt,
              HasSubstr("a row time of -25.0 us means rows that are read from the bottom up"));
}

/// The synthetic camera takes its rows as the calibration says; where that is wrong, the next test has it.
TEST(CameraRows, AreFoundByTwoRobotsUnderOneCamera) {
  const test::Folder folder;
  vision::Calibration calibration = vision::overhead_calibration(2.0, 1.5);
  for (const double told : {0.0, 25e-6}) {
    calibration.row_time = told;
    ASSERT_TRUE(save_calibration(calibration, folder / "cal.toml"));
    const Experiment experiment =
        lab({fmt::format("camera.calibration=\"{}\"", folder / "cal.toml"), "camera.stamps_late=0.02",
             "robot.1.start=[-0.3, 0.55, 0.0]", "robot.2.start=[0.3, -0.55, 0.0]"},
            two_under_it);
    SessionClock clock(false);
    auto plant = Plant::open(experiment, clock, {});
    ASSERT_TRUE(plant) << plant.error();
    std::vector<CameraLatency> turns;
    for (const std::size_t robot : {0, 1}) {
      const Answer one = measure_latency(**plant, clock, experiment, robot, 6.0);
      ASSERT_TRUE(one) << one.error();
      turns.push_back(one->cameras[0]);
    }
    (*plant)->close();
    EXPECT_LT(turns[0].row, 250.0);
    EXPECT_GT(turns[1].row, 700.0);
    const CameraRows rows = judge_rows(turns, told, calibration.height);
    std::cout << "told_us: " << 1e6 * told << ", found_us: " << 1e6 * rows.row_time
              << ", standard_deviation_us: " << 1e6 * rows.row_time_sigma << ", late_ms: " << 1e3 * rows.late
              << ", by the first robot alone: " << 1e3 * turns[0].late << ", by the second: " << 1e3 * turns[1].late
              << "\n";
    EXPECT_THAT(rows.doubt, IsEmpty());
    EXPECT_NEAR(rows.row_time, told, 1e-6);
    EXPECT_NEAR(rows.late, 0.02, 1e-3);
  }
}

/// A rendered rolling shutter: two robots turn to and fro, and each is drawn where it is when its row is read.
TEST(CameraRows, OfARollingShutterAreFound) {
  constexpr double row_time = 25e-6, late = 0.007, seconds = 8.0;
  const core::DifferentialDrive drive;
  const auto heading = [](double t) { return 1.2 * std::sin(2.0 * core::pi * t * (0.4 + 0.03 * t)); };
  const auto steps = [&](double t) {
    return heading(t) * drive.track * drive.steps_per_turn / (2.0 * core::pi * drive.wheel_diameter);
  };
  for (const double told : {0.0, 25e-6}) {
    vision::Calibration calibration = vision::overhead_calibration(2.0, 1.5);
    calibration.row_time = told;
    vision::SyntheticCamera camera(calibration);
    vision::TagTracker tracker(calibration, {.tags = {1, 2}});
    std::vector<core::TurnRecord> records(2);
    vision::Frame frame;
    for (double t = 0.0; t < seconds; t += 0.04) {
      std::vector<vision::SyntheticTag> tags;
      for (const int tag : {1, 2}) {
        core::Pose pose{-0.2, tag == 1 ? 0.6 : -0.6, 0.0};
        const auto pixel = vision::pixel_from_world(calibration, {pose.x, pose.y, calibration.tag_height});
        pose.theta = heading(t + row_time * pixel->y());
        tags.push_back({.tag = tag, .pose = pose, .size = calibration.tag_size});
        for (double at = t; at < t + 0.0399; at += 0.005)
          records[static_cast<std::size_t>(tag - 1)].wheels.push_back({at, -steps(at), steps(at)});
      }
      camera.render(tags, t, frame);
      frame.captured_at = t + late;
      for (const vision::TagPose& pose : tracker.process(frame))
        records[static_cast<std::size_t>(pose.tag - 1)].poses.push_back({pose.captured_at, pose.pose});
    }
    std::vector<CameraLatency> turns;
    for (core::TurnRecord& record : records) {
      record.believed = drive;
      turns.push_back(judge_latency(record));
      const auto pixel = vision::pixel_from_world(
          calibration, {record.poses[0].pose.x, record.poses[0].pose.y, calibration.tag_height});
      turns.back().row = pixel->y();
    }
    const CameraRows rows = judge_rows(turns, told, calibration.height);
    std::cout << "row_time_us: " << 1e6 * row_time << ", told_us: " << 1e6 * told
              << ", found_us: " << 1e6 * rows.row_time << ", standard_deviation_us: " << 1e6 * rows.row_time_sigma
              << ", late_ms: " << 1e3 * rows.late << ", each alone: " << 1e3 * turns[0].late << " "
              << 1e3 * turns[1].late << "\n";
    EXPECT_THAT(rows.doubt, IsEmpty());
    EXPECT_NEAR(rows.row_time, row_time, 1e-6) << "1 ms over the picture";
    EXPECT_NEAR(rows.late, late, 1e-3);
    if (told == 0.0) {
      EXPECT_GT(std::abs(turns[0].late - turns[1].late), 0.01) << "the control";
    }
  }
}

/// How far a robot at 0.13 m/s is ahead of where it is predicted to be, in the mean. [m]
double ahead_of_prediction(const Sets& camera) {
  constexpr const char* lap =
      "duration = 8\n[reference]\nkind = \"platoon\"\nspeed = 0.13\npath = { shape = \"circle\", radius = 0.5 }\n"
      "[controller]\nv_max = 0.16\n[robot_defaults]\nlink = \"loopback\"\n[[robot]]\n";
  Rows sink;
  auto session = Session::open(lab(camera, lap), Session::Clock::virtual_, {false, {&sink}});
  EXPECT_TRUE(session) << (session ? "" : session.error());
  if (!session) return none;
  EXPECT_EQ((*session)->run(), Phase::finished);
  double sum = 0.0, v = 0.0;
  int rows = 0;
  for (const TickRecord& row : sink.rows) {
    if (row.t < 2.0) continue;
    const RobotRecord& robot = row.robots[0];
    sum += (robot.truth.x - robot.pose.x) * std::cos(robot.truth.theta) +
           (robot.truth.y - robot.pose.y) * std::sin(robot.truth.theta);
    v += robot.command.v;
    ++rows;
  }
  EXPECT_NEAR(v / rows, 0.13, 0.005);
  return sum / rows;
}

/// The control is the same run without the correction.
TEST(CameraLatency, CorrectedARobotIsWhereItIsPredictedToBe) {
  for (const double late : {0.007, 0.02, 0.04}) {
    const std::string stamps = fmt::format("camera.stamps_late={}", late);
    const Answer found = measure(lab({stamps}));
    ASSERT_TRUE(found) << found.error();
    const double before = ahead_of_prediction({stamps});
    const double after = ahead_of_prediction({stamps, fmt::format("camera.latency={:.4f}", found->cameras[0].late)});
    EXPECT_NEAR(before, 0.13 * late, 3e-4);
    EXPECT_LT(std::abs(after), 3e-4);
    std::cout << "planted_ms: " << 1e3 * late << ", uncorrected_mm: " << 1e3 * before
              << ", corrected_mm: " << 1e3 * after << "\n";
  }
}

TEST(CameraLatency, IsNotAnsweredWhereTheDataDoNotTell) {
  const Answer silent = measure(lab(), lab(), {{.kind = comms::FaultKind::silent_encoders}});
  ASSERT_TRUE(silent) << silent.error();
  EXPECT_THAT(silent->cameras[0].doubt, HasSubstr("determine nothing"));

  Experiment another = lab();
  another.robots[0].drive.track *= 0.6;
  const Answer other_wheels = measure(another, lab());
  ASSERT_TRUE(other_wheels) << other_wheels.error();
  EXPECT_THAT(other_wheels->cameras[0].doubt, HasSubstr("times as far as its counters say"));

  // A robot that can hardly turn, for a moment.
  Experiment slow = lab();
  slow.controller.omega_max = 0.02;
  const Answer hardly = measure(slow, slow, {}, {}, 4.0);
  ASSERT_TRUE(hardly) << hardly.error();
  EXPECT_THAT(hardly->cameras[0].doubt, HasSubstr("determine nothing"));
}

TEST(CameraLatency, IsNotAnsweredWhereStampsWander) {
  EXPECT_THAT(judge_latency(test::turn_with_wandering_stamps(0.0)).doubt, IsEmpty());
  EXPECT_THAT(judge_latency(test::turn_with_wandering_stamps(0.0023)).doubt, HasSubstr("irregular"));
  EXPECT_THAT(judge_latency(test::turn_with_wandering_stamps(0.01)).doubt, HasSubstr("the data leave"));
}

TEST(CameraLatency, SaysWhatItNeeds) {
  const auto error = [](const Answer& answer) { return answer ? std::string() : answer.error(); };
  EXPECT_THAT(error(measure(good("[[robot]]\n", {"camera.source=synthetic"}))), HasSubstr("has no link"));
  EXPECT_THAT(error(measure(good(one_under_it))), HasSubstr("there is no camera"));
  EXPECT_THAT(error(measure(lab({"robot.2.start=[-0.3, 0.274, 0.0]"}, two_under_it))),
              HasSubstr("give it room to turn"));
  Experiment film = lab();
  film.camera.source = "video:run.mkv";
  EXPECT_THAT(
      error(measure(lab(), film)),
      HasSubstr("camera.source is \"video:run.mkv\", which does not show how robot 1 turns now; allowed: a camera"));
  Experiment outside = lab({"rate=10"});  // fewer frames to draw
  outside.robots[0].start = {5.0, 0.0, 0.0};
  EXPECT_THAT(error(measure(outside)), HasSubstr("tag 1 of robot 1 is not seen: no tag 1 is in the picture"));
}

/// Whatever ends it, the robot stands and has acknowledged that (measure() checks).
TEST(CameraLatency, EveryRobotStandsWhenItIsEnded) {
  const auto error = [](const Answer& answer) { return answer ? std::string() : answer.error(); };
  int asked = 0;
  const Experiment e = lab();
  EXPECT_EQ(error(measure(e, e, {}, [&] { return ++asked < 60; })), "stopped");
  EXPECT_EQ(asked, 60);
  EXPECT_THAT(error(measure(lab({"camera.lost_at=3"}))), HasSubstr("lost"));
  EXPECT_THAT(error(measure(lab({"camera.lost_at=3", "robot.1.start=[0.0, 0.0, 0.0]",
                                 "camera.also=[{source=\"synthetic\", lost_at=3.0}]"}))),
              HasSubstr("lost"));
  // One wheel rolls by itself.
  EXPECT_THAT(error(measure(lab({"robot.1.truth={runaway=[3.0, 0.1, 0.0]}"}))), HasSubstr("instead of turning"));
}

}  // namespace
}  // namespace skein::app
