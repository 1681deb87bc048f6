#include "app/calibration/calibration_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <limits>
#include <optional>

#include "tests/app/folder.h"
#include "tests/places.h"
#include "tests/property.h"
#include "tests/small_disk.h"

namespace skein::app {
namespace {

using vision::Calibration;
using vision::default_tag_size;
using vision::overhead_calibration;

constexpr const char* good = R"([camera]
width = 1280
height = 960
fx = 1402
fy = 1400.5
cx = 644.3
cy = 476.1
distortion = [-0.09, 0.03, 0.0003, -0.0002, 0]

[world]
rotation = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
position = [0, 0, 2.5]

[tags]
height = 0.06
size = 0.05
)";

std::string with(const std::string& from, const std::string& to) {
  std::string text = good;
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST(CalibrationFile, IsRead) {
  const auto camera = parse_calibration(good, "cal.toml");
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_EQ(camera->width, 1280);
  EXPECT_EQ(camera->height, 960);
  EXPECT_EQ(camera->fx, 1402.0);
  EXPECT_EQ(camera->cy, 476.1);
  EXPECT_EQ(camera->distortion[3], -0.0002);
  EXPECT_EQ(camera->tag_size, 0.05);
  ASSERT_TRUE(camera->world_from_camera);
  EXPECT_EQ(camera->world_from_camera->rotation(1, 1), -1.0);
  EXPECT_EQ(camera->world_from_camera->position.z(), 2.5);
}

TEST(CalibrationFile, MayHaveIntrinsicsOnly) {
  const std::string text(good);
  const auto camera = parse_calibration(text.substr(0, text.find("[world]")), "cal.toml");
  ASSERT_TRUE(camera) << camera.error();
  EXPECT_FALSE(camera->world_from_camera);
  EXPECT_EQ(camera->tag_size, default_tag_size);
}

TEST(CalibrationFile, WhatIsSavedReadsBackToTheSameBits) {
  test::Folder folder;
  test::holds("save -> load", [&] {
    const double width = 0.5 + *rc::gen::inRange(0, 4000) * 1e-3;
    Calibration camera = overhead_calibration(width, 1.0 / 3.0 + width);
    camera.tag_height = width / 7.0;
    camera.row_time = 1e-4 * width / 3.0;
    const Eigen::Vector3d axis(width, 1.0, -0.3);
    camera.world_from_camera->rotation =
        Eigen::AngleAxisd(0.2 * width, axis.normalized()) * camera.world_from_camera->rotation;
    if (*rc::gen::arbitrary<bool>()) camera.world_from_camera.reset();
    if (*rc::gen::arbitrary<bool>()) {
      camera.marks = {{"tag 7", 7, width, -1.0 / 3.0, 0.0, 100.0 / width, 17.3, true, width / 9.0},
                      {"point 1", -1, 0.1 * width, 0.2, 0.003, 5.0 * width, 0.0, true},
                      {"tag 9", 9, 0.4, 0.5 * width}};
    }
    const auto back = parse_calibration(format_calibration(camera), "text");
    RC_ASSERT(back.has_value());
    RC_ASSERT(*back == camera);
  });
  const Calibration camera = overhead_calibration(2.0, 1.5);
  ASSERT_TRUE(save_calibration(camera, folder / "cal.toml"));
  const auto back = load_calibration(folder / "cal.toml");
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(*back, camera);
}

TEST(CalibrationFile, ProblemsSayWhereAndWhat) {
  const struct {
    std::string text;
    std::string message;
  } cases[] = {
      {with("cx = 644.3", "cx = "), "cal.toml:6:"},
      {with("fx = 1402", "fx = \"long\""),
       "cal.toml:4:6: camera.fx: found \"long\", allowed: a number from 128 to 1e+06 px"},
      {with("fx = 1402", "fx = -5"), "cal.toml:4:6: camera.fx: found -5, allowed: a number from 128 to 1e+06 px"},
      {with("fx = 1402", "fx = nan"), "cal.toml:4:6: camera.fx: found nan, allowed:"},
      {with("width = 1280", "width = 1280.5"),
       "cal.toml:2:9: camera.width: found 1280.5, allowed: a whole number from 16 to 32768"},
      {with("width = 1280", "width = 4"), "cal.toml:2:9: camera.width: found 4, allowed:"},
      {with("fy = 1400.5\n", ""), "cal.toml:1:1: camera.fy: missing, allowed: a number from 96 to 1e+06 px"},
      {with("cy = 476.1", "cy = 476.1\nzoom = 2"),
       "cal.toml:8:1: camera.zoom: unknown key, allowed in camera: width, height, fx"},
      {with("[tags]", "[tag]"),
       "cal.toml:14:2: tag: unknown key; did you mean tags? allowed: camera, world, tags, mark"},
      {with(", 0]\n", "]\n"),
       "cal.toml:8:14: camera.distortion: found [-0.09, 0.03, 0.0003, -0.0002], allowed: 5 numbers, each a number "
       "from"},
      {with("0.03", "true"), "cal.toml:8:14: camera.distortion: found [-0.09, true, 0.0003, -0.0002, 0], allowed: 5"},
      {with("0.03", "3000.0"), "cal.toml:8:14: camera.distortion: found [-0.09, 3000, 0.0003, -0.0002, 0], allowed: 5"},
      {with("[[1, 0, 0]", "[[1, 0.1, 0]"),
       "cal.toml:11:12: world.rotation: found a matrix R with R R' off the identity"},
      {with("[0, -1, 0]", "[0, 1, 0]"), "and det R = -1, allowed: a rotation"},
      {with("[[1, 0, 0], [0, -1, 0], [0, 0, -1]]", "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"),
       "cal.toml:11:12: world.rotation: found a camera that looks up (the last number is 1), allowed: one that looks "
       "down"},
      {with("[0, 0, 2.5]", "[0, 0, -2.5]"),
       "cal.toml:12:12: world.position: found a camera at a height of -2.5 m, allowed: above 0.06 m"},
      {with("[[1, 0, 0], ", "["),
       "cal.toml:11:12: world.rotation: found [[0, -1, 0], [0, 0, -1]], allowed: 3 rows of 3 numbers"},
      {with("position = [0, 0, 2.5]", "position = 2.5"),
       "cal.toml:12:12: world.position: found 2.5, allowed: 3 numbers, each a number from -100 to 100 m"},
      {with("size = 0.05", "size = 0"), "cal.toml:16:8: tags.size: found 0, allowed: a number from 0.001 to 10 m"},
      {with("[tags]", "[[mark]]\ntag = 600\nx = 0\ny = 0\n\n[tags]"),
       "cal.toml:15:7: mark.1.tag: found 600, allowed: a whole number from 0 to 586"},
      {with("[tags]", "[[mark]]\ntag = 6\nx = 0\n\n[tags]"), "mark.1.y: missing, allowed: a number from -100 to 100 m"},
      {with("[tags]", "[[mark]]\nx = 0\ny = 0\n\n[tags]"), "mark.1.pixel: missing, allowed: 2 numbers"},
      {with("[tags]", "[[mark]]\ntag = 6\nx = 0\ny = 0\n[[mark]]\ntag = 6\nx = 1\ny = 0\n\n[tags]"),
       "cal.toml:19:7: mark.2.tag: found 6 again, allowed: each tag once"},
      {with("[tags]", "[[mark]]\ntag = 6\nx = 0\ny = 0\nsize = 0\n\n[tags]"), "mark.1.size: found 0, allowed:"},
      {"camera = 3", "cal.toml:1:10: camera: found 3, allowed: a table [camera]"},
      {"", "camera: missing, allowed: the table [camera]"},
  };
  for (const auto& [text, message] : cases) {
    const auto camera = parse_calibration(text, "cal.toml");
    ASSERT_FALSE(camera) << message;
    EXPECT_NE(camera.error().find(message), std::string::npos) << camera.error() << "\nwanted: " << message;
  }
}

TEST(CalibrationFile, ATagThatDoesNotExistIsNoneThatWasThereBefore) {
  const auto camera = parse_calibration(
      with("[tags]", "[[mark]]\nx = 0\ny = 0\npixel = [1, 1]\n[[mark]]\ntag = 600\nx = 0\ny = 0\n\n[tags]"),
      "cal.toml");
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error(), "cal.toml:19:7: mark.2.tag: found 600, allowed: a whole number from 0 to 586");
}

TEST(CalibrationFile, EveryProblemIsNamedAtOnce) {
  const auto camera = parse_calibration(with("fx = 1402", "fx = -5").append("shine = 1\n"), "cal.toml");
  ASSERT_FALSE(camera);
  EXPECT_NE(camera.error().find("cal.toml:4:6: camera.fx: found -5"), std::string::npos) << camera.error();
  EXPECT_NE(camera.error().find("\ncal.toml:17:1: tags.shine: unknown key"), std::string::npos) << camera.error();
}

TEST(CalibrationFile, ASizeThatIsRefusedBoundsNothing) {
  for (const char* const size : {"width = 1280.0", "width = 4", "width = \"1280\"", ""}) {
    const auto camera = parse_calibration(with("width = 1280", size), "cal.toml");
    ASSERT_FALSE(camera);
    EXPECT_NE(camera.error().find("camera.width: "), std::string::npos) << camera.error();
    EXPECT_EQ(camera.error().find('\n'), std::string::npos) << camera.error();
  }
}

TEST(CalibrationFile, KeepsTheMarksOnTheFloor) {
  const auto camera = parse_calibration(std::string(good) +
                                            "[[mark]]\ntag = 20\nx = -0.9\ny = 0.6\nsize = 0.08\npixel = [412, 97.5]\n"
                                            "[[mark]]\nx = 0.9\ny = 0.6\nz = 0.01\npixel = [900.5, 97]\n",
                                        "cal.toml");
  ASSERT_TRUE(camera) << camera.error();
  const std::vector<vision::FloorMark> marks{{"tag 20", 20, -0.9, 0.6, 0.0, 412.0, 97.5, true, 0.08},
                                             {"point 1", -1, 0.9, 0.6, 0.01, 900.5, 97.0, true, 0.0}};
  EXPECT_EQ(camera->marks, marks);
}

TEST(CalibrationFile, DamagedTextIsRefusedOrReadButNeverWorse) {
  test::holds("text with some bytes changed", [] {
    std::string text = good;
    const int changes = *rc::gen::inRange(1, 6);
    for (int i = 0; i < changes; ++i) {
      const auto at = static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(text.size())));
      text[at] = *rc::gen::arbitrary<char>();
      if (*rc::gen::inRange(0, 4) == 0) text.erase(at, 9);
    }
    const auto camera = parse_calibration(text, "cal.toml");
    const bool told = camera.has_value() || camera.error().starts_with("cal.toml:");  // RC_ASSERT would ask for both
    RC_ASSERT(told);
  });
}

