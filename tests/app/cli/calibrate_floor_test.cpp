// skein calibrate floor, with marks from a file the first time and from the calibration itself after that.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "app/calibration/calibration_file.h"
#include "app/cli/command_calibrate.h"
#include "app/run/interrupted.h"
#include "tests/app/folder.h"
#include "tests/files.h"
#include "tests/pgm.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

using ::testing::HasSubstr;

/// Six tags on the floor under a camera, photographed, and listed in a file.
struct Lab {
  test::Folder folder;
  vision::Calibration camera = vision::overhead_calibration(2.0, 1.5);
  std::vector<vision::SyntheticTag> tags;
  FloorRequest request;

  Lab() {
    std::ofstream marks(folder / "floor.toml");
    for (const auto& [x, y] :
         {std::pair{-0.9, 0.65}, {0.9, 0.65}, {0.9, -0.65}, {-0.9, -0.65}, {0.1, 0.1}, {0.2, -0.6}}) {
      const int id = 20 + static_cast<int>(tags.size());
      tags.push_back({.tag = id, .pose = {x, y, 0.3}, .size = 0.06, .lifted = -camera.tag_height, .bare = true});
      marks << fmt::format("[[tag]]\nid = {}\nx = {}\ny = {}\n", id, x, y);
    }
    vision::Calibration lens = camera;
    lens.world_from_camera.reset();
    EXPECT_TRUE(save_calibration(lens, folder / "cal.toml"));
    request.camera = folder / "cal.toml";
    request.frames = 1;
  }
  /// A picture by the camera, tilted by so much since [deg].
  void photograph(const std::string& name, double tilt) {
    vision::Frame frame;
    vision::SyntheticCamera(vision::tilted(camera, tilt)).render(tags, 0.0, frame);
    std::filesystem::create_directories(folder / name);
    skein::test::write_pgm(folder / (name + "/0.pgm"), frame);
    request.source = "images:" + (folder / name);
  }
  std::string run(int (*command)(const FloorRequest&), int expected) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = command(request);
    std::string out = testing::internal::GetCapturedStdout();
    out += testing::internal::GetCapturedStderr();
    EXPECT_EQ(status, expected) << out;
    return out;
  }
};

TEST(CalibrateFloor, GoesByTheMarksOfTheCalibrationWhenTheCameraHasMoved) {
  Lab lab;
  lab.photograph("first", 0.0);
  EXPECT_THAT(lab.run(calibrate_floor, 2), HasSubstr("has no tags on the floor ([[mark]]), allowed: --marks"));
  lab.request.marks = lab.folder / "floor.toml";
  EXPECT_THAT(lab.run(calibrate_floor, 0), Not(HasSubstr("poses_move_mm"))) << "there was no world frame";
  const auto first = load_calibration(lab.request.camera);
  ASSERT_TRUE(first) << first.error();
  ASSERT_EQ(first->marks.size(), 6U);
  EXPECT_TRUE(first->marks[0].seen);
  EXPECT_NEAR(first->marks[0].size, 0.06, 0.5e-3);

  lab.request.marks.clear();
  lab.photograph("later", 1.0);
  lab.request.limit = 0.005;
  EXPECT_THAT(lab.run(calibrate_check, 1), HasSubstr("a mark is off by 4")) << "shown before anything is written";
  EXPECT_EQ(*load_calibration(lab.request.camera), *first);
  const std::string out = lab.run(calibrate_floor, 0);
  EXPECT_THAT(out, HasSubstr("(centre): moves by 4"));
  EXPECT_THAT(out, HasSubstr("(top right): moves by 4"));
  EXPECT_THAT(out, HasSubstr("poses_move_mm: 4"));
  EXPECT_THAT(out, HasSubstr("its previous contents are in " + lab.request.camera + ".old"));
  EXPECT_EQ(*load_calibration(lab.request.camera + ".old"), *first);
  const auto second = load_calibration(lab.request.camera);
  ASSERT_TRUE(second) << second.error();
  const vision::CameraPose truth = *vision::tilted(lab.camera, 1.0).world_from_camera;
  EXPECT_LT((second->world_from_camera->position - truth.position).norm(), 3e-3);
  EXPECT_LT((second->world_from_camera->rotation - truth.rotation).norm(), 2e-3);
  EXPECT_EQ(second->marks.size(), 6U);
  EXPECT_THAT(lab.run(calibrate_check, 0), HasSubstr("marks: 6"));
}

