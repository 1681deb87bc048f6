#include "vision/track/track.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/vision/support.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::vision {
namespace {

constexpr const char* corner_columns = "frame,source,t,tag,u1,v1,u2,v2,u3,v3,u4,v4,";

/// Three pictures: tags 1 and 2; tag 1, moved a little, and two of tag 2; tag 1 again, elsewhere.
std::vector<std::vector<SyntheticTag>> scene() {
  return {{{1, {0.2, 0.1, 0.5}}, {2, {-0.7, -0.4, -2.5}}},
          {{1, {0.21, 0.1, 0.6}}, {2, {0.8, 0.6, 0.0}}, {2, {-0.69, -0.4, -2.5}}},
          {{1, {-0.9, 0.7, 3.0}}}};
}

void take_pictures(const test::Folder& folder, const Calibration& calibration) {
  SyntheticCamera camera(calibration, {}, 2);
  Frame frame;
  int i = 0;
  for (const auto& tags : scene()) {
    camera.render(tags, 0.0, frame);
    test::write_pgm(folder.file(fmt::format("{:03}.pgm", i++)), frame);
  }
}

TEST(Track, WritesPosesWithACalibration) {
  test::Folder folder;
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  take_pictures(folder, calibration);
  std::ostringstream csv;
  const auto summary = track({.source = "images:" + folder.path(), .calibration = calibration, .csv = &csv});
  ASSERT_TRUE(summary) << summary.error();
  EXPECT_EQ(summary->frames, 3);
  EXPECT_EQ(summary->detections, 6);
  EXPECT_EQ(summary->ids, (std::vector{1, 2}));
  EXPECT_TRUE(summary->skipped.empty());

  EXPECT_TRUE(csv.str().starts_with(std::string(corner_columns) + "x,y,theta,sigma_xy,sigma_theta,how\n"));
  const auto rows = test::read_csv(csv.str());
  ASSERT_EQ(rows.size(), 6U);
  const char* how[] = {"detected", "detected", "tracked", "tracked", "recovered", "recovered"};
  const auto scenes = scene();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    auto row = rows[i];
    const auto frame = static_cast<std::size_t>(std::stoi(row["frame"]));
    EXPECT_EQ(row["source"], fmt::format("{:03}.pgm", frame));
    EXPECT_EQ(std::stod(row["t"]), static_cast<double>(frame) / 25.0);
    const core::Pose pose{std::stod(row["x"]), std::stod(row["y"]), std::stod(row["theta"])};
    const auto& tags = scenes[frame];
    const bool right = std::any_of(tags.begin(), tags.end(), [&](const SyntheticTag& tag) {
      return std::to_string(tag.tag) == row["tag"] && core::distance(tag.pose, pose) < 5e-4 &&
             std::abs(core::wrap_angle(tag.pose.theta - pose.theta)) < 0.01;
    });
    EXPECT_TRUE(right) << "row " << i;
    EXPECT_GT(std::stod(row["sigma_xy"]), 1e-5);
    EXPECT_LT(std::stod(row["sigma_theta"]), 1e-2);
    if (row["frame"] != "1" || row["tag"] == "1") {
      EXPECT_EQ(row["how"], how[i]) << "row " << i;
    }
    // The heading runs from the first corner to the second.
    const double du = std::stod(row["u2"]) - std::stod(row["u1"]);
    const double dv = std::stod(row["v2"]) - std::stod(row["v1"]);
    EXPECT_NEAR(core::wrap_angle(std::atan2(-dv, du) - pose.theta), 0.0, 0.05);
  }
  // The copies of tag 2: one goes on from the frame before, the other is new in that place.
  EXPECT_NE(rows[3].at("how"), rows[4].at("how"));
}

TEST(Track, WritesCornersWithoutACalibration) {
  test::Folder folder;
  take_pictures(folder, overhead_calibration(2.0, 1.5));
  std::ostringstream csv;
  const auto summary = track({.source = "images:" + folder.path(), .csv = &csv, .max_frames = 2});
  ASSERT_TRUE(summary) << summary.error();
  EXPECT_EQ(summary->frames, 2);
  EXPECT_TRUE(csv.str().starts_with(std::string(corner_columns) + "how\n"));
  EXPECT_EQ(test::read_csv(csv.str()).size(), 5U);
}

TEST(Track, LeavesPosesEmptyWhenOnlyTheLensIsKnown) {
  test::Folder folder;
  Calibration calibration = overhead_calibration(2.0, 1.5);
  take_pictures(folder, calibration);
  calibration.world_from_camera.reset();
  std::ostringstream csv;
  ASSERT_TRUE(track({.source = "images:" + folder.file("000.pgm"), .calibration = calibration, .csv = &csv}));
  const auto rows = test::read_csv(csv.str());
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("x"), "");
  EXPECT_EQ(rows[0].at("sigma_theta"), "");
  EXPECT_EQ(rows[0].at("how"), "detected");
}

