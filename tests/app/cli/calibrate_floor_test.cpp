// skein calibrate floor, with marks from a file the first time and from the calibration itself after that.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
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

/// What a picture shows around a place on the floor is changed: `grey` of the pixel beside it in each row, by its
/// column and row in a square of 80 px.
void repaint(
    const vision::Calibration& camera, double x, double y, vision::Frame& frame,
    const std::function<std::uint8_t(const vision::Frame& before, int left, int top, int column, int row)>& grey) {
  constexpr int side = 80;
  const auto middle = vision::pixel_from_world(camera, {x, y, 0.0});
  const int left = static_cast<int>(middle->x()) - side / 2, top = static_cast<int>(middle->y()) - side / 2;
  const vision::Frame before = frame;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      frame.row(top + row)[left + column] = grey(before, left, top, column, row);
}

void mirror(const vision::Calibration& camera, double x, double y, vision::Frame& frame) {
  repaint(camera, x, y, frame, [](const vision::Frame& before, int left, int top, int column, int row) {
    return before.row(top + row)[left + 79 - column];
  });
}

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
  /// Lists one more tag, and lays it there if it is to be seen.
  void list(int id, double x, double y, bool there) {
    std::ofstream(folder / "floor.toml", std::ios::app) << fmt::format("[[tag]]\nid = {}\nx = {}\ny = {}\n", id, x, y);
    if (there) lay(id, x, y);
  }
  void lay(int id, double x, double y) {
    tags.push_back({.tag = id, .pose = {x, y, 0.3}, .size = 0.06, .lifted = -camera.tag_height, .bare = true});
  }
  /// A picture by the camera, tilted by so much since [deg].
  void photograph(const std::string& name, double tilt, const std::function<void(vision::Frame&)>& change = {},
                  const std::string& file = "0.pgm") {
    vision::Frame frame;
    vision::SyntheticCamera(vision::tilted(camera, tilt)).render(tags, 0.0, frame);
    if (change) change(frame);
    std::filesystem::create_directories(folder / name);
    skein::test::write_pgm(folder / (name + "/" + file), frame);
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

/// "mark 24 is not seen" was all that was said.
TEST(CalibrateFloor, SaysOfEachMarkThatIsNotSeenWhyAndWhere) {
  Lab lab;
  lab.request.marks = lab.folder / "floor.toml";
  const auto at_right_border = vision::world_from_pixel(lab.camera, {lab.camera.width - 8.0, 400.0}, 0.0);
  lab.list(30, 1.6, 0.1, true);
  lab.list(31, at_right_border->x(), at_right_border->y(), true);
  lab.list(5, -0.5, 0.4, false);
  lab.list(33, -0.5, 0.0, true);
  lab.list(34, -0.5, -0.4, true);
  lab.list(35, 0.5, 0.4, true);
  lab.list(36, 0.5, 0.0, false);
  lab.list(37, 0.5, -0.4, false);
  lab.lay(7, 0.5, -0.4);
  lab.photograph("one", 0.0, [&](vision::Frame& frame) {
    const auto change = [&](double x, double y, const auto& grey) { repaint(lab.camera, x, y, frame, grey); };
    using Before = const vision::Frame&;
    change(-0.5, 0.4, [](Before, int, int, int column, int row) {
      constexpr std::array tag_5_of_25h9{".........", ".#######.", ".####..#.", ".##.#.##.", ".#.##.##.",
                                         ".###.#.#.", ".#..#..#.", ".#######.", "........."};
      constexpr int cell = 5, first = 17;
      const int u = (column - first) / cell, v = (row - first) / cell;
      const bool in = column >= first && row >= first && u < 9 && v < 9;
      return std::uint8_t{in && tag_5_of_25h9[static_cast<std::size_t>(v)][u] == '#' ? std::uint8_t{30}
                                                                                     : std::uint8_t{220}};
    });
    mirror(lab.camera, -0.5, 0.0, frame);
    change(-0.5, -0.4, [](Before before, int left, int top, int column, int row) {
      return static_cast<std::uint8_t>(before.row(top + row)[left + column] / 100);
    });
    change(0.5, 0.4, [](Before, int, int, int, int) { return std::uint8_t{255}; });
  });
  for (const bool check : {false, true}) {
    const std::string out = lab.run(check ? calibrate_check : calibrate_floor, 0);
    EXPECT_THAT(out, HasSubstr("mark 30 is not seen: it lies outside the picture at (1.60, 0.10) m, pixel (15"));
    EXPECT_THAT(out, HasSubstr("mark 31 is not seen: the border of the picture cuts it at (1.11, 0.14) m, pixel (1272, "
                               "400) of 1280x960: move it inwards and measure its place again"));
    EXPECT_THAT(out, HasSubstr("mark 5 is not seen: tag 5 of the family 25h9 lies at (-0.50, 0.40) m, pixel (35"));
    EXPECT_THAT(out, HasSubstr("mark 33 is not seen: it is mirrored at (-0.5"));
    EXPECT_THAT(out, HasSubstr("mark 34 is not seen: the picture is dark at (-0.50, -0.40) m, pixel (35"));
    EXPECT_THAT(out, HasSubstr("mark 35 is not seen: the picture is too bright at (0.50, 0.40) m, pixel (93"));
    EXPECT_THAT(out, HasSubstr("mark 36 is not seen: nothing can be read at (0.50, 0.00) m, pixel (93"));
    EXPECT_THAT(out, HasSubstr("mark 37 is not seen: tag 7 lies in its place at (0.50, -0.40) m, pixel (93"));
    EXPECT_THAT(out, Not(HasSubstr("robot's"))) << "these are marks";
    for (const int seen : {20, 21, 22, 23, 24, 25}) EXPECT_THAT(out, Not(HasSubstr(fmt::format("mark {} is", seen))));
  }
}

/// Without a solution nobody knows where the picture should show a mark; what is found somewhere is told all the same.
TEST(CalibrateFloor, SaysWhyTooFewMarksAreSeen) {
  Lab lab;
  lab.request.marks = lab.folder / "floor.toml";
  lab.tags.erase(lab.tags.begin() + 4, lab.tags.end());
  lab.photograph("three", 0.0, [&](vision::Frame& frame) { mirror(lab.camera, -0.9, -0.65, frame); });
  const std::string out = lab.run(calibrate_floor, 3);
  EXPECT_THAT(out, HasSubstr("3 of 6 marks are seen; needed: 4 or more; nothing was written"));
  EXPECT_THAT(out, HasSubstr("mark 23 is not seen: it is mirrored at pixel (1"));
  EXPECT_THAT(out, HasSubstr("marks 24, 25 are not seen: no such tag is in the picture"));
}

/// It only said that the frame shows it twice, of a floor that may be covered with tags.
TEST(CalibrateFloor, SaysWhereATagIsTwice) {
  Lab lab;
  lab.request.marks = lab.folder / "floor.toml";
  const std::string before = skein::test::read_file(lab.request.camera);
  lab.lay(24, -0.4, 0.3);
  lab.photograph("twice", 0.0);
  const std::string out = lab.run(calibrate_floor, 3);
  EXPECT_THAT(out, HasSubstr("mark 24 is not seen: it is there twice at (-0.40, 0.30) m, pixel ("));
  EXPECT_THAT(out, HasSubstr(") and (0.10, 0.10) m, pixel ("));
  EXPECT_THAT(out, HasSubstr("take away what does not lie at (0.10, 0.10) m"));
  EXPECT_THAT(out, HasSubstr("tag 24 is in frame 0.pgm twice; allowed: once; nothing was written"));
  EXPECT_EQ(skein::test::read_file(lab.request.camera), before);
}

TEST(CalibrateFloor, SaysThatAMarkIsSeenInTooFewFrames) {
  Lab lab;
  lab.request.marks = lab.folder / "floor.toml";
  lab.request.frames = 3;
  lab.photograph("flicker", 0.0);
  lab.tags.pop_back();
  lab.photograph("flicker", 0.0, {}, "1.pgm");
  lab.photograph("flicker", 0.0, {}, "2.pgm");
  EXPECT_THAT(lab.run(calibrate_floor, 0), HasSubstr("mark 25 is seen in 1 of 3 frames only, and half are needed"));
}

/// A robot's tag is no mark.
TEST(CalibrateFloor, SaysWhyTheTagWhoseHeightIsToBeMeasuredIsNotSeen) {
  Lab lab;
  lab.request.marks = lab.folder / "floor.toml";
  lab.request.measure_height = 1;
  lab.lay(1, 0.5, 0.3);
  lab.photograph("mirrored", 0.0, [&](vision::Frame& frame) { mirror(lab.camera, 0.5, 0.3, frame); });
  EXPECT_THAT(lab.run(calibrate_floor, 3), HasSubstr("tag 1 is there, but mirrored: switch the camera's mirror off"));
}

}  // namespace
}  // namespace skein::app
