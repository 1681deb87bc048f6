// A camera that was calibrated by tags on the floor watches them: one that has moved is known before the start and
// while it sags, one mark that somebody moves is named, and robots that hide marks are no cause for alarm.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "app/calibration/calibration_file.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/plant.h"
#include "app/session/readiness.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"
#include "tests/app/session/expect_stop.h"

namespace skein::app {
namespace {

using test::Rows;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Six tags of 60 mm on the floor of the paper's platoon, two of them on its path.
vision::Calibration marked_camera(bool marked) {
  vision::Calibration camera = vision::overhead_calibration(2.0, 1.5);
  const std::array<std::array<double, 2>, 6> places{
      {{-0.9, 0.65}, {0.9, 0.65}, {0.9, -0.65}, {-0.9, -0.65}, {0.65, 0.1}, {0.3, 0.45}}};
  for (int k = 0; marked && k < 6; ++k) {
    const auto [x, y] = places[static_cast<std::size_t>(k)];
    camera.marks.push_back({.name = "tag " + std::to_string(20 + k), .tag = 20 + k, .x = x, .y = y, .size = 0.06});
  }
  return camera;
}

/// The paper's platoon under that camera.
class FloorMarks : public ::testing::Test {
 protected:
  Experiment platoon(const Sets& more, bool marked = true) const {
    const std::string file = folder / (marked ? "marked.toml" : "bare.toml");
    EXPECT_TRUE(save_calibration(marked_camera(marked), file));
    Sets sets{"camera.source=synthetic", "camera.calibration=" + file, "perturb=[]", "expect={}"};
    sets.insert(sets.end(), more.begin(), more.end());
    return good(paper_experiment().source, sets);
  }

  struct Run {
    explicit Run(const Experiment& experiment, Session::Clock clock = Session::Clock::virtual_) {
      CsvWriter file(csv, experiment);
      auto session = Session::open(experiment, clock, {false, {&file, &sink}});
      EXPECT_TRUE(session) << session.error();
      const auto listen = [&] {
        for (std::string& sentence : (*session)->alarms()) alarms.push_back(std::move(sentence));
        said.insert((*session)->marks().sentence);
        return true;
      };
      end = (*session)->run(listen);
      listen();
      if (const auto again = (*session)->start(); !again) refusal = again.error();
      (*session)->close();
      failure = (*session)->failure().value_or("");
    }
    /// How far the measured pose of a robot was from the true one at the end, at most. [m]
    double error() const {
      double most = 0.0;
      for (const RobotRecord& robot : sink.rows.back().robots)
        most = std::max(most, core::distance(robot.measurement.pose, robot.truth));
      return most;
    }
    Rows sink;
    std::ostringstream csv;
    Phase end = Phase::ready;
    std::string failure, refusal;  // of the run, and of another start
    std::vector<std::string> alarms;
    std::set<std::string> said;  // of the marks
  };

  test::Folder folder;
};

const Sets bumped_before{"camera.bump_at=0", "duration=2"};
/// A degree in ten seconds.
const Sets sagging{"camera.bump_at=2", "camera.bump_time=10", "duration=14"};

TEST_F(FloorMarks, ACameraThatMovedBeforeTheStartIsRefusedWithTheCommandThatMendsIt) {
  const Run run(platoon(bumped_before));
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("the camera moved (or the floor under it): 6 marks on the floor are 4"));
  EXPECT_THAT(run.failure, HasSubstr("skein calibrate floor video:FILM.mkv --camera " + (folder / "marked.toml")));
  EXPECT_THAT(run.refusal, HasSubstr("6 marks on the floor are 4")) << "whoever asks";
  for (const TickRecord& row : run.sink.rows) EXPECT_NE(row.phase, Phase::running) << "nobody has driven";
}

TEST_F(FloorMarks, WithoutMarksNobodyKnowsAndTheRobotsDriveByWrongPoses) {
  const Run run(platoon(bumped_before, false));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.failure, "");
  EXPECT_GT(run.error(), 0.04);
}

TEST_F(FloorMarks, OnTheWallClockToo) {
  const Run run(platoon(bumped_before), Session::Clock::wall);
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("6 marks on the floor are 4"));
}

TEST_F(FloorMarks, ACameraThatSagsStopsTheRobots) {
  const Run run(platoon(sagging));
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("marks on the floor are"));
  EXPECT_THAT(run.failure, HasSubstr("STOP"));
  EXPECT_EQ(run.sink.count<events::CameraMoved>(), 1);
  EXPECT_THAT(run.csv.str(), HasSubstr("camera_moved tags=0 by=0.0"));
  ASSERT_FALSE(run.sink.rows.empty());
  const TickRecord& last = run.sink.rows.back();
  test::expect_stop(last);
  // 4.2 mm/s: beyond 5 mm after 1.2 s, then up to 2 s until the next look, and half a second until the one after it.
  EXPECT_LT(last.now, 2.0 + 1.2 + 2.0 + 0.5 + 0.2);
  EXPECT_LT(run.error(), 0.018);
  std::istringstream csv(run.csv.str());
  const auto again = replay(csv, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->different, 0) << again->first;
}

