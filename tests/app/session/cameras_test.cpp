// Several cameras over one floor, through whole runs: robots that cross the seam, a camera that is lost, one that is
// bumped, and two that disagree.
#include "app/session/cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "app/calibration/calibration_file.h"
#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/experiment_cameras.h"
#include "app/session/plant.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"
#include "vision/calibration/calibration.h"

namespace skein::app {
namespace {

using test::Rows;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// The paper's platoon under two cameras, west and east of x = 0: a second before the first robot crosses the seam.
Experiment platoon_under_two(const std::string& second_camera = "", const Sets& more = {}) {
  Sets sets{"camera.source=synthetic",
            "camera.also=[{source=\"synthetic\"" + second_camera + "}]",
            "reference.start=2.55",
            "duration=9",
            "perturb=[]",
            "expect={}"};
  sets.insert(sets.end(), more.begin(), more.end());
  return good(paper_experiment().source, sets);
}

struct CamerasRun {
  explicit CamerasRun(const Experiment& experiment) {
    CsvWriter file(csv, experiment);
    auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&file, &sink}});
    EXPECT_TRUE(session) << session.error();
    const auto listen = [&] {
      const double now = sink.rows.empty() ? 0.0 : sink.rows.back().now;
      for (std::string& sentence : (*session)->alarms()) {
        told_at.emplace_back(sentence, now);
        alarms.push_back(std::move(sentence));
      }
      return true;
    };
    end = (*session)->run(listen);
    listen();
    camera = (*session)->camera();
    down = (*session)->camera_status().down;
    (*session)->close();
    failure = (*session)->failure().value_or("");
  }
  /// Of a robot at a tick by one camera; null: it has not seen it just now.
  static const core::Measurement* seen(const TickRecord& row, std::size_t robot, std::size_t camera) {
    const core::Measurement& m = row.by_camera[camera * row.robots.size() + robot];
    return m.captured_at >= row.now - 1e-9 ? &m : nullptr;
  }
  Rows sink;
  std::ostringstream csv;
  Phase end = Phase::ready;
  std::string failure;
  vision::SourceStatus camera;  // of all, at the end
  std::string down;             // what the check list then says
  std::vector<std::string> alarms;
  std::vector<std::pair<std::string, double>> told_at;  // each, and when it was told [s]
};

std::string replayed_cameras(const CamerasRun& run) {
  std::istringstream csv(run.csv.str());
  const auto result = replay(csv, "run.csv");
  if (!result) return result.error();
  return result->different == 0 && result->commands > 0 ? "" : result->first;
}

TEST(Cameras, RobotsThatCrossTheSeamAreOneRobotEach) {
  const CamerasRun run(platoon_under_two());
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_FALSE(run.sink.has<events::Kidnap>());
  EXPECT_FALSE(run.sink.has<events::Lost>());
  EXPECT_FALSE(run.sink.has<events::CameraMoved>());
  EXPECT_FALSE(run.sink.has<events::CamerasDisagree>());
  EXPECT_FALSE(run.sink.has<events::CamerasDiffer>());
  EXPECT_THAT(run.alarms, IsEmpty()) << "a robot that another camera sees is not missing";
  EXPECT_EQ(run.camera.outages, 0);
  EXPECT_EQ(run.down, "");
  struct SeamErrors {
    double square = 0.0;
    int poses = 0;
    double rms() const { return std::sqrt(square / poses); }
  } west, east, both;
  double largest_step = 0.0;  // of an error from tick to tick
  core::Pose before[4];
  for (const TickRecord& row : run.sink.rows)
    for (std::size_t i = 0; i < 4; ++i) {
      const bool w = CamerasRun::seen(row, i, 0), e = CamerasRun::seen(row, i, 1);
      ASSERT_TRUE(w || e) << "robot " << i + 1 << " at " << row.t;
      const core::Pose &pose = row.robots[i].pose, &truth = row.robots[i].truth;
      const core::Pose error{pose.x - truth.x, pose.y - truth.y, 0.0};
      SeamErrors& sum = w && e ? both : w ? west : east;
      sum.square += error.x * error.x + error.y * error.y;
      ++sum.poses;
      if (row.tick > 0) largest_step = std::max(largest_step, core::distance(error, before[i]));
      before[i] = error;
    }
  EXPECT_GT(west.poses, 25);
  EXPECT_GT(east.poses, 25);
  EXPECT_GT(both.poses, 25);
  EXPECT_LE(both.rms(), 1.2 * std::max(west.rms(), east.rms()));
  EXPECT_LT(largest_step, 1e-3);
  EXPECT_EQ(replayed_cameras(run), "");
}

