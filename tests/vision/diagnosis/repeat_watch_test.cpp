// A camera that delivers the same picture again and again.
#include "vision/diagnosis/repeat_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
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

/// A camera with a sensor's noise, except where a test changes its pixels.
struct NoisyCamera {
  static constexpr int width = 128, height = 90;
  RepeatWatch watch;
  Frame frame;
  std::mt19937 random{1};
  std::normal_distribution<float> noise{100.0F, 1.0F};
  std::vector<Frame::Grey> before;  // what its frames showed
  double t = 0.0;

  static auto row(Frame::Grey& grey, int v) { return grey.begin() + std::ptrdiff_t{width} * v; }
  /// Fills all rows from `top` on.
  static void paint(Frame::Grey& grey, int top, std::uint8_t level) { std::fill(row(grey, top), grey.end(), level); }

  /// Whether the next frame repeats; `change` is done to its pixels first.
  template <class Change>
  bool repeats(Change&& change) {
    watch.keep(frame);
    frame.resize(width, height);
    std::generate(frame.grey.begin(), frame.grey.end(), [this] { return static_cast<std::uint8_t>(noise(random)); });
    change(frame.grey);
    before.push_back(frame.grey);
    frame.captured_at = t += 0.04;
    return watch.repeats(frame);
  }
  bool repeats() {
    return repeats([](auto&) {});
  }
  /// The same for a frame that shows in these rows what the one so many frames before it showed.
  bool repeats_rows(int from, int to, std::size_t ago) {
    return repeats([&](Frame::Grey& grey) {
      Frame::Grey& older = before[before.size() - ago];
      std::copy(row(older, from), row(older, to), row(grey, from));
    });
  }
};

TEST(RepeatWatch, KnowsAPartThatAnOlderFrameShowed) {
  // A driver fills its buffers in turn: a transfer that breaks off leaves in each what was in it.
  for (const std::size_t ago : {2, 3, 4, 5, 8})
    for (const int from : {0, 45}) {
      NoisyCamera camera;
      for (int frame = 0; frame < 9; ++frame) EXPECT_FALSE(camera.repeats());
      for (int frame = 0; frame < 6; ++frame) {
        EXPECT_TRUE(camera.repeats_rows(from, from + 45, ago)) << ago << " frames ago";
        EXPECT_NEAR(camera.watch.part(), 0.5, 0.01);
        EXPECT_FALSE(camera.watch.frozen());
      }
      camera.repeats_rows(from, from + 45, ago);
      camera.repeats_rows(from, from + 45, ago);
      EXPECT_TRUE(camera.watch.frozen());
      for (int frame = 0; frame < 9; ++frame) {
        EXPECT_FALSE(camera.repeats());
        EXPECT_FALSE(camera.watch.frozen());
        EXPECT_EQ(camera.watch.part(), 0.0);
      }
    }
}

TEST(RepeatWatch, KnowsAPartThatIsAsHighAsTheSmallestTag) {
  NoisyCamera camera;
  for (int frame = 0; frame < 9; ++frame) EXPECT_FALSE(camera.repeats());
  for (int from = 0; from + 16 <= NoisyCamera::height; ++from)
    EXPECT_TRUE(camera.repeats_rows(from, from + 16, 4)) << from;
}

TEST(RepeatWatch, KnowsBuffersThatAreNotFilledAnyMore) {
  NoisyCamera camera;
  for (int frame = 0; frame < 9; ++frame) EXPECT_FALSE(camera.repeats());
  for (int frame = 0; frame < 20; ++frame) {
    EXPECT_TRUE(camera.repeats_rows(0, NoisyCamera::height, 4));
    EXPECT_EQ(camera.watch.part(), 1.0);
  }
  EXPECT_TRUE(camera.watch.frozen());
  EXPECT_FALSE(camera.repeats());
}

TEST(RepeatWatch, FramesOfAnotherSizeAreNotCompared) {
  NoisyCamera camera;
  for (int frame = 0; frame < 9; ++frame) EXPECT_FALSE(camera.repeats());
  Frame larger;
  larger.resize(2 * NoisyCamera::width, 2 * NoisyCamera::height + 3);
  camera.watch.keep(camera.frame);
  EXPECT_FALSE(camera.watch.repeats(larger));
  camera.watch.keep(larger);
  for (int frame = 0; frame < 9; ++frame) EXPECT_FALSE(camera.repeats());
  EXPECT_TRUE(camera.repeats_rows(45, 90, 4));
}

