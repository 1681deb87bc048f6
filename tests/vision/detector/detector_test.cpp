#include "vision/detector/detector.h"

#include <sys/resource.h>
#include <unistd.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <new>
#include <vector>

#include "tests/vision/support.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tags/tag_family.h"
#include "vision/tags/tag_pattern.h"

namespace skein::vision {
namespace {

const Calibration& camera() {
  static const Calibration calibration = overhead_calibration(2.0, 1.5);
  return calibration;
}

Frame picture(const std::vector<SyntheticTag>& tags, const SceneOptions& options = {}) {
  SyntheticCamera synthetic(camera(), options, 11);
  Frame frame;
  synthetic.render(tags, 0.0, frame);
  return frame;
}

/// Where a corner of a tag is seen: AprilTag's order, bottom-left, bottom-right, top-right, top-left of the upright
/// print.
Eigen::Vector2d corner(const SyntheticTag& tag, std::size_t i) {
  constexpr double along[4] = {-0.5, 0.5, 0.5, -0.5};
  constexpr double across[4] = {-0.5, -0.5, 0.5, 0.5};
  const double c = std::cos(tag.pose.theta) * tag.size;
  const double s = std::sin(tag.pose.theta) * tag.size;
  return *pixel_from_world(camera(), {tag.pose.x + c * along[i] - s * across[i],
                                      tag.pose.y + s * along[i] + c * across[i], camera().tag_height});
}

TEST(TagDetector, TheFamilyHasAsManyTagsAsItIsSaidToHave) {
  EXPECT_EQ(detail::tag_patterns().size(), static_cast<std::size_t>(largest_tag) + 1);
}

TEST(TagDetector, CornersAreWhereTheyWereDrawnInAprilTagsOrder) {
  std::vector<SyntheticTag> tags;
  for (int i = 0; i < 12; ++i) {
    tags.push_back({40 * i, {-0.9 + 0.16 * i, 0.7 * std::sin(2.0 * i), core::wrap_angle(0.55 * i)}});
  }
  const Frame frame = picture(tags);
  for (const double decimate : {1.0, 2.0}) {
    TagDetector detector({.decimate = decimate});
    const auto& found = detector.detect(frame);
    ASSERT_EQ(found.size(), tags.size());
    for (std::size_t t = 0; t < tags.size(); ++t) {
      EXPECT_EQ(found[t].tag, tags[t].tag) << "ordered by id";
      EXPECT_GT(found[t].decision_margin, 40.0);
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector2d seen(found[t].corners[i][0], found[t].corners[i][1]);
        EXPECT_LT((seen - corner(tags[t], i)).norm(), 0.35) << "tag " << tags[t].tag << " corner " << i;
      }
    }
  }
}

TEST(TagDetector, PixelsCountFromTheirCentres) {
  // Without noise, and over many tags, half a pixel would stand out at once.
  std::vector<SyntheticTag> tags;
  for (int i = 0; i < 40; ++i) {
    tags.push_back({i, {-0.9 + 0.25 * (i % 8), -0.6 + 0.3 * (i / 8), core::wrap_angle(0.37 * i)}});
  }
  const Frame frame = picture(tags, {.noise_sigma = 0.0, .clutter = 0});
  TagDetector detector({.decimate = 2.0});
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
  const auto& found = detector.detect(frame);
  ASSERT_EQ(found.size(), tags.size());
  for (std::size_t t = 0; t < tags.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      bias += Eigen::Vector2d(found[t].corners[i][0], found[t].corners[i][1]) - corner(tags[t], i);
    }
  }
  bias /= 4.0 * static_cast<double>(tags.size());
  EXPECT_LT(bias.norm(), 0.03) << bias.transpose();
}

TEST(TagDetector, WindowsGiveCornersOfTheFullFrame) {
  const SyntheticTag tag{7, {0.4, 0.3, 1.0}};
  const Frame frame = picture({tag, {8, {-0.4, 0.3, 1.0}}});
  TagDetector detector({.decimate = 2.0});
  const auto centre = *pixel_from_world(camera(), {0.4, 0.3, camera().tag_height});
  const int left = static_cast<int>(centre.x()) - 40;
  const int top = static_cast<int>(centre.y()) - 40;
  const auto found = detector.detect(frame, {left, top, 80, 80});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].tag, 7);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(found[0].corners[i][0], corner(tag, i).x(), 0.35);
    EXPECT_NEAR(found[0].corners[i][1], corner(tag, i).y(), 0.35);
  }
  EXPECT_EQ(detector.detect(frame, {left + 30, top, 80, 80}).size(), 0U) << "the tag is cut";
  // Over the edges, beside the frame, too small, empty.
  for (const Window window : {Window{-500, -500, 5000, 5000}, Window{0, top, 5000, 80}}) {
    EXPECT_GE(detector.detect(frame, window).size(), 1U);
  }
  for (const Window window : {Window{-90, -90, 80, 80}, Window{2000, 0, 80, 80}, Window{0, 0, 3, 3}, Window{}}) {
    EXPECT_EQ(detector.detect(frame, window).size(), 0U);
  }
}