TEST(CalibrationFile, FilesThatCannotBeUsedAreNamed) {
  const auto camera = load_calibration("/nowhere/cal.toml");
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error(), "/nowhere/cal.toml: cannot be read: No such file or directory");
  const auto saved = save_calibration(overhead_calibration(1.0, 1.0), "/nowhere/cal.toml");
  ASSERT_FALSE(saved);
  EXPECT_EQ(saved.error(), "/nowhere/cal.toml: the calibration cannot be written there: there is no folder /nowhere");
  EXPECT_FALSE(load_calibration("/tmp")) << "a folder";
}

TEST(CalibrationFile, WhatIsWrittenOverIsKept) {
  const auto file = std::filesystem::temp_directory_path() / ("skein_replaced_" + std::to_string(::getpid()) + ".toml");
  auto old = file;
  old += ".old";
  const Calibration first = *parse_calibration(good, "cal.toml"), second = *parse_calibration(with("2.5", "2.6"), "");
  EXPECT_EQ(*replace_calibration(first, file), "") << "there was none";
  EXPECT_EQ(*replace_calibration(first, file), "") << "it said the same";
  EXPECT_FALSE(std::filesystem::exists(old));
  EXPECT_EQ(*replace_calibration(second, file), old);
  EXPECT_EQ(*load_calibration(file), second);
  EXPECT_EQ(*load_calibration(old), first);
  std::filesystem::remove(old);
  std::filesystem::create_directory(old);
  const auto refused = replace_calibration(first, file);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().find("nothing was written"), std::string::npos) << refused.error();
  EXPECT_EQ(*load_calibration(file), second);
  std::filesystem::remove(old);
  std::filesystem::remove(file);
}