/// What the second camera says of where the robots were is 0.15 s late: 7.5 mm at 0.05 m/s. Nothing contradicts that.
TEST(Cameras, WhoseStampsDifferAreToldThoughNobodyStops) {
  const CamerasRun run(platoon_under_two(",stamps_late=0.15", {"reference.speed=0.05"}));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_EQ(run.sink.count<events::CamerasDiffer>(), 1) << "of two cameras once";
  EXPECT_NE(run.csv.str().find("cameras_differ r1 c"), std::string::npos);
  EXPECT_THAT(run.alarms, Contains(ContainsRegex("cameras 1 and 2 see robot 1 [78] mm apart, and go on to")).Times(1));
  EXPECT_FALSE(run.sink.has<events::CamerasDisagree>());
  EXPECT_EQ(replayed_cameras(run), "");
}

/// By 0.3 degrees: some 10 mm, which a filter takes for no robot that was carried.
TEST(Cameras, WhoseCalibrationsDifferSlightlyAreTold) {
  const CamerasRun run(platoon_under_two(",bump_at=0,bump=0.3"));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_EQ(run.sink.count<events::CamerasDiffer>(), 1);
  EXPECT_THAT(run.alarms, Contains(HasSubstr("skein calibrate joint corrects it")));
}

/// By 0.45 degrees: when the eastern camera does not see a robot any more, its measured pose jumps by some 16 mm. No
/// robot has moved by that.
TEST(Cameras, NobodyIsTakenForARunawayWhereTwoCalibrationsDiffer) {
  const CamerasRun run(platoon_under_two(",bump_at=0,bump=0.45"));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_EQ(run.sink.count<events::CamerasDiffer>(), 1);
  EXPECT_FALSE(run.sink.has<events::Runaway>());
  EXPECT_EQ(replayed_cameras(run), "");
}

/// Robots drive out of the eastern camera's view, and the western one is so far out of focus that it sees nothing.
TEST(Cameras, OneThatIsBlindIsNamedBeforeRobotsAreLostUnderIt) {
  const CamerasRun run(platoon_under_two("", {"camera.defocus_at=0", "camera.defocus=8"}));
  EXPECT_THAT(run.alarms, Contains(HasSubstr("camera 1: robot 1 is not seen, though another camera sees it where this "
                                             "one looks")));
  EXPECT_THAT(run.alarms, Contains(HasSubstr("camera 2: robot 1 is lost: the border of this picture cuts tag 1, and no "
                                             "other camera sees it")));
  double told_at = none, lost_at = none;
  for (const auto& [sentence, at] : run.told_at) {
    if (sentence.find("robot 1 is not seen") != std::string::npos) told_at = std::fmin(told_at, at);
    if (sentence.find("robot 1 is lost") != std::string::npos) lost_at = std::fmin(lost_at, at);
  }
  EXPECT_LT(told_at, lost_at - 0.5);
}

/// Two files whose names differ, one of which is a copy.
TEST(Cameras, WithTheSameCalibrationUnderTwoNamesAreRefused) {
  const test::Folder folder;
  ASSERT_TRUE(save_calibration(vision::overhead_calibration(1.0, 1.0), folder / "west.toml"));
  ASSERT_TRUE(save_calibration(vision::overhead_calibration(1.0, 1.0), folder / "east.toml"));
  const auto cameras = [&](const std::string& second) {
    return check_calibrations(
        good(paper_experiment().source,
             {"camera.source=images:" + (folder / "a"), "camera.calibration=" + (folder / "west.toml"),
              "camera.also=[{source=\"images:" + (folder / "b") + "\",calibration=\"" + (folder / second) + "\"}]"}));
  };
  const auto copy = cameras("east.toml");
  ASSERT_FALSE(copy);
  EXPECT_THAT(copy.error(), HasSubstr("has the place of camera 1 to the last digit"));
  ASSERT_TRUE(save_calibration(vision::overhead_calibration(1.0, 1.0, {0.5, 0.0}), folder / "east2.toml"));
  EXPECT_TRUE(cameras("east2.toml"));
}

/// No bump moves a picture so far.
TEST(Cameras, ThatSeeARobotFarApartMayHaveWrongCalibrations) {
  const char* const wrong_file = "has the calibration of another camera, or was calibrated for a floor with another";
  EXPECT_THAT(camera_stop_sentence({0, 1, 0, 0.5}), HasSubstr(wrong_file));
  EXPECT_THAT(camera_stop_sentence({0, 1, 0, 0.036}), Not(HasSubstr(wrong_file)));
}

