// What tests/fuzz promises of these files, on changes at random and for a short while.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/fuzz/calibration_target.h"
#include "tests/places.h"
#include "vision/synthetic/random.h"

namespace skein::app {
namespace {

TEST(CalibrationFuzz, SeedsAreCalibrationsAndMarks) {
  // What the fuzzer begins with.
  int calibrations = 0, floors = 0;
  for (const auto& file : std::filesystem::directory_iterator(test::in_source("tests/fuzz/seeds/fuzz_calibration"))) {
    const std::vector<std::uint8_t> bytes = fuzz::read_bytes(file.path().string());
    const std::string text(bytes.begin(), bytes.end());
    const bool calibration = parse_calibration(text, "seed").has_value();
    const bool floor = parse_floor_marks(text, "seed").has_value();
    EXPECT_TRUE(calibration || floor) << file.path();
    calibrations += calibration ? 1 : 0;
    floors += floor ? 1 : 0;
    fuzz::calibration(bytes);
    vision::detail::Random random(33);
    for (int k = 0; k < 500; ++k) fuzz::calibration(fuzz::changed(bytes, fuzz::random_changes(random, bytes.size())));
  }
  EXPECT_GE(calibrations, 3);
  EXPECT_GE(floors, 1);
}

TEST(CalibrationFuzz, DamagedFilesAreRefusedOrRead) {
  const std::string text = format_calibration(vision::overhead_calibration(2.0, 1.5)) +
                           "[[tag]]\nid = 3\nx = 0.5\ny = -1\n[[point]]\nu = 3.5\nv = 7\nx = 1\ny = 0\n";
  const std::vector<std::uint8_t> well(text.begin(), text.end());
  vision::detail::Random random(32);
  for (int k = 0; k < 2000; ++k) fuzz::calibration(fuzz::changed(well, fuzz::random_changes(random, well.size())));
}

}  // namespace
}  // namespace skein::app