TEST(TagDetector, TwoOfOneIdAreTwo) {
  const Frame frame = picture({{9, {0.5, 0.0, 0.2}}, {9, {-0.5, 0.0, -1.2}}});
  TagDetector detector;
  const auto& found = detector.detect(frame);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].tag, 9);
  EXPECT_EQ(found[1].tag, 9);
}

TEST(TagDetector, ThreadsChangeNothing) {
  const Frame frame = picture({{1, {0.5, 0.0, 0.2}}, {2, {-0.5, 0.1, -1.2}}, {3, {0.0, 0.6, 3.0}}});
  TagDetector one({.decimate = 2.0});
  TagDetector two({.decimate = 2.0, .threads = 2});
  const auto& a = one.detect(frame);
  const auto& b = two.detect(frame);
  ASSERT_EQ(a.size(), 3U);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t t = 0; t < a.size(); ++t) {
    EXPECT_EQ(a[t].tag, b[t].tag);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(a[t].corners[i][0], b[t].corners[i][0], 1e-3);
      EXPECT_NEAR(a[t].corners[i][1], b[t].corners[i][1], 1e-3);
    }
  }
}

TEST(TagDetector, WithoutMemoryIsAnErrorAndNotBlind) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer ends the program itself where memory is limited";
#endif
  const auto without_memory = [] {
    const rlimit nothing_more{1, 1};
    if (setrlimit(RLIMIT_AS, &nothing_more) != 0) std::_Exit(1);
    void* volatile taken = nullptr;
    do taken = std::malloc(1 << 20);
    while (taken != nullptr);  // only what is small has room now
    try {
      const TagDetector detector;
    } catch (const std::bad_alloc&) {
      std::_Exit(7);
    }
    std::_Exit(0);
  };
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // in a process that has no table yet
  EXPECT_EXIT(without_memory(), ::testing::ExitedWithCode(7), "");
}

/// A table has 19 MB.
TEST(TagDetector, AllOfAProcessShareOneTable) {
  const auto taken = [] {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  };
  const TagDetector first;
  const std::size_t before = taken();
  const std::vector<TagDetector> others(8);
  EXPECT_LT(taken(), before + (std::size_t{16} << 20));
}

/// A large picture under `ulimit -v`: AprilTag ended the program by SIGSEGV.
TEST(TagDetector, APictureForWhichThereIsNoMemoryIsAnError) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "AddressSanitizer ends the program itself where memory is limited";
#endif
  Frame noise = test::uniform_frame(2000, 1500, 128);
  for (std::size_t i = 0; i < noise.grey.size(); ++i)
    noise.grey[i] = static_cast<std::uint8_t>(i * 2654435761U >> 24);  // edges at every pixel cost most
  const auto with_memory = [&](std::size_t megabytes) {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t taken = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    TagDetector detector;
    const rlimit little{taken + (megabytes << 20), taken + (megabytes << 20)};
    if (setrlimit(RLIMIT_AS, &little) != 0) std::_Exit(1);
    try {
      static_cast<void>(detector.detect(noise));
      TagDetector again;
      static_cast<void>(detect_at_both(again, noise));
    } catch (const std::bad_alloc&) {
      std::_Exit(7);
    }
    std::_Exit(0);
  };
  for (const std::size_t megabytes : {20, 40, 60, 80})
    EXPECT_EXIT(with_memory(megabytes), ::testing::ExitedWithCode(7), "") << megabytes;
  // Between what is certainly too little and what is enough, AprilTag must not begin and then find none.
  const auto ended_by_itself = [](int status) {
    return ::testing::ExitedWithCode(7)(status) || ::testing::ExitedWithCode(0)(status);
  };
  for (const std::size_t megabytes : {120, 160, 200, 240, 280})
    EXPECT_EXIT(with_memory(megabytes), ended_by_itself, "") << megabytes;
  EXPECT_EXIT(with_memory(600), ::testing::ExitedWithCode(0), "") << "the control";
}

TEST(TagDetector, SeesNothingWhereNothingIs) {
  TagDetector detector;
  EXPECT_EQ(detector.detect(picture({})).size(), 0U) << "clutter only";
  EXPECT_EQ(detector.detect(picture({{-1, {0.0, 0.0, 0.0}}})).size(), 0U) << "blank paper";
  EXPECT_EQ(detector.detect(Frame{}).size(), 0U);
  for (const int size : {1, 15, 16, 17, 33}) {
    EXPECT_EQ(detector.detect(test::uniform_frame(size, size, 128)).size(), 0U) << size;
  }
}

}  // namespace
}  // namespace skein::vision
