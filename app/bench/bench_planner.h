#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"

namespace skein::app {

/// A scene as resources/studies/crowds.toml draws them: so many robots anywhere, with any heading, each to any place.
tl::expected<Experiment, std::string> crowd_scene(std::int64_t robots, std::uint64_t seed,
                                                  const std::vector<std::string>& sets = {});

struct PlannerBench {
  std::int64_t runs = 8;   ///< crowds of 30, as many kicks of the platoon and obstacles on its lane
  std::uint64_t seed = 1;  ///< of the first of them; the next ones count on
};

/// The CPU time that planning costs a tick. Runs are repeated from their record five times, and the shortest time of
/// each tick counts: the work is the same to the bit, and time taken by other processes is excluded. Returns an
/// ExitStatus: expectation_failed if a tick with planning takes more than 5 ms, the p99 of those without more than 0.1
/// ms, a plan for all robots more than 1.5 s, or if a repetition plans differently from the run.
int bench_planner(const PlannerBench& bench);

}  // namespace skein::app