TEST(Track, GivesTheSameTableTwice) {
  test::Folder folder;
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  take_pictures(folder, calibration);
  std::ostringstream csv[2];
  for (auto& out : csv)
    ASSERT_TRUE(track({.source = "images:" + folder.path(), .calibration = calibration, .csv = &out}));
  EXPECT_EQ(csv[0].str(), csv[1].str());
}

TEST(Track, ReportsSkippedPicturesAndNamesThatNeedQuotes) {
  test::Folder folder;
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  SyntheticCamera camera(calibration, {}, 2);
  Frame frame;
  camera.render(scene()[2], 0.0, frame);
  test::write_pgm(folder.file("a, \"b\".pgm"), frame);
  test::write_file(folder.file("broken.png"), "no");
  std::ostringstream csv;
  const auto summary = track({.source = "images:" + folder.path(), .csv = &csv});
  ASSERT_TRUE(summary) << summary.error();
  EXPECT_EQ(summary->frames, 1);
  ASSERT_EQ(summary->skipped.size(), 1U);
  EXPECT_EQ(
      summary->skipped[0],
      folder.file("broken.png") + ": is of a format that cannot be read, allowed: png, jpg, pgm, ppm, bmp, tif, webp");
  EXPECT_NE(csv.str().find("\n0,\"a, \"\"b\"\".pgm\",0,1,"), std::string::npos) << csv.str();
}

TEST(Track, APictureForWhichThereIsNoMemoryIsNotCalledDamaged) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "AddressSanitizer ends the program itself where memory is limited";
#endif
  test::Folder folder;
  test::write_file(folder.file("vast.pgm"), "P5\n20000 20000\n255\n");
  const auto reason = [&](std::size_t megabytes) {
    const auto source = open_source("images:" + folder.path());
    if (!source) std::_Exit(1);
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t most = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + (megabytes << 20);
    const rlimit little{most, most};
    if (setrlimit(RLIMIT_AS, &little) != 0) std::_Exit(2);
    Frame frame;
    static_cast<void>((*source)->read(frame));
    const auto skipped = (*source)->skipped();
    if (skipped.size() != 1) std::_Exit(3);
    std::_Exit(skipped[0].ends_with(": needs more memory than there is") ? 7
               : skipped[0].ends_with(": cannot be decoded")             ? 8
                                                                         : 4);
  };
  EXPECT_EXIT(reason(200), ::testing::ExitedWithCode(7), "");
  EXPECT_EXIT(reason(2000), ::testing::ExitedWithCode(8), "") << "the control: it has no pixels";
}

TEST(Track, ATableThatFindsNoRoomIsAnError) {
  test::Folder folder;
  take_pictures(folder, overhead_calibration(2.0, 1.5));
  std::ofstream csv("/dev/full");  // what is short stands in a buffer until the end
  const auto summary = track({.source = "images:" + folder.path(), .csv = &csv});
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error(), "the CSV cannot be written");
}

TEST(Track, CanBeEnded) {
  test::Folder folder;
  take_pictures(folder, overhead_calibration(2.0, 1.5));
  const auto summary =
      track({.source = "images:" + folder.path(), .keep_going = [](std::int64_t frames) { return frames < 2; }});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->frames, 2);
}

TEST(Track, FailsClearly) {
  test::Folder folder;
  test::write_pgm(folder.file("small.pgm"), test::uniform_frame(64, 48, 100));
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  const auto wrong_size = track({.source = "images:" + folder.path(), .calibration = calibration});
  ASSERT_FALSE(wrong_size);
  EXPECT_EQ(wrong_size.error(), "frame 0 (small.pgm) of images " + folder.path() +
                                    " (1 picture) is 64x48 px, but the calibration holds for 1280x960");
  EXPECT_FALSE(track({.source = "nonsense"}));
  EXPECT_FALSE(track({.source = "images:/nowhere"}));

  test::write_file(folder.file("small.pgm"), "broken");
  const auto unreadable = track({.source = "images:" + folder.path()});
  ASSERT_FALSE(unreadable);
  EXPECT_NE(unreadable.error().find("none of its images can be read"), std::string::npos) << unreadable.error();

  test::write_pgm(folder.file("small.pgm"), test::uniform_frame(64, 48, 100));
  std::ofstream full("/dev/full");
  full << std::unitbuf;
  EXPECT_FALSE(track({.source = "images:" + folder.path(), .csv = &full})) << "the disc is full";
}

}  // namespace
}  // namespace skein::vision
