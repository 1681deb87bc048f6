#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/experiment/problem.h"
#include "app/tools/passage.h"

namespace skein::app {

/// From low to high, both allowed.
using Span = std::array<double, 2>;

/// The contents of a study file: an experiment and its random changes from run to run (docs/studies.md).
struct Study {
  std::string file;  ///< the study's own path
  std::string name;
  std::string experiment;         ///< path of the experiment file
  std::vector<std::string> sets;  ///< "key=value", as --set
  std::int64_t runs = 100;
  std::uint64_t seed = 1;  ///< of the first run; each further run adds 1

  /// Any number of the experiment, anywhere in a range.
  std::vector<std::pair<std::string, Span>> vary;

  /// One to `robots` robots at once are moved: any direction, any heading.
  struct Hand {
    double t = 2.0;
    std::int64_t robots = 1;
    Span distance{0.05, 0.4};
    double clearance = 0.1;  ///< to any other midpoint, [m]; that much less standard_radius to obstacles and the border
    std::optional<Span>
        edge{};  ///< instead of a distance: this far from the body to the arena's edge, anywhere along it
  };
  std::optional<Hand> hand;

  struct Field {
    std::int64_t count = 5;
    Span radius{0.03, 0.07};
    double gap = 0.17;        ///< between two obstacles' edges at least [m]
    double clearance = 0.15;  ///< from an edge to where robots begin and end [m]
  };
  std::optional<Field> field;

  /// Robots are scattered first, and drive to their starts before the run.
  struct Scatter {
    double distance = 0.0;  ///< from the start at most [m]; 0: anywhere in the arena
    double heading = core::pi;
    double clearance = 0.1;  ///< to any other midpoint [m]
  };
  std::optional<Scatter> scatter;

  /// Replaces the experiment's robots: any start, any heading, each with a straight line to any place.
  struct Crowd {
    std::array<std::int64_t, 2> robots{4, 30};  ///< from ... to, both allowed
    double clearance = 0.12;                    ///< between two starts, and between two places [m]
    double border = 0.1;                        ///< from a start or a place to the arena's edge [m]
    std::int64_t runaways = 0;                  ///< how many of them ignore commands from a random moment on
    double wheels = 0.0;  ///< each true wheel diameter is up to this share larger or smaller than it is assumed
  };
  std::optional<Crowd> crowd;

  /// Replaces the experiment's robots and obstacles: walls with a way through.
  std::optional<Passage> passage;

  /// Gains to be searched for, by `skein tune`: see tune.h.
  struct Tune {
    /// Keys of the experiment, each with the numbers that it may have: on a logarithmic scale where low is above 0 and
    /// high at least ten times that.
    std::vector<std::pair<std::string, Span>> search;
    std::int64_t objectives = 5;    ///< searches: two for the ends of the front, the others for what is between
    std::int64_t candidates = 400;  ///< of each search, each tried with all `runs` of the study
    std::int64_t held_out = 500;    ///< kicks on which the front is measured afterwards, with the seeds that follow
    /// What a candidate must keep, the last two as means over its runs; empty: what the experiment's own gains have.
    std::optional<double> delay_margin;   ///< at least [s]
    std::optional<double> limited_share;  ///< at most: of robots and ticks in which a limit cut the law's command
    std::optional<double> effort;         ///< at most: rms of the wheels' commanded acceleration [m/s^2]
  };
  std::optional<Tune> tune;

  /// The control: the same runs again, with these keys added, beside the others in the summary.
  std::vector<std::string> control;
  /// More controls, each with a name: one row of a table each.
  std::vector<std::pair<std::string, std::vector<std::string>>> compare;

  double recovered_within = 0.005;    ///< a run recovered if in its last second no robot is farther from its place [m]
  double formation_first_over = 0.1;  ///< smaller perturbations are not judged [m]

  struct Expect {
    std::optional<std::int64_t> collisions;
    std::optional<bool> inside;                        ///< no body was over the arena's edge
    std::optional<double> recovered, formation_first;  ///< at least this share of the runs
  } expect;

  std::string text;        ///< of the experiment file
  std::string definition;  ///< the study file's own text
};

/// Reads a study (TOML) and the experiment it names; every problem of both.
tl::expected<Study, std::vector<Problem>> load_study(const std::string& path);

/// What is wrong with the study as it is about to run, after every change by the command line: `control`, each list of
/// [compare], both ends of each range of [vary], and a `hand` for which the experiment has no time or too few robots.
/// `more`: the number of further runs, with the seeds that follow.
std::vector<Problem> check_study(const Study& study, std::int64_t more = 0);

/// The changes of the run with this seed, as for --set: `skein run` with these gives the same run. The error: there is
/// no room for the random placement.
tl::expected<std::vector<std::string>, std::string> variation(const Study& study, std::uint64_t seed);

}  // namespace skein::app
