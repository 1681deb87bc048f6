#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/tools/outcome_file.h"

namespace skein::app {

/// A share of a whole, with the limits of its 95 % interval (Wilson's score interval). NaN of an empty whole.
struct Share {
  std::int64_t part = 0, whole = 0;
  double value = 0.0, low = 0.0, high = 0.0;
};
Share share_of(std::int64_t part, std::int64_t whole);

/// A paired difference of the study's and the control's runs with the same seeds: the median difference of a run minus
/// its control, with the limits of its 95 % interval (the order statistics of the sign test: no distribution is
/// assumed), of the pairs in which both have a value.
struct PairedDifference {
  std::size_t pairs = 0;
  double median = 0.0, low = 0.0, high = 0.0;  ///< NaN of no pairs; an infinite limit: too few pairs for it
};
PairedDifference paired_difference(std::vector<double> differences);

/// The seeds of the runs that went worst, worst first: those that collided, then those that did not recover (the
/// farthest off first), then the slowest. Runs that could not be made are not included.
std::vector<std::uint64_t> worst_seeds(const std::vector<RunOutcome>& outcomes, std::size_t most);

/// Draws what a study counted into `directory`, which check_report() has made: distributions of the times (times.*), of
/// distances (distances.*), shares (shares.*), each with the control and what the study is compared with beside it, and
/// 95 % intervals, and the worst runs as floor plans (worst.*), each as .pdf, .svg and .png beside its gnuplot script
/// and data; runs.csv, summary.json and intervals.csv, the table of all intervals. Repeats the worst runs to draw them.
/// The error is a sentence.
tl::expected<void, std::string> write_sweep_report(const std::string& directory, const Study& study,
                                                   const Outcomes& outcomes);

}  // namespace skein::app
