// Tags that all look too large or too small, through the tracker.
#include "vision/diagnosis/scale_watch.h"

#include <gmock/gmock.h>

#include "tests/vision/support.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tracker/tracker.h"

namespace skein::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Robots that drive circles under a camera, seen by a tracker whose calibration may say something else.
struct DrivingTags {
  int robots = 4;
  Calibration truth = overhead_calibration(2.0, 1.5), believed = truth;
  std::uint64_t seed = 5;
  double raise = 0.0;  // of the camera, after 2 s [m]
  double lift = 0.0;   // of the first robot, after 2 s [m]
  double rise = 0.0;   // and how fast it goes on [m/s]
  int lifts = 1;       // so many of them are
  double light = 1.0;  // after 2 s, of what it was
  bool moved = false;  // ScaleWatch::moved, at any time

  /// All that is told in `seconds` at 25 frames/s; `last` is the last stretch.
  std::vector<std::string> told(double seconds) {
    SyntheticCamera camera(truth, {}, seed);
    TagTracker tracker(believed, {.tags = {1, 2, 3, 4}});
    ScaleWatch watch(believed);
    Frame frame;
    std::vector<std::string> all;
    for (int k = 0; k < static_cast<int>(seconds * 25.0); ++k) {
      if (k == 50 && raise != 0.0) {
        CameraPose higher = *truth.world_from_camera;
        higher.position.z() += raise;
        camera.hang(higher);
      }
      const double t = k / 25.0, turned = 0.4 * t + static_cast<double>(seed);
      std::vector<SyntheticTag> tags;
      for (int i = 0; i < robots; ++i) {
        const double x = i % 2 == 0 ? -0.45 : 0.45, y = i < 2 ? -0.3 : 0.3;
        tags.push_back({.tag = i + 1,
                        .pose = {x + 0.2 * std::cos(turned + i), y + 0.2 * std::sin(turned + i), turned + i + 1.57},
                        .size = truth.tag_size,
                        .lifted = i < lifts && k >= 50 ? lift + rise * (t - 2.0) : 0.0});
      }
      camera.render(tags, {}, t, frame);
      if (k >= 50 && light != 1.0)
        for (std::uint8_t& grey : frame.grey) grey = static_cast<std::uint8_t>(std::min(255.0, light * grey));
      tracker.process(frame);
      last = tracker.stretch();
      if (std::string sentence = watch.update(t, last); !sentence.empty()) all.push_back(std::move(sentence));
      if (std::string sentence = watch.update_change(t, tracker.scale_change()); !sentence.empty())
        all.push_back(std::move(sentence));
      moved = moved || watch.moved();
    }
    return all;
  }
  std::optional<double> last;
};

TEST(ScaleWatch, SaysNothingOfTagsThatAreAsTheCalibrationHasThem) {
  DrivingTags tags;
  for (tags.seed = 1; tags.seed <= 4; ++tags.seed) {
    EXPECT_THAT(tags.told(4.0), IsEmpty());
    ASSERT_TRUE(tags.last);
    EXPECT_LT(std::abs(*tags.last), 0.3 * ScaleWatch::tolerance) << "seed " << tags.seed;
  }
}

TEST(ScaleWatch, NamesTheHeightThatWouldFit) {
  for (const double wrong : {-0.03, 0.03}) {
    DrivingTags tags;
    tags.truth.tag_height = 0.05;
    tags.believed.tag_height = 0.05 + wrong;
    const std::vector<std::string> told = tags.told(5.0);
    ASSERT_EQ(told.size(), 1U) << "once";
    EXPECT_THAT(told.front(), HasSubstr(wrong < 0.0 ? "% larger" : "% smaller"));
    const std::string heights = "A height of about ";
    const double height = std::stod(told.front().substr(told.front().find(heights) + heights.size()));
    EXPECT_NEAR(height, 50.0, 10.0) << told.front();
  }
}

TEST(ScaleWatch, NamesTheSizeThatWouldFit) {
  DrivingTags tags;
  tags.believed.tag_size = 0.0400;
  tags.truth.tag_size = 0.0408;  // a printer's "fit to page"
  const std::vector<std::string> told = tags.told(5.0);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told.front(), HasSubstr("% larger than [tags] size 40.0 mm"));
  EXPECT_THAT(told.front(), HasSubstr("size of 40.8 mm would fit"));
}

