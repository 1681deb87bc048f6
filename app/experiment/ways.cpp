#include "app/experiment/ways.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <set>

#include "app/run/number_text.h"
#include "core/math/elementary.h"
#include "core/planning/route_search.h"

namespace skein::app {
namespace {

using Place = core::Lattice::Place;

constexpr double rounding = 5e-4;  // [m], as planned routes have it

double length_of(const Place& from, const Place& to) noexcept {
  return core::math::hypot(to.x - from.x, to.y - from.y);
}

double length_of(const std::vector<Place>& path) noexcept {
  double length = 0.0;
  for (std::size_t k = 1; k < path.size(); ++k) length += length_of(path[k - 1], path[k]);
  return length;
}

/// Theta* (Nash, Daniel, Koenig, Felner 2007): A* on the lattice's vertices, in which a vertex is reached straight from
/// the parent of the one before where that line is free. Empty: there is no path.
std::vector<Place> any_angle_path(const core::Lattice& lattice, const Place& from, const Place& to) {
  if (lattice.free(from, to)) return {from, to};
  const std::size_t start = lattice.size(), goal = start + 1, nowhere = goal + 1;
  const auto place = [&](std::size_t node) { return node == start ? from : node == goal ? to : lattice.place(node); };
  std::vector<double> g(nowhere, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> parent(nowhere, nowhere);
  std::vector<char> done(nowhere);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto reach = [&](std::size_t before, std::size_t node) {
    const Place there = place(node);
    if (parent[before] != nowhere && lattice.free(place(parent[before]), there)) before = parent[before];
    const double length = g[before] + length_of(place(before), there);
    if (length >= g[node]) return;
    g[node] = length;
    parent[node] = before;
    open.emplace(length + length_of(there, to), node);
  };
  g[start] = 0.0;
  open.emplace(length_of(from, to), start);
  while (!open.empty()) {
    const std::size_t node = open.top().second;
    open.pop();
    if (node == goal) break;
    if (done[node]) continue;
    done[node] = 1;
    const Place here = place(node);
    if (lattice.free(here, to)) reach(node, goal);
    if (node == start) {
      lattice.near(here.x, here.y, 2.0 * lattice.cell(), [&](std::size_t v) {
        if (lattice.free(here, lattice.place(v))) reach(node, v);
      });
      continue;
    }
    for (std::size_t d = 0; d < core::Lattice::directions; ++d)
      if (const std::size_t v = lattice.neighbour(node, d); v != lattice.size() && !done[v]) reach(node, v);
  }
  if (parent[goal] == nowhere) return {};
  std::vector<Place> path;
  for (std::size_t node = goal; node != nowhere; node = parent[node]) path.push_back(place(node));
  std::reverse(path.begin(), path.end());
  return path;
}

/// Moves every corner towards the middle between its neighbours, which makes the path shorter, as far as both lines
/// stay free.
void pull_taut(const core::Lattice& lattice, std::vector<Place>& path) {
  for (int round = 0; round < 20; ++round)
    for (std::size_t k = 1; k + 1 < path.size(); ++k) {
      const Place &before = path[k - 1], &after = path[k + 1], here = path[k];
      const Place middle{0.5 * (before.x + after.x), 0.5 * (before.y + after.y)};
      for (double share = 1.0; share > 1e-3; share *= 0.5) {
        const Place there{here.x + share * (middle.x - here.x), here.y + share * (middle.y - here.y)};
        if (!lattice.free(before, there) || !lattice.free(there, after)) continue;
        path[k] = there;
        break;
      }
    }
}

std::set<std::size_t> parts_near(core::Lattice& lattice, const Place& place) {
  std::set<std::size_t> near;
  lattice.near(place.x, place.y, 2.0 * lattice.cell(), [&](std::size_t v) {
    if (lattice.free(place, lattice.place(v))) near.insert(lattice.part(v));
  });
  return near;
}

}  // namespace

core::Lattice& Lattices::keeping(double distance) {
  if (const auto found = lattices_.find(distance); found != lattices_.end()) return found->second;
  const core::HalfSize arena{0.5 * experiment_.arena_width, 0.5 * experiment_.arena_height};
  core::Lattice& made = lattices_.try_emplace(distance, arena, distance, experiment_.obstacles.size()).first->second;
  made.build(experiment_.obstacles);
  return made;
}

std::optional<double> ShortestPaths::length(std::size_t robot, const core::Pose& from, const core::Pose& to) {
  const core::Lattice& lattice = lattices_.keeping(experiment_.robots[robot].radius);
  std::vector<Place> path = any_angle_path(lattice, {from.x, from.y}, {to.x, to.y});
  if (path.empty()) return {};
  pull_taut(lattice, path);
  for (int halvings = 0; halvings < 3 && path.size() > 2;
       ++halvings) {  // more corners, so that it follows round obstacles
    std::vector<Place> finer{path.front()};
    for (std::size_t k = 1; k < path.size(); ++k) {
      finer.push_back({0.5 * (path[k - 1].x + path[k].x), 0.5 * (path[k - 1].y + path[k].y)});
      finer.push_back(path[k]);
    }
    path = std::move(finer);
    pull_taut(lattice, path);
  }
  return length_of(path);
}

bool Ways::lead(std::size_t robot, const Place& from, const Place& to) {
  if (experiment_.obstacles.empty()) return true;
  core::Lattice& lattice = lattices_.keeping(experiment_.shield.distance + experiment_.robots[robot].radius -
                                             2.0 * core::standard_radius + rounding);
  if (lattice.free(from, to)) return true;
  const std::set<std::size_t> here = parts_near(lattice, from), there = parts_near(lattice, to);
  if (here.empty() || there.empty()) return true;
  return std::any_of(here.begin(), here.end(), [&](std::size_t part) { return there.count(part) > 0; });
}

std::vector<std::string> missing_ways(const Experiment& experiment) {
  std::vector<std::string> sentences;
  const auto reference = make_reference(experiment);
  const std::vector<double> beyond = sizes_beyond(experiment);
  constexpr double arrived = 0.01;  // so near to its place, as the summary of a run has it [m]
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
    const bool reached = search.found() && core::math::hypot(inside.x - last.pose.x, inside.y - last.pose.y) <= arrived;
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
