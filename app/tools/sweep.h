#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/tools/study.h"

namespace skein::app {

/// One run of a study.
struct RunOutcome {
  std::uint64_t seed = 0;
  std::int64_t robots = 0;
  double perturbation = 0.0;  ///< the largest distance by which a perturbation moved a robot [m]
  std::int64_t collisions = 0;
  std::int64_t run_into = 0;       ///< by robots that ignore commands, while standing or driving away
  double min_distance = 0.0;       ///< between two robots, true poses [m]
  double obstacle_gap = 0.0;       ///< between a robot's edge and an obstacle's; NaN without obstacles [m]
  double final_error = 0.0;        ///< largest true distance from a place within the last second [m]
  std::optional<double> recovery;  ///< until every robot was within `recovered_within` for good, from the (first)
                                   ///< perturbation, or the start; empty: never [s]
  /// Of robots that come to rest: what the longest straight line from a start to a place takes at v_max; empty: they
  /// drive on. [s]
  std::optional<double> straight;
  /// The same along the shortest paths round the experiment's obstacles (ShortestPaths); empty also where one has none.
  std::optional<double> shortest;
  std::optional<bool> formation_first;  ///< where a perturbation was large enough to ask
  std::optional<bool> relative_first;   ///< the same of the neighbours' relative positions
  double outside = 0.0;                 ///< largest distance by which a body was over the arena's edge [m]
  /// Until all perturbations had settled to 1 cm, the slowest of them: formation, relative positions, tracking; see
  /// Settling. Empty: one did not, or there was none. [s]
  std::optional<double> formation_settled, relative_settled, tracking_settled;
  /// Of a formation that waits: until it was whole again to 5 mm, on its own clock and on the experiment's, and the
  /// most that its own was behind; empty also where it never was. [s]
  std::optional<double> whole, whole_after, lag;
  double limited_share = 0.0;  ///< of robots and ticks in which a limit took something from the law's command
  double effort = 0.0;         ///< root mean square of the wheels' commanded acceleration [m/s^2]
  std::int64_t v_jumps = 0;    ///< changes of a robot's v by more than 0.03 m/s from a tick to the next
  std::int64_t reversals = 0;  ///< times that a robot went over from forwards to backwards or back
  std::int64_t absent = 0;     ///< robots that are not within `recovered_within` of their places at the end
  /// Of these: how many cannot be at their places, because a robot that ignores commands is nearer to the place than
  /// the shield allows (without the shield: than the bodies allow).
  std::int64_t places_taken = 0;
  std::string failure;  ///< why the run failed, if it did

  bool collided() const noexcept { return collisions > 0; }
  /// It did not recover, and only robots are missing that cannot be at their places.
  bool shut_out() const noexcept { return !recovery && absent > 0 && absent == places_taken; }
};

/// The experiment of one run of a study, or of its control; the error says why there is none.
tl::expected<Experiment, std::string> experiment_of(const Study& study, std::uint64_t seed, bool control = false);

/// The study under the condition of its [compare] that has this name.
Study compared_study(const Study& study, const std::string& name);

/// One run of a study, or of its control, on the virtual clock.
RunOutcome run_one(const Study& study, std::uint64_t seed, bool control = false);

/// One of `of` parts of a study, from 1: every of-th run, so that parts take about the same time.
struct Part {
  std::int64_t index = 1, of = 1;
};

/// The runs of a study, or of a part of it, over `threads` threads; `progress` is called now and then, on the calling
/// thread, with the number of runs done, and returns false to end the sweep. Outcomes in the order of their seeds;
/// those of runs that were not made are left out.
std::vector<RunOutcome> sweep(const Study& study, unsigned threads, const std::function<bool(std::size_t)>& progress,
                              bool control = false, Part part = {});

/// The smallest value that at least this share of all values do not exceed; NaN if there are no values.
double quantile(std::vector<double> values, double share);

/// The results of all runs, as `key: value` lines and as one JSON object.
struct SweepSummary {
  std::string name, experiment;
  std::int64_t runs = 0, failed_runs = 0;
  std::int64_t collisions = 0, runs_with_collisions = 0, run_into = 0;
  double min_distance = 0.0;
  std::uint64_t min_distance_seed = 0;
  double obstacle_gap = 0.0;                     ///< NaN without obstacles
  std::int64_t recovered = 0, places_taken = 0;  ///< runs; places_taken: that could not (RunOutcome::shut_out)
  double recovery_p50 = 0.0, recovery_p90 = 0.0, recovery_p99 = 0.0, recovery_max = 0.0;  ///< of those that did [s]
  /// Of runs in which all came to rest: their times as multiples of `straight`; NaN where none did.
  double over_straight_p50 = 0.0, over_straight_p99 = 0.0, over_straight_max = 0.0;
  double over_shortest_p50 = 0.0, over_shortest_p99 = 0.0, over_shortest_max = 0.0;  ///< the same of `shortest`
  double final_error_p50 = 0.0, final_error_p99 = 0.0, final_error_max = 0.0;        ///< [m]
  std::int64_t formation_first = 0, formation_first_asked = 0, relative_first = 0;
  /// Of formations that wait: on their own clocks, and on the experiment's; NaN where none does. [s]
  double whole_p50 = 0.0, whole_p99 = 0.0, whole_max = 0.0;
  double whole_after_p50 = 0.0, whole_after_p99 = 0.0, whole_after_max = 0.0, lag_p50 = 0.0, lag_max = 0.0;
  double outside = 0.0;                  ///< farthest of all runs [m]
  std::int64_t runs_outside = 0;         ///< in which a body was over the arena's edge
  std::vector<std::uint64_t> bad_seeds;  ///< of runs that collided, did not recover or failed

  std::int64_t v_jumps_max = 0, reversals_max = 0;    ///< of one run
  std::int64_t with_v_jumps = 0, with_reversals = 0;  ///< runs with a jump of v, with more than one reversal

  double recovered_share() const noexcept;
  double v_jumps_share() const noexcept;
  double reversals_share() const noexcept;
  double formation_first_share() const noexcept;
  double relative_first_share() const noexcept;
  std::vector<SweepSummary> control;  ///< of the same seeds, where the study has one
  std::int64_t robots = 0;            ///< of all runs; 0 where runs differ
  /// Of the runs with each number of robots, in their order; empty where all runs have the same.
  std::vector<SweepSummary> by_robots;
};
SweepSummary summarise(const Study& study, const std::vector<RunOutcome>& outcomes,
                       const std::vector<RunOutcome>& control = {});
std::string as_lines(const SweepSummary& summary);
std::string as_json(const SweepSummary& summary,
                    const std::vector<std::pair<std::string, SweepSummary>>& compared = {});

/// The same runs under several conditions beside one another, as a table: a name and a summary a row.
std::string as_table(const std::vector<std::pair<std::string, SweepSummary>>& rows);

/// The runs with each number of robots (`by_robots`), as a table; empty where there are none.
std::string as_table_by_robots(const SweepSummary& summary);

/// Which of the study's [expect] failed, each as a sentence.
std::vector<std::string> failed_expectations(const Study::Expect& expect, const SweepSummary& summary);

}  // namespace skein::app