/// Calibrations never agree perfectly: here one camera hangs a tenth of a degree from where its calibration has it.
TEST(Cameras, NoPoseJumpsWhereTwoCalibrationsDiffer) {
  const CamerasRun run(platoon_under_two(",bump_at=0,bump=0.1"));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_FALSE(run.sink.has<events::Kidnap>());
  EXPECT_FALSE(run.sink.has<events::CamerasDisagree>());
  EXPECT_FALSE(run.sink.has<events::CamerasDiffer>()) << "calibrations agree no better";
  double least_apart = 1e9, largest_step = 0.0, largest = 0.0;
  core::Pose before[4];
  for (const TickRecord& row : run.sink.rows)
    for (std::size_t i = 0; i < 4; ++i) {
      const core::Measurement *west = CamerasRun::seen(row, i, 0), *east = CamerasRun::seen(row, i, 1);
      if (west && east) least_apart = std::min(least_apart, core::distance(west->pose, east->pose));
      const core::Pose &pose = row.robots[i].pose, &truth = row.robots[i].truth;
      const core::Pose error{pose.x - truth.x, pose.y - truth.y, 0.0};
      if (row.tick > 0) largest_step = std::max(largest_step, core::distance(error, before[i]));
      largest = std::max(largest, std::hypot(error.x, error.y));
      before[i] = error;
    }
  EXPECT_GT(least_apart, 2e-3) << "the control: what the cameras measure is apart";
  EXPECT_LT(largest_step, 0.3 * least_apart);
  EXPECT_LT(largest, 5e-3) << "no worse than the worse camera";
  EXPECT_EQ(replayed_cameras(run), "");
}

TEST(Cameras, OneThatIsLostLeavesTheRest) {
  const CamerasRun run(platoon_under_two(",lost_at=2.5"));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_EQ(run.failure, "");
  EXPECT_THAT(run.alarms, Contains(HasSubstr("camera 2: lost: the synthetic camera is lost (camera.lost_at); robots "
                                             "that no other camera sees stand")));
  EXPECT_EQ(run.sink.count<events::CameraLost>(), 1);
  EXPECT_NE(run.csv.str().find("camera_lost c2"), std::string::npos);
  EXPECT_EQ(run.camera.outages, 1) << "the summary says so";
  EXPECT_EQ(run.down, "camera 2: the synthetic camera is lost (camera.lost_at)") << "and the check list";
  int stood = 0, drove = 0;
  for (const TickRecord& row : run.sink.rows) {
    if (row.now < 2.8) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      const RobotRecord& robot = row.robots[i];
      EXPECT_EQ(robot.is(lost), !CamerasRun::seen(row, i, 0)) << "robot " << i + 1 << " at " << row.t;
      stood += robot.is(lost) && robot.wheels.left == 0.0 && robot.wheels.right == 0.0 ? 1 : 0;
      drove += !robot.is(lost) && robot.wheels.left > 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(stood, 0);
  EXPECT_GT(drove, 0) << "who is seen drives on";
  EXPECT_EQ(replayed_cameras(run), "");
}

TEST(Cameras, WhenTheFirstIsLostThePictureIsThatOfTheOther) {
  const Experiment experiment = platoon_under_two("", {"camera.lost_at=0.5", "duration=1.5"});
  auto session = Session::open(experiment, Session::Clock::virtual_, {.pictures = true});
  ASSERT_TRUE(session) << session.error();
  Picture picture;
  EXPECT_EQ((*session)->run([&] {
    (*session)->picture(picture);
    return true;
  }),
            Phase::finished);
  EXPECT_GT(picture.captured_at, 1.0);
}

TEST(Cameras, TheReasonIsThatOfTheOneThatIsLostNow) {
  const CamerasRun run(platoon_under_two(",lost_at=2.5", {"camera.freeze_at=0.5", "camera.freeze_for=0.6"}));
  EXPECT_EQ(run.camera.outages, 2) << "the other one was frozen";
  EXPECT_EQ(run.down, "camera 2: the synthetic camera is lost (camera.lost_at)");
}

/// Its marks on the floor will not be looked for.
TEST(Cameras, OneThatIsLostBeforeTheStartDoesNotKeepTheOthersFromDriving) {
  const test::Folder folder;
  vision::Calibration camera = vision::overhead_calibration(2.0, 1.5);
  for (int k = 0; k < 4; ++k)
    camera.marks.push_back({.name = "tag " + std::to_string(20 + k),
                            .tag = 20 + k,
                            .x = k % 2 == 0 ? -0.9 : 0.9,
                            .y = k < 2 ? -0.65 : 0.65,
                            .size = 0.06});
  ASSERT_TRUE(save_calibration(camera, folder / "first.toml"));
  camera.world_from_camera->position.z() += 0.1;
  ASSERT_TRUE(save_calibration(camera, folder / "second.toml"));
  const CamerasRun run(platoon_under_two(",lost_at=0,calibration=\"" + (folder / "second.toml") + "\"",
                                         {"camera.calibration=" + (folder / "first.toml"), "duration=1"}));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_THAT(run.alarms, Contains(HasSubstr("camera 2: lost: the synthetic camera is lost")));
  ASSERT_FALSE(run.sink.rows.empty());
  EXPECT_LT(run.sink.rows.front().now, 2.0) << "the other one has looked at its marks twice by then";
}

TEST(Cameras, WhenAllAreLostEverybodyStops) {
  const CamerasRun run(platoon_under_two(",lost_at=2.5", {"camera.lost_at=3"}));
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("camera 1: the synthetic camera is lost (camera.lost_at); camera 2: the "
                                     "synthetic camera is lost (camera.lost_at)"));
  ASSERT_FALSE(run.sink.rows.empty());
  EXPECT_LE(run.sink.rows.back().now, 3.0 + 0.12);
}

