#include "app/runs/run_end.h"

#include <gtest/gtest.h>

#include "app/experiment/experiment_file.h"
#include "app/run/exit_status.h"

namespace skein::app {
namespace {

/// They were counted, but nothing told the operator.
TEST(RunEnd, DamagedFramesOfTheCameraAreSaid) {
  auto experiment = parse_experiment(paper_experiment().source, "e.toml", {});
  ASSERT_TRUE(experiment);
  experiment->camera.source = "video:run.avi";
  Statistics::Summary summary;
  const auto said = [&](std::int64_t damaged, const std::string& failure) {
    summary.camera_damaged = damaged;
    summary.failure = failure;
    const RunVerdict verdict = verdict_of(summary, *experiment);
    EXPECT_EQ(verdict.exit_status == device_failed, !failure.empty());
    std::string all;
    for (const std::string& sentence : verdict.problems) all += sentence + "|";
    return all;
  };
  EXPECT_EQ(said(0, "").find("damaged"), std::string::npos) << "the control";
  EXPECT_EQ(said(1, "the stream is at its end"),
            "the stream is at its end|1 damaged frame of video:run.avi was left out, and showed no robot|");
  EXPECT_TRUE(said(139, "").starts_with("139 damaged frames of video:run.avi were left out, and showed no robot|"));
}

TEST(RunEnd, ARobotThatMayStillDriveIsAFailureOfTheDevice) {
  auto experiment = parse_experiment(paper_experiment().source, "e.toml", {});
  ASSERT_TRUE(experiment);
  experiment->expect = {};
  Statistics::Summary summary;
  EXPECT_EQ(verdict_of(summary, *experiment).exit_status, done) << "the control";
  summary.not_stopped = {1};
  const RunVerdict verdict = verdict_of(summary, *experiment);
  EXPECT_EQ(verdict.exit_status, device_failed);
  ASSERT_EQ(verdict.problems.size(), 1u);
  EXPECT_TRUE(verdict.problems[0].starts_with("robot 2 has NOT acknowledged its stop and may still be driving"));
}

}  // namespace
}  // namespace skein::app
