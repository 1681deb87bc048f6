#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/record/schedule.h"
#include "app/run/histogram.h"
#include "app/run/status.h"
#include "app/run/tick_record.h"
#include "app/run/timing.h"

namespace skein::app {

/// Whether a row is of the run itself: not of the time before its start, nor of that after its end, when robots may
/// drive back and hands may move them.
constexpr bool counts(Phase phase) noexcept {
  return phase == Phase::running || phase == Phase::paused || phase == Phase::stopped;
}

/// Settling times: how long after a perturbation errors stay inside a band (until the next perturbation or the end).
/// Empty: they did not settle; 0: they never left it.
struct Settling {
  std::optional<double> formation_1cm, formation_5mm;  ///< largest |delta_ij| [s]
  /// Largest distance of a robot from its place in the formation (the reference BEFORE avoidance: an avoiding robot is
  /// always close to its modified reference) [s]
  std::optional<double> tracking_1cm, tracking_5mm;
  /// Largest vector error of a neighbour's relative position, |(p_i - p_j) - (r_i - r_j)|. delta of (37) compares
  /// distances only, and is of second order in errors across the line between the two. [s]
  std::optional<double> relative_1cm{}, relative_5mm{};
  /// Largest distance of a robot from its place by the formation's own clock; these times are on that clock, too. For a
  /// formation that waits: when it was whole again. Tracking then shows how much remains to catch up. [s]
  std::optional<double> whole_1cm{}, whole_5mm{};
  std::optional<double> whole_5mm_after{};  ///< the same on the experiment's clock [s]
};

struct PerturbationResult {
  double t = 0.0;
  int robot = -1;
  std::string what;  ///< as in the log
  Settling settling;
  /// How far a robot that was not moved left its place because of those that were moved: the largest of all, until the
  /// next perturbation. [m]
  double others_away = 0.0;
  /// The paper's claim, at 1 cm: the formation settled, and before tracking did.
  bool formation_first() const noexcept;
  /// The same for the neighbours' relative positions.
  bool relative_first() const noexcept;
};

/// The summary of a run, computed row by row, in memory that does not grow with its length (except for its first 10,000
/// events and perturbations). Perturbations and moves less than 0.2 s apart count as one, from the last of them on: a
/// robot that is carried by hand is disturbed once.
class Statistics final : public RecordSink {
 public:
  explicit Statistics(const Experiment& experiment);
  void record(const TickRecord& record) override;

  struct Summary {
    std::string name;
    std::int64_t ticks = 0;
    double duration = 0.0;                ///< duration of the experiment so far [s]
    double final_error = none;            ///< largest distance from the places in the formation, last tick [m]
    double final_formation_error = none;  ///< [m]
    double arrived = none;       ///< since when all references rest and every robot is within 1 cm of its place [s]
    double min_distance = none;  ///< [m]
    double obstacle_gap = none;  ///< smallest between a robot's edge and an obstacle's; none without any [m]
    /// The largest lag of the formation's clock, and that at the end; empty if the formation does not wait. [s]
    std::optional<double> largest_lag, final_lag;
    double outside = 0.0;  ///< largest distance of a robot's body over the edge of the arena [m]
    std::int64_t collisions =
        0;  ///< times that a pair came closer than 70 mm, or a robot touched an obstacle of the file or the operator
    /// Times that a simulated robot that ignores commands ran into one that did not drive towards it: not a collision.
    /// Empty: there is no such robot.
    std::optional<std::int64_t> run_into;
    std::int64_t missed_deadlines = 0;
    std::int64_t dropped_rows = 0;  ///< dropped because the recorder was too slow: they are in no file and in no figure
    std::int64_t camera_outages = 0;  ///< times that a real camera stopped delivering
    std::int64_t camera_damaged = 0;  ///< frames of it that could not be used
    struct Published {
      std::int64_t sent = 0, dropped = 0;  ///< rows
    };
    std::optional<Published> published;  ///< with `skein run --publish`
    std::string kept;                    ///< the folder of a kept run
    std::int64_t video_frames = 0;       ///< recorded in the film of the run, if there is one
    std::int64_t video_dropped = 0;
    std::string video_problem;                             ///< why the film ends early
    double largest_period = none;                          ///< [s]
    double median_compute = none, largest_compute = none;  ///< wall-clock runs only [s]
    /// From a pose to the moment at which its command acts, the median; and the delay margin of the law without
    /// prediction: see core/control/delay_margin.h [s]
    double loop_delay = none, delay_margin = none;
    std::array<Histogram, stages> latency;           ///< of each stage; empty on the virtual clock
    Histogram latency_total;                         ///< a frame's arrival to its command written
    std::optional<Timing> timing;                    ///< wall-clock runs only
    bool stopped = false;                            ///< by the operator or a failure
    std::string failure;                             ///< why it was stopped, if a camera or a robot failed
    std::vector<std::pair<int, RobotStatus>> links;  ///< of the robots with a link, from 0, at the end
    std::vector<int> not_stopped;                    ///< robots that did not acknowledge their stop at the end, from 0
    std::vector<PerturbationResult> perturbations;   ///< of the file and of the operator's moves
    std::vector<std::pair<double, std::string>> events;  ///< all, with their t
  };
  Summary summary() const;

