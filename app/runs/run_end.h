#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/record/statistics.h"
#include "app/run/status.h"
#include "app/run/timing.h"
#include "app/session/session.h"

namespace skein::app {

/// Facts about a run that the session has and no row contains.
struct SessionFacts {
  Phase end = Phase::ready;
  std::optional<Timing> timing;
  std::string failure;
  std::int64_t camera_outages = 0;  ///< times that it stopped delivering
  std::int64_t camera_damaged = 0;  ///< frames of it that could not be used
  VideoStatus video;
  std::uint64_t dropped_rows = 0;
  std::vector<RobotStatus> robots;
};
/// `end`: the phase that the run ended in. Complete when the session is closed.
SessionFacts facts_of(const Session& session, Phase end);

/// Adds them to the summary of the rows.
void complete(Statistics::Summary& summary, const SessionFacts& facts, const Experiment& experiment);

/// How a run went, by its completed summary.
struct RunVerdict {
  int exit_status = 0;                ///< of `skein run`
  std::vector<std::string> problems;  ///< a sentence each: errors, then the failed conditions of [expect]
};
RunVerdict verdict_of(const Statistics::Summary& summary, const Experiment& experiment);

}  // namespace skein::app
