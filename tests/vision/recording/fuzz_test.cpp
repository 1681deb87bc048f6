// The fuzzers' promises (tests/fuzz), on changes at random and for a short while: every suite asks them.
#include "tests/fuzz/vision_targets.h"

#include "tests/vision/support.h"
#include "vision/recording/recorder.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/random.h"

namespace skein {
namespace {

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
    fuzz::write_bytes(path, fuzz::changed(well, fuzz::random_changes(random, well.size())));
    fuzz::frames(path, opener, film);
  }
}

}  // namespace
}  // namespace skein