TEST(ScaleWatch, TellsWhenAllTagsBecomeSmallerOrLargerAtOnce) {
  for (const double part : {0.01, -0.01}) {
    DrivingTags tags;
    tags.raise = part * (tags.truth.world_from_camera->position.z() - tags.truth.tag_height);
    const std::vector<std::string> told = tags.told(5.0);
    ASSERT_EQ(told.size(), 1U);
    const std::string all = "all 4 tags look ";
    ASSERT_THAT(told.front(), HasSubstr(all));
    EXPECT_NEAR(std::stod(told.front().substr(all.size())), 1.0, 0.15) << told.front();
    EXPECT_THAT(told.front(), HasSubstr(part > 0.0 ? "% smaller than a few seconds" : "% larger than a few seconds"));
    EXPECT_FALSE(tags.moved) << "poses are still taken";
  }
}

TEST(ScaleWatch, ACameraThatIsRaisedHasMoved) {
  for (const double raise : {0.05, -0.05}) {
    DrivingTags tags;
    tags.raise = raise;
    EXPECT_THAT(tags.told(5.0), IsEmpty()) << "the part that stops the robots says so";
    EXPECT_TRUE(tags.moved);
  }
}

TEST(ScaleWatch, ARobotThatIsLiftedIsNoCameraThatMoved) {
  DrivingTags tags;
  tags.lift = 0.05;
  EXPECT_THAT(tags.told(5.0), IsEmpty());
  EXPECT_FALSE(tags.moved);
}

TEST(ScaleWatch, ACameraThatIsRaisedHasMovedAlsoForTwoTags) {
  for (const double raise : {0.05, -0.05}) {
    DrivingTags tags;
    tags.robots = 2;
    tags.raise = raise;
    EXPECT_THAT(tags.told(4.0), ElementsAre(HasSubstr("all 2 tags look"))) << "before it is known that it lasts";
    EXPECT_TRUE(tags.moved);
  }
}

TEST(ScaleWatch, TwoRobotsThatTwoHandsLiftAreNoCameraThatMoved) {
  DrivingTags tags;
  tags.robots = 2;
  tags.lifts = 2;
  tags.lift = 0.035;
  tags.rise = 0.015;
  EXPECT_THAT(tags.told(6.0), ElementsAre(HasSubstr("unless the robots themselves were lifted")));
  EXPECT_FALSE(tags.moved);
}

TEST(ScaleWatch, TagsThatDoNotAgreeAreNoChangeOfTheCamera) {
  DrivingTags tags;
  tags.lifts = 3;
  tags.lift = 0.05;
  EXPECT_THAT(tags.told(5.0), IsEmpty()) << "three robots are lifted, and one is not";
  EXPECT_FALSE(tags.moved);
}

/// Paper that is brighter than the camera can show makes all tags look smaller.
TEST(ScaleWatch, LightThatIsTooBrightIsNoCameraThatMoved) {
  DrivingTags tags;
  tags.light = 3.0;
  EXPECT_THAT(tags.told(5.0), IsEmpty());
  EXPECT_FALSE(tags.moved);
}

TEST(ScaleWatch, SpeaksAgainOnlyAfterAllWasWell) {
  ScaleWatch watch(overhead_calibration(2.0, 1.5));
  EXPECT_THAT(watch.update(0.0, 0.03), IsEmpty());
  EXPECT_THAT(watch.update(1.9, 0.03), IsEmpty()) << "not of a moment";
  EXPECT_FALSE(watch.update(2.0, 0.03).empty());
  EXPECT_THAT(watch.update(9.0, 0.03), IsEmpty());
  EXPECT_THAT(watch.update(10.0, 0.001), IsEmpty());
  EXPECT_THAT(watch.update(11.0, -0.03), IsEmpty());
  EXPECT_THAT(watch.update(12.0, {}), IsEmpty());
  EXPECT_FALSE(watch.update(13.0, -0.03).empty());
}

}  // namespace
}  // namespace skein::vision
