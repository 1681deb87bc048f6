#include "app/experiment/ways.h"

#include <fmt/format.h>

#include <cmath>

#include "app/run/number_text.h"
#include "core/planning/route_search.h"

namespace skein::app {

std::vector<std::string> missing_ways(const Experiment& experiment) {
  std::vector<std::string> sentences;
  const auto reference = make_reference(experiment);
  const std::vector<double> beyond = sizes_beyond(experiment);
  constexpr double rounding = 5e-4;  // [m], as planned routes have it
  constexpr double arrived = 0.01;   // so near to its place, as the summary of a run has it [m]
  const core::Traffic nobody(1);
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    constexpr double after = 1e4;  // whatever comes to rest does so by then [s]
    const core::ReferencePoint last = reference->at(i, experiment.duration + after);
    if (last.twist != core::Twist{} || reference->at(i, experiment.duration + 2.0 * after).pose != last.pose) continue;
    core::RouteSearch::Query query;
    query.from = experiment.robots[i].start.value_or(reference->at(i, 0.0).pose);
    query.to = last.pose;
    core::Lattice lattice({0.5 * experiment.arena_width, 0.5 * experiment.arena_height},
                          experiment.shield.distance + beyond[i] - core::standard_radius + rounding,
                          experiment.obstacles.size());
    lattice.build(experiment.obstacles);
    core::RouteSearch search(lattice, 1);
    search.begin(query, nobody);
    while (search.searching()) search.advance(1000);
    // A place nearer to an obstacle than the shield lets anybody is none: routes would end beside it.
    const core::Lattice::Place inside = lattice.inside(last.pose.x, last.pose.y);
    const bool reached = search.found() && std::hypot(inside.x - last.pose.x, inside.y - last.pose.y) <= arrived;
    if (!reached)
      sentences.push_back(
          fmt::format("no way for {} from ({}, {}) to ({}, {}) m: obstacles and the arena's edge are closer than "
                      "the shield lets it go",
                      robot_name(experiment, i), significant(query.from.x, 3), significant(query.from.y, 3),
                      significant(query.to.x, 3), significant(query.to.y, 3)));
  }
  return sentences;
}

}  // namespace skein::app
