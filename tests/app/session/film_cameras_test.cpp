// Films and pictures that stand in for several cameras over one floor: what they show of one moment is taken for one
// moment, whatever is missing in one of them and however busy the machine is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "app/calibration/calibration_file.h"
#include "app/session/cameras.h"
#include "app/session/experiment_cameras.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/film_copy.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"

namespace skein::app {
namespace {

using test::Rows;

/// The films of two cameras that both see all of the paper's platoon, which drives 50 mm/s.
class FilmCameras : public ::testing::Test {
 protected:
  FilmCameras() {
    vision::Calibration camera = vision::overhead_calibration(2.0, 1.5);
    camera.width = 800, camera.height = 600;
    camera.fx *= 0.625, camera.fy *= 0.625, camera.cx = 399.5, camera.cy = 299.5;
    EXPECT_TRUE(save_calibration(camera, folder / "first.toml"));
    camera.world_from_camera->position.z() += 0.1;
    EXPECT_TRUE(save_calibration(camera, folder / "second.toml"));
    SessionOptions options;
    options.video = folder / "run.mkv";
    auto session = Session::open(run_of("synthetic", "synthetic"), Session::Clock::virtual_, options);
    EXPECT_TRUE(session) << session.error();
    EXPECT_EQ((*session)->run(), Phase::finished);
  }
  Experiment run_of(const std::string& first, const std::string& second) const {
    return good(paper_experiment().source,
                {"camera.source=" + first, "camera.calibration=" + (folder / "first.toml"),
                 "camera.also=[{source=\"" + second + "\",calibration=\"" + (folder / "second.toml") + "\"}]",
                 "duration=1.6", "perturb=[]", "expect={}"});
  }
  test::Folder folder;
};

/// A film's recorder drops frames where disk or encoder are too slow.
TEST_F(FilmCameras, StayInStepWhereOneLacksFrames) {
  std::vector<std::int64_t> dropped(16);  // in which robots drive 32 mm
  std::iota(dropped.begin(), dropped.end(), 10);
  test::copy_film(folder / "run-2.mkv", folder / "gap.mkv", dropped);
  Rows sink;
  auto session = Session::open(run_of("video:" + (folder / "run.mkv"), "video:" + (folder / "gap.mkv")),
                               Session::Clock::virtual_, {false, {&sink}});
  ASSERT_TRUE(session) << session.error();
  (*session)->run();
  EXPECT_FALSE(sink.has<events::CamerasDisagree>());
  EXPECT_FALSE(sink.has<events::CamerasDiffer>());
  ASSERT_GT(sink.rows.size(), 35U);
  const auto seen_at = [](const TickRecord& row, std::size_t camera) {
    return row.by_camera[camera * row.robots.size()].captured_at;
  };
  int both = 0, first_alone = 0;
  for (const TickRecord& row : sink.rows) {
    both += seen_at(row, 1) == row.now ? 1 : 0;
    first_alone += seen_at(row, 1) < row.now && seen_at(row, 0) == row.now ? 1 : 0;
  }
  EXPECT_EQ(first_alone, 16) << "while it has none";
  EXPECT_EQ(both + first_alone, static_cast<int>(sink.rows.size())) << "and it is in step before and after";
}

/// On the wall clock reading and tracking take time, on a busy machine more than the cameras' clocks may differ by.
TEST_F(FilmCameras, FramesOfOneMomentHaveOneStamp) {
  const Experiment experiment = run_of("video:" + (folder / "run.mkv"), "video:" + (folder / "run-2.mkv"));
  SessionClock clock(true);
  SimulatedWorld world(experiment);
  auto cameras = Cameras::open(experiment, clock, world, false, wanted_tags(experiment));
  ASSERT_TRUE(cameras) << cameras.error();
  std::vector<core::Measurement> newest(2 * experiment.robots.size());
  FrameTimes times;
  for (int frame = 0; frame < 3; ++frame) {
    (*cameras)->process_frames();
    ASSERT_TRUE((*cameras)->newest(newest, times));
    EXPECT_LE(newest.front().captured_at, times.ready_at);
    EXPECT_EQ(newest.front().captured_at, newest.back().captured_at);
  }
}

}  // namespace
}  // namespace skein::app