TEST(CalibrateFloor, LooksAtNothingIfItsFileCannotBeWritten) {
  Lab lab;
  lab.request.source = "video:there-is-none.mkv";
  lab.request.marks = lab.folder / "floor.toml";
  const std::string marks = skein::test::read_file(lab.request.marks);
  lab.request.out = lab.request.marks;
  EXPECT_THAT(lab.run(calibrate_floor, 2), HasSubstr("is the file of the marks, allowed: another name"));
  EXPECT_EQ(skein::test::read_file(lab.request.marks), marks);
  lab.request.out = lab.folder / "no/such/camera.toml";
  EXPECT_THAT(lab.run(calibrate_floor, 2), HasSubstr("there is no folder"));
  lab.request.out = "/dev/full";
  EXPECT_THAT(lab.run(calibrate_floor, 2), HasSubstr("a device or a FIFO, allowed: a file"));
}

/// In centimetres the camera would hang 200 m high. The result was written, and no command could read it.
TEST(CalibrateFloor, RefusesMarksInAnotherUnit) {
  Lab lab;
  lab.photograph("first", 0.0);
  const std::string before = skein::test::read_file(lab.request.camera);
  const auto say = [&](double unit) {
    lab.request.marks = lab.folder / "unit.toml";
    std::ofstream marks(lab.request.marks);
    for (const vision::SyntheticTag& tag : lab.tags)
      marks << fmt::format("[[tag]]\nid = {}\nx = {}\ny = {}\n", tag.tag, unit * tag.pose.x, unit * tag.pose.y);
    marks.close();
    std::string said = lab.run(calibrate_floor, 3);
    EXPECT_EQ(skein::test::read_file(lab.request.camera), before);
    return said;
  };
  EXPECT_THAT(say(100.0), HasSubstr(") m; allowed: 100 m and less: are the places of the marks in m?"));
  EXPECT_THAT(say(39.37), HasSubstr("on the floor would have an edge of 2.36e+03 mm; allowed: 5 to 2000 mm"));
  EXPECT_THAT(say(0.01), HasSubstr("allowed: 5 to 2000 mm: are the places of the marks in m?; nothing was written"));
}

TEST(CalibrateFloor, WritesOverNothingThatItReads) {
  Lab lab;
  lab.photograph("first", 0.0);
  lab.request.marks = lab.folder / "floor.toml";
  const std::string picture = lab.folder / "first/0.pgm", before = skein::test::read_file(picture);
  for (const std::string& source : {lab.request.source, "images:" + picture}) {
    lab.request.source = source;
    lab.request.out = picture;
    EXPECT_THAT(lab.run(calibrate_floor, 2), HasSubstr(picture + ": belongs to " + source + ", allowed: another name"));
    IntrinsicsRequest intrinsics;
    intrinsics.source = source;
    intrinsics.out = picture;
    testing::internal::CaptureStderr();
    EXPECT_EQ(calibrate_intrinsics(intrinsics), 2);
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("belongs to " + source));
    EXPECT_EQ(skein::test::read_file(picture), before);
  }
  lab.request.out = lab.folder / "first/camera.toml";  // the control: beside the pictures it may lie
  lab.run(calibrate_floor, 0);
  lab.run(calibrate_floor, 0);
}

TEST(CalibrateFloor, WritesNothingOnCtrlC) {
  Lab lab;
  lab.photograph("first", 0.0);
  lab.request.marks = lab.folder / "floor.toml";
  const auto before = load_calibration(lab.request.camera);
  const auto interrupted_calibration = [&] {
    interrupt();
    return calibrate_floor(lab.request);
  };
  EXPECT_EXIT(std::exit(interrupted_calibration()), testing::ExitedWithCode(3), "");
  EXPECT_EQ(*load_calibration(lab.request.camera), *before);
  lab.run(calibrate_floor, 0);
  EXPECT_NE(*load_calibration(lab.request.camera), *before) << "the control";
}

}  // namespace
}  // namespace skein::app