  /// When the newest of the summary's perturbations began, and their number; cheap. [s]
  double newest_perturbation() const noexcept { return disturbances_.empty() ? none : disturbances_.back().t; }
  std::size_t perturbations() const noexcept { return disturbances_.size(); }

 private:
  struct Sample {
    double t, formation, tracking, relative;
    double clock, whole;  // the formation's [s], and the distance from its places by that clock [m]
  };
  /// Since when an error has been inside a band continuously; empty: it is outside.
  struct Bands {
    std::optional<double> formation_1cm, formation_5mm, tracking_1cm, tracking_5mm, relative_1cm, relative_5mm;
    std::optional<double> whole_1cm, whole_5mm;  // on the formation's clock
    std::optional<double> whole_5mm_after;
    void add(const Sample& sample);
    Settling since(double begin, double clock) const;
  };
  /// The exact median of up to 20,000 durations; to 4.4 % for more.
  struct Durations {
    std::vector<double> exact;
    Histogram all;
    void add(double seconds);
    double median() const;
  };
  /// A perturbation by hand: a window for settling begins here.
  struct Disturbance {
    double t, clock;
    int robot;
    std::string what;
    std::vector<bool> moved{};  ///< by robot
    Settling settling{};        ///< once the next one has begun
    double others_away = 0.0;   ///< [m]
  };
  void count_collisions(const TickRecord& record);
  void note_events(const TickRecord& record);
  void disturb(double t, double clock, const Event& event);
  void watch_others(const TickRecord& record);

  const Experiment experiment_;
  const Schedule schedule_;
  std::vector<core::Obstacle> obstacles_;  // the present ones, including the operator's, by their numbers
  Summary so_far_;
  std::vector<Disturbance> disturbances_;
  Bands bands_;   // since the newest disturbance
  Bands before_;  // since the one before it, up to now: it ends where the newest ends, which may still be moving
  Durations compute_times_, loop_delays_;
  std::vector<double> drove_;   // commanded speed of each in the tick before [m/s]
  std::vector<bool> touching_;  // pairs closer than 70 mm at the last tick, then robots with obstacles
};

/// The failed conditions of the file's [expect], each as a sentence that says by how much. Empty: all held.
std::vector<std::string> failed_expectations(const Expectations& expect, const Statistics::Summary& summary);

/// The summary as `key: value` lines, and as one JSON object (the text of summary.json).
std::string as_lines(const Statistics::Summary& summary);
std::string as_json(const Statistics::Summary& summary);

}  // namespace skein::app
