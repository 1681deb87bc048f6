// A camera that delivers the same picture again and again.
#include "vision/diagnosis/repeat_watch.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace skein::vision {
namespace {

/// A camera whose frames are read as a source reads them: into the same Frame, with anything in it before.
struct RepeatingCamera {
  RepeatWatch watch;
  Frame frame;
  double t = 0.0;

  bool repeats(std::uint8_t last_pixel) {
    watch.keep(frame);
    frame.resize(64, 48);
    std::iota(frame.grey.begin(), frame.grey.end(), std::uint8_t{0});
    frame.grey.back() = last_pixel;
    frame.captured_at = t += 0.04;
    return watch.repeats(frame);
  }
};

TEST(RepeatWatch, KnowsAFrameThatShowsWhatTheLastOneShowed) {
  RepeatingCamera camera;
  EXPECT_FALSE(camera.repeats(1)) << "the first";
  EXPECT_FALSE(camera.repeats(2)) << "a single pixel differs";
  EXPECT_TRUE(camera.repeats(2));
  EXPECT_TRUE(camera.repeats(2));
  EXPECT_FALSE(camera.repeats(1));
  EXPECT_FALSE(camera.repeats(2)) << "the one before the last does not count";
}

TEST(RepeatWatch, FrozenIsWhatLasts) {
  RepeatingCamera camera;
  camera.repeats(1);
  for (int frame = 0; frame < 6; ++frame) {
    EXPECT_TRUE(camera.repeats(1));
    EXPECT_FALSE(camera.watch.frozen()) << camera.t;
  }
  camera.repeats(1);
  camera.repeats(1);
  EXPECT_TRUE(camera.watch.frozen());
  camera.repeats(2);
  EXPECT_FALSE(camera.watch.frozen());
  for (int frame = 0; frame < 50; ++frame) {  // a camera that exposes for two frame times delivers each picture twice
    camera.repeats(static_cast<std::uint8_t>(frame / 2));
    EXPECT_FALSE(camera.watch.frozen());
  }
}

}  // namespace
}  // namespace skein::vision
