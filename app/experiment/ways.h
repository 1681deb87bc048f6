#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "core/planning/lattice.h"

namespace skein::app {

/// A sentence for each robot for which obstacles and the arena's edge leave no way from its start to the place where
/// its reference comes to rest, even without other robots, at the shield's distance. References that never come to rest
/// are not checked.
std::vector<std::string> missing_ways(const Experiment& experiment);

/// Whether obstacles and the arena's edge leave a robot a way, at the shield's distance and without other robots.
class Ways {
 public:
  explicit Ways(const Experiment& experiment) : experiment_(experiment) {}

  /// From a place to another. A place too near to something is not judged: routes lead from there, and end nearby.
  bool lead(std::size_t robot, const core::Lattice::Place& from, const core::Lattice::Place& to);

 private:
  struct Parts {
    core::Lattice lattice;
    std::vector<std::size_t> part;  // of each vertex: those of one part are joined
  };
  const Parts& parts(double radius);
  std::set<std::size_t> parts_near(const Parts& parts, const core::Lattice::Place& place) const;

  const Experiment& experiment_;
  std::map<double, Parts> parts_;  // by the body's radius
};

/// The shortest path of one robot's midpoint round the experiment's obstacles, inside the arena, without other robots:
/// its body may touch. No run is faster than this path at v_max.
class ShortestPaths {
 public:
  explicit ShortestPaths(const Experiment& experiment) : experiment_(experiment) {}

  /// Its length from a place to another [m]; empty: there is none. Any-angle search (Theta*) on a lattice, pulled taut:
  /// up to 1 % longer than the shortest.
  std::optional<double> length(std::size_t robot, const core::Pose& from, const core::Pose& to);

 private:
  const core::Lattice& lattice(double radius);

  const Experiment& experiment_;
  std::map<double, core::Lattice> lattices_;  // by the body's radius
};

}  // namespace skein::app
