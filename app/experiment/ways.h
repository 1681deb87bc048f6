#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "core/planning/lattice.h"

namespace skein::app {

/// A sentence for each robot for which obstacles and the arena's edge leave no way from its start to the place where
/// its reference comes to rest, even without other robots, at the shield's distance. References that never come to rest
/// are not checked.
std::vector<std::string> missing_ways(const Experiment& experiment);

/// The experiment's arena with its obstacles, once for each distance that a midpoint keeps from them.
class Lattices {
 public:
  explicit Lattices(const Experiment& experiment) : experiment_(experiment) {}

  core::Lattice& keeping(double distance);  // [m]

 private:
  const Experiment& experiment_;
  std::map<double, core::Lattice> lattices_;
};

/// Whether obstacles and the arena's edge leave a robot a way, at the shield's distance and without other robots.
class Ways {
 public:
  explicit Ways(const Experiment& experiment) : experiment_(experiment), lattices_(experiment) {}

  /// From a place to another. A place too near to something is not judged: routes lead from there, and end nearby.
  bool lead(std::size_t robot, const core::Lattice::Place& from, const core::Lattice::Place& to);

 private:
  const Experiment& experiment_;
  Lattices lattices_;
};

/// The shortest path of one robot's midpoint round the experiment's obstacles, inside the arena, without other robots:
/// its body may touch. No run is faster than this path at v_max.
class ShortestPaths {
 public:
  explicit ShortestPaths(const Experiment& experiment) : experiment_(experiment), lattices_(experiment) {}

  /// Its length from a place to another [m]; empty: there is none. Any-angle search (Theta*) on a lattice, pulled taut:
  /// up to 1 % longer than the shortest.
  std::optional<double> length(std::size_t robot, const core::Pose& from, const core::Pose& to);

 private:
  const Experiment& experiment_;
  Lattices lattices_;
};

}  // namespace skein::app