/// The control: what the robots' own tags tell.
TEST_F(FloorMarks, WithoutMarksASaggingCameraIsNotNoticed) {
  const Run run(platoon(sagging, false));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.failure, "");
  EXPECT_FALSE(run.sink.has<events::CameraMoved>());
  EXPECT_GT(run.error(), 0.04);
}

TEST_F(FloorMarks, TheRunGoesOnWhereTheFileSaysSoAndItIsSaidOnce) {
  Sets sets = sagging;
  sets.emplace_back("failure.camera_moved=go_on");
  const Run run(platoon(sets));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.failure, "");
  EXPECT_EQ(run.sink.count<events::CameraMoved>(), 1);
  EXPECT_THAT(run.alarms, ElementsAre(HasSubstr("marks on the floor that are seen are off by")));
  EXPECT_GT(run.error(), 0.04);
}

TEST_F(FloorMarks, OneThatSomebodyMovedIsNamedAndTheRunGoesOn) {
  const Run run(platoon({"camera.mark_moved_at=3", "duration=9"}));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.failure, "");
  EXPECT_FALSE(run.sink.has<events::CameraMoved>());
  EXPECT_THAT(run.alarms, ElementsAre(HasSubstr("mark 20 was moved by 50 mm, or put back wrongly; the other")));
}

/// Of three marks one leaves the picture: by the others nobody knows any more whether the camera moves.
TEST_F(FloorMarks, ThatAreNoLongerSeenAreTold) {
  vision::Calibration camera = marked_camera(true);
  camera.marks.resize(3);
  camera.marks[0].x = 1.085;
  const std::string file = folder / "three.toml";
  ASSERT_TRUE(save_calibration(camera, file));
  const Run run(platoon({"camera.calibration=" + file, "camera.mark_moved_at=3", "duration=16"}));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.failure, "");
  EXPECT_THAT(run.alarms,
              ElementsAre(HasSubstr("2 of 3 marks on the floor are seen, 3 are needed to tell whether the "
                                    "camera has moved; it has been so for 10 s: clear the marks, or calibrate the "
                                    "floor anew; mark 20 is not seen: the border of the picture cuts it at "
                                    "(1.08, 0.65) m, pixel (12")));
  EXPECT_THAT(run.said, testing::Contains(AllOf(HasSubstr("2 of 3 marks"), HasSubstr("mark 20 is not seen"))))
      << "the check list has it as well";
}

TEST_F(FloorMarks, ThatRobotsHideAreNoCauseForAlarm) {
  for (const char* seed : {"seed=1", "seed=2"}) {
    const Run run(platoon({seed, "duration=20",
                           "perturb=[{t=1,robot=2,dx=-0.15,dy=0.03},{t=2,robot=1,dx=0.05,dy=0.05},"
                           "{t=2,robot=2,dx=0.05,dy=0.05},{t=2,robot=3,dx=0.05,dy=0.05},"
                           "{t=2,robot=4,dx=0.05,dy=0.05}]"}));
    EXPECT_EQ(run.end, Phase::finished);
    EXPECT_EQ(run.failure, "");
    EXPECT_THAT(run.alarms, IsEmpty());
    EXPECT_FALSE(run.sink.has<events::CameraMoved>());
    EXPECT_THAT(run.said, testing::Contains(AnyOf(HasSubstr("5 of 6 marks"), HasSubstr("4 of 6 marks"))))
        << "the control: robots did hide some";
  }
}

TEST_F(FloorMarks, TheCheckListSaysSoBeforeTheStart) {
  const Experiment experiment = platoon({});
  MarksStatus marks{.watched = true, .known = false};
  const auto camera = [&](const Experiment& e) { return readiness(e, nullptr, nullptr, {}, {.marks = marks}).front(); };
  EXPECT_EQ(camera(experiment).state, Check::State::waits);
  marks.known = true;
  marks.sentence = "mark 20 was moved";
  EXPECT_EQ(camera(experiment).state, Check::State::holds);
  EXPECT_THAT(camera(experiment).reason, HasSubstr("mark 20 was moved"));
  marks.moved = events::CameraMoved{.by = 0.041, .marks = 6};
  EXPECT_EQ(camera(experiment).state, Check::State::fails);
  EXPECT_TRUE(camera(experiment).hard);
  EXPECT_THAT(camera(experiment).reason, HasSubstr("6 marks on the floor are 41 mm from where they were"));
  EXPECT_FALSE(camera(platoon({"failure.camera_moved=go_on"})).hard) << "the file allows it";
}

}  // namespace
}  // namespace skein::app
