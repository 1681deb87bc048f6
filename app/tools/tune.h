#pragma once

#include <functional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/tools/sweep.h"
#include "app/tools/sweep_report.h"

namespace skein::app {

/// What the runs of a study say about one choice of gains: means over the runs.
struct Merits {
  /// Both objectives, smaller is better: from the kick until the relative positions of neighbours, and until tracking
  /// has settled to 1 cm for good. A run that does not settle counts with all of its time after the kick. [s]
  double formation = 0.0, tracking = 0.0;
  double limited_share = 0.0, effort = 0.0;  ///< see RunOutcome
  std::int64_t collisions = 0;
};

/// A choice of the searched numbers, and its results.
struct TunedPoint {
  std::vector<double> values;  ///< in the order of Study::Tune::search
  double delay_margin = 0.0;   ///< of the certificate [s]
  Merits searched;             ///< on the kicks of the search
  Merits held_out;             ///< on kicks that no search has seen
  /// On the held-out kicks: how much longer each kick took than with the experiment's own gains [s].
  PairedDifference formation_more, tracking_more;

  /// On kicks that no search has seen: both means are smaller than those of `own`, and so are the medians of the paired
  /// differences, with 95 % confidence.
  bool better_in_both(const TunedPoint& own) const noexcept;
};

struct Tuned {
  TunedPoint own;  ///< the experiment's gains as the file has them
  /// The Pareto front of all that was tried: certified, within the constraints, and no other such point (nor `own`) is
  /// at least as good in both objectives on the kicks of the search, and better in one. The fastest formation first.
  std::vector<TunedPoint> front;
  std::vector<TunedPoint> tried;  ///< certified and within the constraints
  /// Of the front, that with the smallest worse ratio to `own` on the kicks of the search: the held-out kicks play no
  /// part in the choice. Empty front: none.
  std::size_t chosen = 0;
  std::int64_t runs = 0, candidates = 0;
  std::int64_t uncertified = 0;   ///< candidates that `skein check` would refuse, or with too small a delay margin
  std::string first_uncertified;  ///< the first of them, and why; empty: there is none
  std::int64_t unaffordable = 0;  ///< those that took more of the actuators than is allowed, or collided
};

/// Searches for gains: `objectives` searches of NLopt's controlled random search (CRS2 with local mutation, Kaelo and
/// Ali 2006; it compares costs only, so that it needs neither derivatives nor smooth costs), each with `candidates`
/// evaluations of `runs` kicks. The first two look for the fastest formation and the fastest tracking; the others
/// minimise Chebyshev's distance from both optima with weights that divide the front evenly (Miettinen 1999, 3.4).
/// Every candidate is certified before it runs (certificate.h), as the file has it and as the study runs it. The same
/// study gives the same result, whatever the number of threads.
///
/// `progress` is called with the number of runs made, on the calling thread, and returns false to end the search: then
/// the error says so. Otherwise the error names what cannot be searched in the study.
tl::expected<Tuned, std::string> tune(const Study& study, unsigned threads,
                                      const std::function<bool(std::int64_t)>& progress);

/// The runs that tune() makes at most.
std::int64_t most_runs(const Study& study);

/// "key=value" of every searched key, as for --set.
std::vector<std::string> sets_of(const Study::Tune& tune, const TunedPoint& point);

/// The text of the study's experiment file with the values of a point, otherwise as it was written. For a file in
/// another folder it has what it takes from files beside the experiment's: there, their names would lead nowhere.
tl::expected<std::string, std::string> experiment_with(const Study& study, const TunedPoint& point,
                                                       const std::string& file);

/// The control and the front as a table for people, and as CSV: doubles as the shortest text that reads back to the
/// same bits.
std::string as_table(const Study& study, const Tuned& tuned);
std::string as_csv(const Study& study, const Tuned& tuned);

/// One sentence: which points of the front are better than the experiment's own gains, or that none is.
std::string verdict(const Tuned& tuned);

/// Draws the front (front.pdf, .svg and .png beside its gnuplot script and data) into `directory`, which check_report()
/// has made; front.csv; and each point's experiment file, point-N.toml. The error is a sentence.
tl::expected<void, std::string> write_front(const std::string& directory, const Study& study, const Tuned& tuned);

}  // namespace skein::app