TEST(CalibrationFile, WhatCouldNotBeReadAgainIsNotWritten) {
  const test::Folder folder;
  const std::string file = folder / "cal.toml";
  const Calibration good_one = *parse_calibration(good, "cal.toml");
  ASSERT_TRUE(save_calibration(good_one, file));
  Calibration high = good_one, unlike = good_one;
  high.world_from_camera->position.z() = 200.0;
  unlike.distortion[4] = std::numeric_limits<double>::quiet_NaN();
  for (const Calibration& wrong : {high, unlike}) {
    const auto saved = save_calibration(wrong, file);
    const auto replaced = replace_calibration(wrong, file);
    ASSERT_FALSE(saved);
    ASSERT_FALSE(replaced);
    EXPECT_TRUE(saved.error().starts_with(file + ": the calibration is not written, since it is none: " + file))
        << saved.error();
    EXPECT_EQ(replaced.error(), saved.error());
    EXPECT_EQ(*load_calibration(file), good_one);
    EXPECT_FALSE(std::filesystem::exists(file + ".old"));
  }
}

TEST(CalibrationFile, IsWrittenOverNothingElse) {
  const test::Folder folder;
  const Calibration first = *parse_calibration(good, "cal.toml"), second = *parse_calibration(with("2.5", "2.6"), "");
  for (const std::string& target : {std::string("/dev/full"), std::string(folder / "")}) {
    const auto refused = replace_calibration(first, target);
    ASSERT_FALSE(refused) << target;
    EXPECT_NE(refused.error().find("allowed: "), std::string::npos) << refused.error();
  }
  // What was read, and what a link leads to, stays where the previous contents would go.
  const std::string camera = folder / "camera.toml", old = camera + ".old", elsewhere = folder / "elsewhere.toml";
  ASSERT_TRUE(save_calibration(first, camera));
  ASSERT_TRUE(save_calibration(second, old));
  EXPECT_EQ(*replace_calibration(second, camera, std::array{old}), camera + ".old-2");
  EXPECT_EQ(*load_calibration(old), second);
  EXPECT_EQ(*load_calibration(camera + ".old-2"), first);
  ASSERT_TRUE(save_calibration(second, elsewhere));
  std::filesystem::remove(old);
  std::filesystem::create_symlink(elsewhere, old);
  EXPECT_EQ(*replace_calibration(first, camera), camera + ".old-2");
  EXPECT_EQ(*load_calibration(elsewhere), second);
}

