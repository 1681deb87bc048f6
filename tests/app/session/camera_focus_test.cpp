// A lens that loses its focus, in whole runs.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "tests/app/session/rendered_platoon.h"

namespace skein::app {
namespace {

using test::RenderedPlatoon;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Of what the operator is told, what is about the focus.
std::vector<std::string> told_of_focus(const RenderedPlatoon& run) {
  std::vector<std::string> told;
  for (const std::string& sentence : run.told)
    if (sentence.find("focus") != std::string::npos) told.push_back(sentence);
  return told;
}

TEST(CameraFocus, ThatDriftsIsToldAndTheRunGoesOn) {
  const RenderedPlatoon run(12.0, {"camera.defocus_at=1", "camera.defocus=1.6", "camera.defocus_time=8"});
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_THAT(told_of_focus(run), ElementsAre(HasSubstr("the focus has drifted")));
  for (const RobotRecord& robot : run.sink.rows.back().robots)
    EXPECT_LT(core::distance(robot.measurement.pose, robot.truth), 0.001) << "poses are right all the same";
}

TEST(CameraFocus, OfALensThatIsFixedIsNoMatter) {
  EXPECT_THAT(told_of_focus(RenderedPlatoon(12.0)), IsEmpty());
}

}  // namespace
}  // namespace skein::app
