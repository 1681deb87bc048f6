// What the window's tab Floor is told of tags on the floor that a camera does not see.
#include "app/tools/floor_survey.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "app/calibration/calibration_file.h"
#include "tests/app/folder.h"
#include "tests/pgm.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

/// Five tags are asked for, at the corners and in the middle of the floor.
class FloorSurveyErrors : public ::testing::Test {
 protected:
  FloorSurveyErrors() {
    vision::Calibration lens = camera;
    lens.world_from_camera.reset();
    EXPECT_TRUE(save_calibration(lens, folder / "cal.toml"));
    question = {.source = "images:" + (folder / "pictures"), .calibration = folder / "cal.toml", .tags = {}};
    for (const auto& [x, y] : {std::pair{-0.9, 0.6}, {0.9, 0.6}, {0.9, -0.6}, {-0.9, -0.6}, {0.1, 0.1}})
      question.tags.push_back({.id = 20 + static_cast<int>(question.tags.size()), .x = x, .y = y});
  }
  /// The first so many of them lie there.
  vision::Frame picture(std::size_t count) {
    std::vector<vision::SyntheticTag> tags;
    for (std::size_t k = 0; k < count; ++k) {
      const FloorTag& tag = question.tags[k];
      tags.push_back(
          {.tag = tag.id, .pose = {tag.x, tag.y, 0.3}, .size = 0.06, .lifted = -camera.tag_height, .bare = true});
    }
    vision::Frame frame;
    vision::SyntheticCamera(camera).render(tags, 0.0, frame);
    return frame;
  }
  std::string error_of(const vision::Frame& frame) {
    std::filesystem::create_directories(folder / "pictures");
    skein::test::write_pgm(folder / "pictures/0.pgm", frame);
    const auto survey = survey_floor(question, never);
    return survey ? "" : survey.error();
  }
  test::Folder folder;
  vision::Calibration camera = vision::overhead_calibration(2.0, 1.5);
  FloorQuestion question;
  const std::atomic<bool> never{false};
};

TEST_F(FloorSurveyErrors, NameTheTagsThatAreNotSeen) {
  EXPECT_EQ(error_of(picture(3)),
            "3 of 5 marks are seen; needed: 4 or more; marks 23, 24 are not seen: no such tag is in the picture: "
            "uncover it, or move it into the picture");
  EXPECT_EQ(error_of(picture(4)), "") << "the control";
}

TEST_F(FloorSurveyErrors, NameATagThatIsThereTwice) {
  const FloorTag other = question.tags[4];
  question.tags.push_back(question.tags[3]);
  question.tags.back().x = other.x + 0.5;
  const vision::Frame twice = picture(6);
  question.tags.pop_back();
  const std::string error = error_of(twice);
  EXPECT_THAT(error, StartsWith("tag 23 is in frame 0.pgm twice; allowed: once; mark 23 is not seen: it is there twice "
                                "at (-0.90, -0.60) m, pixel ("));
  EXPECT_THAT(error, HasSubstr(") and (0.60, -0.60) m, pixel ("));
  EXPECT_THAT(error, EndsWith("take away what does not lie at (-0.90, -0.60) m"));
}

/// Where the others are enough, the one that is missing is named all the same.
TEST_F(FloorSurveyErrors, ATagThatTheOthersDoWithoutIsNamedWithItsReason) {
  ASSERT_EQ(error_of(picture(4)), "");
  const auto survey = survey_floor(question, never);
  ASSERT_TRUE(survey) << survey.error();
  EXPECT_THAT(survey->unseen,
              ElementsAre(StartsWith("mark 24 is not seen: nothing can be read at (0.10, 0.10) m, pixel "
                                     "(")));
  ASSERT_EQ(error_of(picture(5)), "");
  EXPECT_THAT(survey_floor(question, never)->unseen, IsEmpty()) << "the control";
}

TEST_F(FloorSurveyErrors, SayWhyNoTagIsSeen) {
  vision::Frame frame = picture(5);
  for (int v = 0; v < frame.height; ++v)
    std::reverse(frame.grey.begin() + v * frame.width, frame.grey.begin() + (v + 1) * frame.width);
  const std::string error = error_of(frame);
  EXPECT_THAT(error, StartsWith("0 of 5 marks are seen; needed: 4 or more; tags 20, 21, 22, 23, 24 are mirrored"));
  EXPECT_THAT(error, EndsWith("switch the camera's mirror off"));
}

}  // namespace
}  // namespace skein::app