TEST(CalibrationFile, StaysWholeWhereTheDiskIsFull) {
  const test::Folder folder;
  const Calibration first = *parse_calibration(good, "cal.toml"), second = *parse_calibration(with("2.5", "2.6"), "");
  const std::string camera = folder / "camera.toml";
  ASSERT_TRUE(save_calibration(first, camera));
  std::optional<test::SmallDisk> full(std::in_place, 100);
  const auto saved = save_calibration(second, camera);
  const auto replaced = replace_calibration(second, camera);
  full.reset();
  ASSERT_FALSE(saved);
  EXPECT_NE(saved.error().find("File too large"), std::string::npos) << saved.error();
  ASSERT_FALSE(replaced);
  EXPECT_EQ(*load_calibration(camera), first);
  EXPECT_FALSE(std::filesystem::exists(camera + ".old"));
}

TEST(CalibrationFile, TheOneThatIsHandedOutIsTheSyntheticCamera) {
  const auto camera = load_calibration(test::in_source("resources/cameras/overhead.toml"));
  ASSERT_TRUE(camera) << camera.error();
  const Calibration made = overhead_calibration(2.0, 1.5);
  EXPECT_EQ(camera->width, made.width);
  EXPECT_EQ(camera->distortion, made.distortion);
  // Sines and cosines may differ in their last bit from one machine to the next.
  EXPECT_LT((camera->world_from_camera->rotation - made.world_from_camera->rotation).norm(), 1e-12);
  EXPECT_LT((camera->world_from_camera->position - made.world_from_camera->position).norm(), 1e-9);
}

}  // namespace
}  // namespace skein::app
