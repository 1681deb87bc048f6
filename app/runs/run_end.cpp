#include "app/runs/run_end.h"

#include <fmt/format.h>

#include <iterator>

#include "app/experiment/certificate.h"
#include "app/run/exit_status.h"

namespace skein::app {

SessionFacts facts_of(const Session& session, Phase end) {
  const auto camera = session.camera();
  return {end,
          session.timing_so_far(),
          session.failure().value_or(""),
          camera.outages,
          camera.damaged,
          session.video(),
          session.dropped_rows(),
          session.robots()};
}

void complete(Statistics::Summary& summary, const SessionFacts& facts, const Experiment& experiment) {
  summary.stopped = facts.end != Phase::finished;
  if (experiment.controller.law.of_the_paper()) summary.delay_margin = smallest_delay_margin(experiment).margin.delay;
  summary.timing = facts.timing;
  summary.failure = facts.failure;
  summary.camera_outages = facts.camera_outages;
  summary.camera_damaged = facts.camera_damaged;
  summary.video_frames = facts.video.frames;
  summary.video_dropped = facts.video.dropped;
  summary.video_problem = facts.video.problem;
  summary.dropped_rows = static_cast<std::int64_t>(facts.dropped_rows);
  for (std::size_t i = 0; i < facts.robots.size(); ++i) {
    if (experiment.robots[i].has_link()) summary.links.emplace_back(static_cast<int>(i), facts.robots[i]);
    if (!facts.robots[i].stop_acknowledged) summary.not_stopped.push_back(static_cast<int>(i));
  }
}

RunVerdict verdict_of(const Statistics::Summary& summary, const Experiment& experiment) {
  RunVerdict verdict;
  for (const int robot : summary.not_stopped)
    verdict.problems.push_back(fmt::format(
        "robot {} has NOT acknowledged its stop and may still be driving: switch it off by hand", robot + 1));
  if (!summary.failure.empty()) verdict.problems.push_back(summary.failure);
  if (summary.dropped_rows > 0)
    verdict.problems.push_back(
        fmt::format("{} rows are missing from the record: writing it was too slow", summary.dropped_rows));
  if (summary.camera_damaged > 0)
    verdict.problems.push_back(fmt::format("{} damaged frame{} of {} {} left out, and showed no robot",
                                           summary.camera_damaged, summary.camera_damaged == 1 ? "" : "s",
                                           experiment.cameras() > 1 ? "the cameras" : experiment.camera.source,
                                           summary.camera_damaged == 1 ? "was" : "were"));
  if (!summary.video_problem.empty())
    verdict.problems.push_back("the film of the run is not complete: " + summary.video_problem);
  if (!summary.failure.empty() || !summary.video_problem.empty() || !summary.not_stopped.empty()) {
    verdict.exit_status = device_failed;
    return verdict;
  }
  std::vector<std::string> failed = failed_expectations(experiment.expect, summary);
  if (summary.stopped)
    failed.insert(failed.begin(), fmt::format("stopped at {:g} s of {:g} s", summary.duration, experiment.duration));
  if (!failed.empty()) verdict.exit_status = expectation_failed;
  verdict.problems.insert(verdict.problems.end(), std::make_move_iterator(failed.begin()),
                          std::make_move_iterator(failed.end()));
  return verdict;
}

}  // namespace skein::app