/// What has no noise proves nothing, whenever it appears.
TEST(RepeatWatch, APartWithoutNoiseIsNoOldOne) {
  // A bar below the picture, with or without letters in it, from the beginning or from the middle of a run on; a lamp
  // by which the floor is clipped.
  for (const int from : {0, 25})
    for (const int letters : {0, 1, 2}) {
      NoisyCamera camera;
      for (int frame = 0; frame < 50; ++frame)
        EXPECT_FALSE(camera.repeats([&](Frame::Grey& grey) {
          for (int v = 60; frame >= from && v < NoisyCamera::height; ++v)
            for (int u = 0; u < NoisyCamera::width; ++u)
              NoisyCamera::row(grey, v)[u] = static_cast<std::uint8_t>(letters == 0 ? 255 : letters * 40 * (u % 5));
        })) << letters
            << " in frame " << frame;
      for (int frame = 0; frame < 4; ++frame)
        EXPECT_TRUE(camera.repeats([&](Frame::Grey& grey) {
          Frame::Grey& older = camera.before[camera.before.size() - 4];
          std::copy(NoisyCamera::row(older, 32), older.end(), NoisyCamera::row(grey, 32));
        })) << "the control: what is above the bar counts";
    }
}

TEST(RepeatWatch, ABarThatBlinksAndALightThatFlickersAreNoOldPart) {
  for (const int period : {2, 3, 4, 6}) {
    NoisyCamera bar, light;
    for (int frame = 0; frame < 60; ++frame) {
      EXPECT_FALSE(bar.repeats([&](auto& grey) {
        if (frame % period < period / 2) NoisyCamera::paint(grey, 60, 255);
      }));
      const bool as_before = light.repeats([&](auto& grey) {  // by it all of the floor is clipped, or none of it
        if (frame % period < period / 2) NoisyCamera::paint(grey, 0, 255);
      });
      EXPECT_EQ(as_before, frame % period > 0 && frame % period < period / 2) << "as the last one, if at all";
      EXPECT_FALSE(bar.watch.frozen() || light.watch.frozen());
    }
  }
}

/// Letters in all of a row that vanish and come back look as noise does: a single frame is left out, but none stands.
TEST(RepeatWatch, LettersThatBlinkFreezeNoCamera) {
  for (const int period : {2, 3, 4, 6, 10}) {
    NoisyCamera camera;
    bool before = false;
    for (int frame = 0; frame < 100; ++frame) {
      const bool repeats = camera.repeats([&](Frame::Grey& grey) {
        for (int v = 60; frame % period < period / 2 && v < NoisyCamera::height; ++v)
          for (int u = 0; u < NoisyCamera::width; ++u)
            NoisyCamera::row(grey, v)[u] = static_cast<std::uint8_t>(40 * (u % 5));
      });
      EXPECT_FALSE(repeats && before) << "never two in a row";
      EXPECT_FALSE(camera.watch.frozen());
      before = repeats;
    }
  }
}

TEST(RepeatWatch, APictureThatIsCodedMayStandStillWhereNothingMoves) {
  // Everything comes anew with every tenth frame; in between only what moves does: half the width of the upper part.
  NoisyCamera moving;
  for (int frame = 0; frame < 50; ++frame)
    EXPECT_FALSE(moving.repeats([&](Frame::Grey& grey) {
      if (frame % 10 < 2) return;
      for (int v = 0; v < NoisyCamera::height; ++v) {
        const int still_from = v < 40 ? NoisyCamera::width / 2 : 0;
        std::copy_n(NoisyCamera::row(moving.before.back(), v) + still_from, NoisyCamera::width - still_from,
                    NoisyCamera::row(grey, v) + still_from);
      }
    }));
  // A coder that refreshes one part of the height after the other, all of the width: the rest is as it was.
  NoisyCamera refreshed;
  for (int frame = 0; frame < 50; ++frame)
    EXPECT_FALSE(refreshed.repeats([&](Frame::Grey& grey) {
      if (frame == 0) return;
      const int part = frame % 6 * 16;
      for (int v = 0; v < NoisyCamera::height; ++v)
        if (v < part || v >= part + 16)
          std::copy_n(NoisyCamera::row(refreshed.before.back(), v), NoisyCamera::width, NoisyCamera::row(grey, v));
    }));
}

/// A coder that leaves nothing of the noise, and a lamp that flickers: what does not move comes back to the bit, every
/// third frame, while a robot drives through the rows.
TEST(RepeatWatch, APictureWithoutNoiseInALightThatFlickersIsNoOldOne) {
  NoisyCamera camera;
  std::vector<Frame::Grey> light;
  for (int frame = 0; frame < 50; ++frame)
    EXPECT_FALSE(camera.repeats([&](Frame::Grey& grey) {
      if (frame < 3) light.push_back(grey);
      const Frame::Grey robot = grey;
      grey = light[static_cast<std::size_t>(frame % 3)];
      std::copy_n(robot.begin(), 20 * NoisyCamera::width, grey.begin());
      for (int v = 0; v < 20; ++v)
        std::copy_n(NoisyCamera::row(light[static_cast<std::size_t>(frame % 3)], v) + 48, 80,
                    NoisyCamera::row(grey, v) + 48);
    }));
}

}  // namespace
}  // namespace skein::vision
