#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/experiment/problem.h"

namespace skein::app {

/// Reads an experiment (TOML). `sets` are "key=value" as of --set, with dotted keys ("controller.v_max=0.08",
/// "robot.2.tag=7"). All problems are reported at once, in the order of the file.
tl::expected<Experiment, std::vector<Problem>> parse_experiment(std::string_view text, const std::string& file,
                                                                const std::vector<std::string>& sets = {});
tl::expected<Experiment, std::vector<Problem>> load_experiment(const std::string& path,
                                                               const std::vector<std::string>& sets = {});

/// The text of an experiment with everything that it takes from other files, as in Experiment::source; checks nothing
/// else.
tl::expected<std::string, std::vector<Problem>> whole_text(std::string_view text, const std::string& file);

/// The paper's experiment, built in (the text of resources/experiments/platoon.toml).
Experiment paper_experiment();

}  // namespace skein::app
