// Cameras whose frames nobody can drive by, in whole runs: of stamps that are too old, and of another size.
#include <gmock/gmock.h>

#include <filesystem>

#include "app/calibration/calibration_file.h"
#include "app/experiment/experiment.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/folder.h"
#include "tests/app/session/expect_stop.h"
#include "tests/app/session/rendered_platoon.h"
#include "tests/pgm.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

using test::RenderedPlatoon;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(CameraStamps, ThatAreTooOldToDriveByAreTheReasonThatIsTold) {
  const RenderedPlatoon run(3.0, {"camera.latency=0.3"});
  for (const TickRecord& row : run.sink.rows)
    for (const RobotRecord& robot : row.robots) EXPECT_EQ(robot.wheels.left, 0.0) << "nobody has driven";
  EXPECT_TRUE(run.down) << "the check list and the status line show it";
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("0.30 s old when they arrive, by their time stamps and camera.latency")));
}

TEST(CameraStamps, AreNotSpokenOfWhereRobotsDriveByThem) {
  const RenderedPlatoon run(3.0, {"camera.latency=0.1"});
  EXPECT_THAT(run.told, IsEmpty());
  EXPECT_FALSE(run.down);
}

/// A camera's clock that is ahead, by a latency that makes every stamp later.
TEST(CameraStamps, ThatAreLaterThanTheArrivalAreTold) {
  const RenderedPlatoon run(5.0, {"camera.latency=-0.05"});
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_FALSE(run.down);
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("its time stamps are 50 ms later than the arrival of their frames")));
}

/// Pictures that come through a network or another program, which stamps them anew.
TEST(CameraStamps, ThatAreLateStopTheRobotsAndTheOperatorIsToldByHowMuch) {
  const RenderedPlatoon run(10.0, {"camera.stamps_late=1"});
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_EQ(run.sink.count<events::PicturesLate>(), 1);
  EXPECT_THAT(run.failure, HasSubstr("obey their commands 1.0 s later than the known delays explain: STOP"));
  ASSERT_FALSE(run.sink.rows.empty());
  const TickRecord& last = run.sink.rows.back();
  test::expect_stop(last);
  EXPECT_LT(last.now, 3.0);
}

TEST(CameraStamps, ThatAreLateAreToldWhereTheFileLetsRobotsDrive) {
  const RenderedPlatoon run(10.0, {"camera.stamps_late=1", "failure.camera_moved=go_on"});
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.sink.count<events::PicturesLate>(), 1);
}

TEST(CameraStamps, ThatAreLateByWhatTheFileSaysStopNobody) {
  const RenderedPlatoon run(10.0, {"camera.stamps_late=0.4", "camera.latency=0.4", "estimation.bridge=0.6"});
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.sink.count<events::PicturesLate>(), 0);
}

TEST(CameraFrames, OfAnotherSizeAreTheReasonThatIsTold) {
  const test::Folder folder;
  const std::string film = folder / "film", file = folder / "camera.toml";
  std::filesystem::create_directory(film);
  const vision::Calibration calibration = vision::overhead_calibration(2.0, 1.5);
  ASSERT_TRUE(save_calibration(calibration, file));
  const Experiment platoon =
      good(paper_experiment().source,
           {"camera.source=images:" + film, "camera.calibration=" + file, "perturb=[]", "expect={}", "duration=1.6"});
  const auto reference = make_reference(platoon);
  std::vector<vision::SyntheticTag> tags;
  for (std::size_t k = 0; k < platoon.robots.size(); ++k)
    tags.push_back({platoon.robots[k].tag, reference->at(k, 0.0).pose, calibration.tag_size});
  vision::Frame whole, small;
  vision::SyntheticCamera(calibration).render(tags, 0.0, whole);
  small.resize(640, 480);
  skein::test::write_pgm(folder / "whole", whole);
  skein::test::write_pgm(folder / "small", small);
  for (int k = 0; k < 50; ++k)
    std::filesystem::create_hard_link(folder / (k < 25 ? "whole" : "small"),
                                      film + "/" + std::to_string(100 + k) + ".pgm");
  auto session = Session::open(platoon, Session::Clock::virtual_);
  ASSERT_TRUE(session) << session.error();
  std::vector<std::string> told;
  bool down = false;
  static_cast<void>((*session)->run([&] {
    for (std::string& sentence : (*session)->alarms()) told.push_back(std::move(sentence));
    down = down || !(*session)->camera_status().down.empty();
    return true;
  }));
  (*session)->close();
  EXPECT_THAT(told, Contains(HasSubstr("frames are 640x480 px, but the calibration holds for 1280x960: robots stand")));
  EXPECT_TRUE(down) << "the check list shows it";
}

}  // namespace
}  // namespace skein::app
