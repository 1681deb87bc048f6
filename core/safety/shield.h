#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/avoidance/near_robots.h"
#include "core/avoidance/obstacle.h"
#include "core/geometry/pose.h"

namespace skein::core {

struct ShieldParameters {
  bool enabled = true;
  double distance = 0.078;  ///< midpoints of standard bodies are kept this far apart [m]: an e-puck's 70 mm plus 8 mm
                            ///< for sampling and wheels; others keep the same gap
  double gamma = 4.0;       ///< how fast the gap may close, as a share of the remaining gap [1/s]
  /// Half the arena's size, centred on the origin: a body keeps as far from its edge as from an obstacle. [m]
  double half_width = std::numeric_limits<double>::infinity();
  double half_height = std::numeric_limits<double>::infinity();
};

/// The last step before the wheels: changes forward speeds only, as little as possible, so that no two robots close in
/// faster than the gap between them allows:
///   minimise sum (v_i - v_i*)^2   s.t.  n_ij . (v_i u_i - v_j u_j) >= -gamma (d_ij - D),   |v_i| <= v_limit,i
/// with u_i the heading and n_ij the unit vector from j to i. v = 0 always satisfies it, so it is always feasible;
/// if d < D already, it requires that the gap does not shrink. Turning rates stay as they are, so that robots can go on
/// turning away from each other. A round obstacle counts as a robot that stands still, and so does the nearest point of
/// each edge of the arena: a robot that is already over the edge may drive back, never farther out.
class Shield {
 public:
  Shield(std::size_t robots, std::size_t obstacles);

  struct Scene {
    std::span<const Pose> poses;
    std::span<const Obstacle> obstacles = {};
    std::span<const double> v_limit;  ///< of each robot's speed at its turning rate; |v_i| <= v_limit,i on entry [m/s]
    std::span<const double> doubt = {};  ///< of each pose, added to D for both robots of a pair; empty: none [m]
    /// Robots that drive at commands[i].v and ignore commands; empty: none. Their speeds are not changed; the other
    /// robots give way as far as they can: they do not drive towards them.
    std::span<const bool> adrift = {};
    Sizes sizes = {};  ///< of the bodies
  };
  /// Changes `commands` in place; `touched[i]` becomes true if v_i had to change (by more than 1e-9 m/s).
  void apply(const ShieldParameters& parameters, const Scene& scene, std::span<Twist> commands,
             std::span<bool> touched) noexcept;

 private:
  /// a_i v_i + a_j v_j >= bound, bound <= 0; a_j = 0 for an obstacle or an edge (then j = i).
  struct Constraint {
    std::size_t i, j;
    double a_i, a_j, bound, multiplier;
  };
  void collect(const ShieldParameters& parameters, const Scene& scene) noexcept;
  void fix(std::span<const bool> adrift, std::span<const Twist> commands) noexcept;

  std::vector<Constraint> constraints_;  // reserved for every pair, obstacle and edge: apply never allocates
  std::vector<double> cos_, sin_;        // of the headings
  std::vector<double> v_, lower_, upper_;
  NearRobots near_;
};

}  // namespace skein::core
