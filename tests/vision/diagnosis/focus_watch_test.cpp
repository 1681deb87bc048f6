// A lens that loses its focus, through the tracker.
#include "vision/diagnosis/focus_watch.h"

#include <gmock/gmock.h>

#include "tests/vision/support.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tracker/tracker.h"

namespace skein::vision {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Four robots that drive circles under a camera whose lens blurs by blur(t) [px].
struct TagsThroughALens {
  double speed = 0.1;     // [m/s]
  double exposure = 0.0;  // [s]
  std::uint64_t seed = 5;
  int lost = 0;                  // tags that were not seen, over all frames but the first
  std::optional<double> last{};  // TagTracker::blur

  /// All that is told in `seconds` at 25 frames/s.
  template <typename Blur>
  std::vector<std::string> told(double seconds, Blur blur) {
    const Calibration calibration = overhead_calibration(2.0, 1.5);
    SyntheticCamera camera(calibration, {}, seed);
    TagTracker tracker(calibration, {.tags = {1, 2, 3, 4}});
    FocusWatch watch;
    Frame frame;
    double blurs = SceneOptions{}.blur_px;
    std::vector<std::string> all;
    for (int k = 0; k < static_cast<int>(seconds * 25.0); ++k) {
      const double t = k / 25.0, turned = 5.0 * speed * t + static_cast<double>(seed);
      std::vector<SyntheticTag> tags;
      for (int i = 0; i < 4; ++i) {
        const double x = i % 2 == 0 ? -0.45 : 0.45, y = i < 2 ? -0.3 : 0.3;
        tags.push_back({.tag = i + 1,
                        .pose = {x + 0.2 * std::cos(turned + i), y + 0.2 * std::sin(turned + i), turned + i + 1.57},
                        .size = calibration.tag_size,
                        .smear = speed * exposure});
      }
      if (blur(t) != blurs) camera.focus(blurs = blur(t));
      camera.render(tags, {}, t, frame);
      lost += k == 0 ? 0 : 4 - static_cast<int>(tracker.process(frame).size());
      if (k == 0) tracker.process(frame);
      last = tracker.blur();
      if (std::string sentence = watch.update(t, last); !sentence.empty()) all.push_back(std::move(sentence));
    }
    return all;
  }
};

TEST(FocusWatch, MeasuresTheBlurOfTheLens) {
  for (const double blur : {0.5, 0.7, 1.0, 1.3, 1.6}) {
    TagsThroughALens tags;
    tags.told(2.0, [&](double) { return blur; });
    ASSERT_TRUE(tags.last) << blur;
    EXPECT_NEAR(*tags.last, std::hypot(blur, 0.5), 0.2 * std::hypot(blur, 0.5)) << blur;
  }
}

TEST(FocusWatch, SaysNothingOfALensInFocusNorOfRobotsThatDriveFast) {
  for (const double exposure : {0.0, 0.02}) {
    TagsThroughALens tags{.speed = exposure > 0.0 ? 0.2 : 0.1, .exposure = exposure};
    for (tags.seed = 1; tags.seed <= 2; ++tags.seed) {
      EXPECT_THAT(tags.told(5.0, [](double) { return 0.7; }), IsEmpty()) << exposure << " s, seed " << tags.seed;
      EXPECT_LT(*tags.last, 1.1);
    }
  }
}

TEST(FocusWatch, TellsOnceOfAFocusThatDriftsBeforeTagsAreLost) {
  TagsThroughALens tags;
  const auto told = tags.told(15.0, [](double t) { return 0.7 + 0.06 * t; });
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told.front(), HasSubstr("the focus has drifted"));
  EXPECT_THAT(told.front(), HasSubstr("0.8 px when they were sharpest"));
  EXPECT_EQ(tags.lost, 0);
}

/// An autofocus that hunts is faster than a lens that warms up.
TEST(FocusWatch, TellsOfAFastDriftBeforeTagsAreLost) {
  TagsThroughALens tags;
  const auto told = tags.told(5.2, [](double t) { return 0.7 + 0.3 * std::max(0.0, t - 2.0); });
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told.front(), HasSubstr("the focus has drifted"));
  EXPECT_EQ(tags.lost, 0);
}

TEST(FocusWatch, TellsOfALensThatNeverWasInFocus) {
  TagsThroughALens tags;
  const auto told = tags.told(5.0, [](double) { return 1.75; });
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told.front(), HasSubstr("not in focus"));
}

TEST(FocusWatch, SpeaksAgainOnlyAfterAllWasWell) {
  FocusWatch watch;
  EXPECT_THAT(watch.update(0.0, 0.9), IsEmpty());
  EXPECT_THAT(watch.update(1.0, 1.5), IsEmpty());
  EXPECT_THAT(watch.update(1.5, 1.5), IsEmpty()) << "not of a moment";
  EXPECT_FALSE(watch.update(1.6, 1.5).empty());
  EXPECT_THAT(watch.update(9.0, 1.6), IsEmpty());
  EXPECT_THAT(watch.update(10.0, 0.9), IsEmpty());
  EXPECT_THAT(watch.update(11.0, 1.5), IsEmpty());
  EXPECT_THAT(watch.update(12.0, {}), IsEmpty());
  EXPECT_FALSE(watch.update(13.0, 1.5).empty());
}

}  // namespace
}  // namespace skein::vision
