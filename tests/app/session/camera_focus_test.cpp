// A lens that loses its focus, in whole runs.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/rows.h"

namespace skein::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The paper's platoon in rendered pictures.
struct FocusRun {
  explicit FocusRun(std::vector<std::string> sets) {
    for (const char* set : {"camera.source=synthetic", "duration=12", "perturb=[]", "expect={}"})
      sets.emplace_back(set);
    auto session = Session::open(good(paper_experiment().source, sets), Session::Clock::virtual_, {false, {&sink}});
    EXPECT_TRUE(session) << session.error();
    const auto listen = [&] {
      for (std::string& sentence : (*session)->alarms())
        if (sentence.find("focus") != std::string::npos) told.push_back(std::move(sentence));
      return true;
    };
    end = (*session)->run(listen);
    listen();
    (*session)->close();
  }
  test::Rows sink;
  Phase end = Phase::ready;
  std::vector<std::string> told;
};

TEST(CameraFocus, ThatDriftsIsToldAndTheRunGoesOn) {
  const FocusRun run({"camera.defocus_at=1", "camera.defocus=1.6", "camera.defocus_time=8"});
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("the focus has drifted")));
  for (const RobotRecord& robot : run.sink.rows.back().robots)
    EXPECT_LT(core::distance(robot.measurement.pose, robot.truth), 0.001) << "poses are right all the same";
}

TEST(CameraFocus, OfALensThatIsFixedIsNoMatter) {
  EXPECT_THAT(FocusRun({}).told, IsEmpty());
}

}  // namespace
}  // namespace skein::app
