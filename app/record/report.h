#pragma once

#include <string>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/record/figure_data.h"
#include "app/record/statistics.h"

namespace skein::app {

/// Checks before a run that a report is possible: gnuplot is installed, and `directory` exists or can be created and
/// written to.
tl::expected<void, std::string> check_report(const std::string& directory);

/// Writes the paper's figures 3 and 4, each as .pdf, .svg and .png beside its gnuplot script and data (edit the script
/// and draw again), and summary.json. The error has gnuplot's message.
tl::expected<void, std::string> write_report(const std::string& directory, const Experiment& experiment,
                                             const Statistics::Summary& summary, const FigureData& figures);

/// The same from the run's CSV `directory`/run.csv, as far as it is not torn.
tl::expected<void, std::string> write_report(const std::string& directory, const Experiment& experiment,
                                             const Statistics::Summary& summary);

}  // namespace skein::app