TEST(Cameras, OneThatIsBumpedStopsTheRobotsAndTheOperatorIsToldWhichOne) {
  const CamerasRun run(platoon_under_two(",bump_at=1"));  // all four are under it
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("camera 2 moved (or the floor under it): all 4 tags moved by"));
  EXPECT_NE(run.csv.str().find("camera_moved c2 tags=4"), std::string::npos);
  EXPECT_LE(run.sink.rows.back().now, 1.0 + 0.12) << "three frames of 40 ms at most";
  EXPECT_EQ(replayed_cameras(run), "");
}

/// One robot under two cameras: its own jump and the bumped camera's look the same to that camera, but not to the
/// other.
struct OneRobot {
  static Experiment under(const std::string& second_camera, const Sets& more = {}) {
    Sets sets{"camera.source=synthetic", "camera.also=[{source=\"synthetic\"" + second_camera + "}]", "duration=4"};
    sets.insert(sets.end(), more.begin(), more.end());
    return good(
        "[reference]\nkind = \"independent\"\n[[robot]]\ntag = 1\n"
        "trajectory = { path = { shape = \"line\", from = [0.0, -0.2], to = [0.0, 0.3] }, speed = 0.08 }\n",
        sets);
  }
};

TEST(Cameras, ABumpIsKnownByOneRobotThatAnotherCameraSees) {
  const CamerasRun run(OneRobot::under(",bump_at=2"));
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("cameras 1 and 2 see robot 1 "));
  EXPECT_FALSE(run.sink.has<events::Kidnap>()) << "the robot is where it was";
  EXPECT_LE(run.sink.rows.back().now, 2.0 + 0.28) << "five frames and a tick";
  for (const TickRecord& row : run.sink.rows)
    EXPECT_LT(core::distance(row.robots[0].pose, row.robots[0].truth), 2e-3) << "nobody drives by the moved one";
  EXPECT_EQ(replayed_cameras(run), "");
}

TEST(Cameras, OneThatWasMovedSinceItsCalibrationIsKnownAtTheStart) {
  const CamerasRun run(OneRobot::under(",bump_at=0"));
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("cameras 1 and 2 see robot 1 "));
  EXPECT_LE(run.sink.rows.back().t, 0.28);
}

TEST(Cameras, TheSameGoesOnByTheFirstCameraWhereTheFileSaysSo) {
  const CamerasRun run(OneRobot::under(",bump_at=2", {"failure.camera_moved=go_on"}));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_EQ(run.sink.count<events::CamerasDisagree>(), 1) << "it is said all the same, once";
}

TEST(Cameras, ARobotThatIsCarriedWhereBothSeeItIsAKidnapAndNoMore) {
  const CamerasRun run(OneRobot::under("", {"perturb=[]", "operator=[{t=2,does=\"kick r1 vx=0.0 vy=0.9\"}]"}));
  EXPECT_EQ(run.end, Phase::finished) << run.failure;
  EXPECT_FALSE(run.sink.has<events::CamerasDisagree>());
  EXPECT_FALSE(run.sink.has<events::CamerasDiffer>());
  EXPECT_FALSE(run.sink.has<events::CameraMoved>());
}

}  // namespace
}  // namespace skein::app
