// skein calibrate joint: two films of robots that circle where both cameras look, one of which hangs otherwise than its
// calibration says.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "app/calibration/calibration_file.h"
#include "app/cli/command_calibrate.h"
#include "tests/app/folder.h"
#include "vision/recording/recorder.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

using ::testing::HasSubstr;

struct JointLab {
  test::Folder folder;
  vision::Calibration west = vision::overhead_calibration(1.2, 0.9, {-0.45, 0.0});
  vision::Calibration east = vision::overhead_calibration(1.2, 0.9, {0.45, 0.0});
  vision::Calibration believed = vision::tilted(east, 0.2);  // of the eastern one
  JointRequest request;

  JointLab() {
    // 15 mm beside what is true, and a fifth of a degree tilted.
    believed.world_from_camera->position += Eigen::Vector3d(0.012, -0.009, 0.0);
    EXPECT_TRUE(save_calibration(west, folder / "west.toml"));
    EXPECT_TRUE(save_calibration(believed, folder / "east.toml"));
    std::ofstream(folder / "two.toml")
        << "[camera]\nsource = \"v4l2:/dev/video0\"\ncalibration = \"west.toml\"\n"
           "[[camera.also]]\nsource = \"v4l2:/dev/video1\"\ncalibration = \"east.toml\"\n";
    request.experiment = folder / "two.toml";
    request.film = folder / "run.mkv";
  }
  void film(int frames, double radius = 0.06) {
    for (const bool first : {true, false}) {
      const vision::Calibration& told = first ? west : believed;
      auto recorder = vision::Recorder::open(folder / (first ? "run.mkv" : "run-2.mkv"),
                                             {{"CALIBRATION", format_calibration(told)}});
      ASSERT_TRUE(recorder) << recorder.error();
      vision::SyntheticCamera camera(first ? west : east);
      vision::Frame frame;
      for (int k = 0; k < frames; ++k) {
        const double t = 0.04 * k + (first ? 0.0 : 0.017);
        std::vector<vision::SyntheticTag> tags;
        for (int robot = 0; robot < 3; ++robot) {
          const double angle = 0.12 * t / 0.06 + robot;
          tags.push_back({.tag = robot + 1,
                          .pose = {radius * std::cos(angle), 0.25 * (robot - 1) + radius * std::sin(angle),
                                   core::wrap_angle(angle + 0.5 * core::pi)},
                          .size = west.tag_size});
        }
        camera.render(tags, t, frame);
        frame.captured_at = t;
        frame.index = k;
        (*recorder)->add(frame);
      }
      EXPECT_EQ((*recorder)->finish().problem, "");
    }
  }
  std::string run(int expected) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = calibrate_joint(request);
    std::string out = testing::internal::GetCapturedStdout();
    out += testing::internal::GetCapturedStderr();
    EXPECT_EQ(status, expected) << out;
    return out;
  }
};

TEST(CalibrateJoint, MakesTwoCamerasAgreeAndOverwritesNothingUnasked) {
  JointLab lab;
  lab.film(22);
  lab.request.out = lab.folder / "joint";
  const std::string out = lab.run(0);
  EXPECT_THAT(out, HasSubstr("cameras 1 and 2: "));
  EXPECT_THAT(out, HasSubstr("camera 1: the reference"));
  EXPECT_THAT(out, HasSubstr("calibration: " + lab.folder.path + "/joint/east.toml"));
  EXPECT_EQ(*load_calibration(lab.folder / "east.toml"), lab.believed);
  EXPECT_FALSE(std::filesystem::exists(lab.folder / "joint/west.toml")) << "the reference stays";
  const auto east = load_calibration(lab.folder / "joint/east.toml");
  ASSERT_TRUE(east) << east.error();
  for (const double x : {0.0, 0.4}) {
    const auto pixel = vision::pixel_from_world(lab.east, {x, 0.1, lab.east.tag_height});
    const auto before = vision::world_from_pixel(lab.believed, *pixel, lab.east.tag_height);
    const auto after = vision::world_from_pixel(*east, *pixel, lab.east.tag_height);
    const Eigen::Vector2d is(x, 0.1);
    std::cout << "x: " << x << ", before_mm: " << 1e3 * (*before - is).norm()
              << ", after_mm: " << 1e3 * (*after - is).norm() << "\n";
    EXPECT_GT((*before - is).norm(), 8e-3) << "the control";
    EXPECT_LT((*after - is).norm(), 2e-3);
  }
  EXPECT_THAT(lab.run(2), HasSubstr("joint/east.toml: already exists; allowed: another folder, or --save"));

  lab.request.out.clear();
  lab.request.save = true;
  EXPECT_THAT(lab.run(0), HasSubstr("its previous contents are in " + (lab.folder / "east.toml.old")));
  EXPECT_EQ(*load_calibration(lab.folder / "east.toml"), *east);
  EXPECT_THAT(lab.run(3), HasSubstr("run-2.mkv was recorded with another calibration than"));
}

TEST(CalibrateJoint, NamesTheFramesThatItCannotRead) {
  JointLab lab;
  lab.film(22);
  const std::string film = lab.folder / "run-2.mkv";
  std::fstream file(film, std::ios::in | std::ios::out | std::ios::binary);
  const auto middle = static_cast<std::streamoff>(std::filesystem::file_size(film) / 2);
  for (std::streamoff at = middle; at < middle + 400; at += 40) file.seekp(at).put('?');
  file.close();
  EXPECT_THAT(lab.run(0), HasSubstr("skipped camera 2: " + film + ": frame 1"));
}

TEST(CalibrateJoint, RefusesWhatItCannotUse) {
  JointLab lab;
  EXPECT_THAT(lab.run(3), HasSubstr("run.mkv"));
  lab.film(3);
  EXPECT_THAT(lab.run(3), HasSubstr("places; needed: 20 or more: let robots drive where both see them; nothing was"));
  lab.request.reference = 3;
  EXPECT_THAT(lab.run(2), HasSubstr("--reference 3; allowed: 1 to 2"));
  lab.request.reference = 1;
  std::ofstream(lab.folder / "two.toml")
      << "[camera]\nsource = \"v4l2:/dev/video0\"\ncalibration = \"west.toml\"\n"
         "[[camera.also]]\nsource = \"v4l2:/dev/video1\"\ncalibration = \"west.toml\"\n";
  EXPECT_THAT(lab.run(2), HasSubstr("found \"west.toml\", which camera 1 already has"));
  std::ofstream(lab.folder / "two.toml") << "[camera]\nsource = \"v4l2:/dev/video0\"\ncalibration = \"west.toml\"\n";
  EXPECT_THAT(lab.run(2), HasSubstr("has one camera; needed: two or more ([[camera.also]])"));
}

/// It was refused only when all films had been searched.
TEST(CalibrateJoint, WhereResultsGoIsCheckedBeforeTheFilmsAreSearched) {
  JointLab lab;  // without a film: the search would be the first to miss it
  std::ofstream(lab.folder / "file") << "no folder";
  for (const std::string& out : {lab.folder / "file", lab.folder / "file/joint", std::string("/proc/nowhere"),
                                 std::string("/proc/self"), std::string(300, 'n')}) {
    lab.request.out = out;
    EXPECT_THAT(lab.run(2), testing::Not(HasSubstr("run.mkv"))) << out;
  }
  lab.request.out = lab.folder / "new/joint";
  EXPECT_THAT(lab.run(3), HasSubstr("run.mkv"));
  EXPECT_FALSE(std::filesystem::exists(lab.folder / "new")) << "nothing is left behind";
}

}  // namespace
}  // namespace skein::app
