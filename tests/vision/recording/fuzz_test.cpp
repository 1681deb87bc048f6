// The fuzzers' promises (tests/fuzz), on changes at random and for a short while: every suite asks them.
#include "tests/fuzz/vision_targets.h"

#include "tests/places.h"
#include "tests/vision/support.h"
#include "vision/recording/recorder.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/random.h"

namespace skein {
namespace {

std::vector<std::uint8_t> changes(vision::detail::Random& random, std::size_t file_size) {
  std::vector<std::uint8_t> bytes{1};
  for (std::size_t k = 0; k < 1 + random.below(3); ++k) {
    const std::size_t place = random.below(file_size);
    for (const std::size_t byte : {place % 256, place / 256 % 256, place / 65536, random.below(256)})
      bytes.push_back(static_cast<std::uint8_t>(byte));
  }
  return bytes;
}

TEST(Fuzz, DamagedFilms) {
  test::Folder folder;
  const std::string path = folder.file("film.mkv");
  const std::vector<vision::Frame> film = fuzz::small_film();
  {
    auto recorder = vision::Recorder::open(path);
    ASSERT_TRUE(recorder) << recorder.error();
    for (const vision::Frame& frame : film) (*recorder)->add(frame);
  }
  const std::vector<std::uint8_t> well = fuzz::read_bytes(path);
  const auto opener = [](const std::string& file) -> std::unique_ptr<vision::FrameSource> {
    auto source = vision::open_source("video:" + file);
    return source ? std::move(*source) : nullptr;
  };
  vision::detail::Random random(31);
  for (int k = 0; k < (test::sanitized ? 100 : 1000); ++k) {
    fuzz::write_bytes(path, fuzz::changed(well, changes(random, well.size())));
    fuzz::frames(path, opener, film);
  }
}

TEST(Fuzz, SeedsAreWell) {
  // What the fuzzer of calibrations begins with: each is one, or marks on a floor.
  int calibrations = 0, floors = 0;
  for (const auto& file : std::filesystem::directory_iterator(test::in_source("tests/fuzz/seeds/fuzz_calibration"))) {
    const std::vector<std::uint8_t> bytes = fuzz::read_bytes(file.path().string());
    const std::string text(bytes.begin(), bytes.end());
    const bool calibration = vision::parse_calibration(text, "seed").has_value();
    const bool floor = vision::parse_floor_marks(text, "seed").has_value();
    EXPECT_TRUE(calibration || floor) << file.path();
    calibrations += calibration ? 1 : 0;
    floors += floor ? 1 : 0;
    fuzz::calibration(bytes);
    vision::detail::Random random(33);
    for (int k = 0; k < 500; ++k) fuzz::calibration(fuzz::changed(bytes, changes(random, bytes.size())));
  }
  EXPECT_GE(calibrations, 3);
  EXPECT_GE(floors, 1);
}

TEST(Fuzz, DamagedCalibrations) {
  const std::string text = vision::format_calibration(vision::overhead_calibration(2.0, 1.5)) +
                           "[[tag]]\nid = 3\nx = 0.5\ny = -1\n[[point]]\nu = 3.5\nv = 7\nx = 1\ny = 0\n";
  const std::vector<std::uint8_t> well(text.begin(), text.end());
  vision::detail::Random random(32);
  for (int k = 0; k < 2000; ++k) fuzz::calibration(fuzz::changed(well, changes(random, well.size())));
}

}  // namespace
}  // namespace skein
