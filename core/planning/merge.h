#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/avoidance/steering.h"
#include "core/planning/lattice.h"
#include "core/planning/route.h"
#include "core/planning/traffic.h"
#include "core/reference/reference.h"

namespace skein::core {

/// How a reference that is near its moving place drives on to it: it looks at a point ahead on the place's line, and
/// hurries or waits until it is abreast of it; inside the bounds, forwards only, and with bounded acceleration.
Twist homing(const ReferencePoint& place, const ReferencePoint& from, const ReferenceBounds& bounds,
             double dt) noexcept;

/// Ways of one robot back to a place that drives on: wait, one or two straight lines to a point near where the place
/// will be, and from there as `homing` drives. Each is simulated to its end against the others' traffic; the soonest
/// wins.
class Merge {
 public:
  explicit Merge(std::size_t robots) : radius_(robots) {}

  struct Query {
    std::size_t robot = 0;
    Pose from;                          ///< at rest
    double begins = 0.0;                ///< [s] after the traffic's beginning
    double t = 0.0;                     ///< of the experiment, at the traffic's beginning [s]
    double keep = 0.1, least = 0.0785;  ///< between two midpoints; and where it is nearer at first [m]
    double grace = 0.0;                 ///< so long others may come nearer than that to where it stands [s]
    Pace pace;
    ReferenceBounds bounds;  ///< of the reference, without couplings
  };
  /// The legs of the soonest way, or none. `done`: when it ends [s].
  struct Way {
    std::array<Leg, 2> legs;
    std::size_t count = 0;
    double heading = 0.0;
    double done = 0.0;
    bool found = false;
  };
  Way find(const Query& query, const Reference& reference, const Lattice& lattice, const Traffic& traffic) noexcept;
  std::size_t trials() const noexcept { return trials_; }

 private:
  struct Stand {
    Pose pose;
    double t;  // [s]
  };
  void try_from(const Stand& stand, const Leg* before, Way& best) noexcept;
  void try_point(const Stand& stand, const Leg* before, double back, double aside, double wait, Way& best) noexcept;
  double home(Pose from, double t, double most) noexcept;
  bool clear(double x, double y, double t) const noexcept;
  bool clear_line(const Lattice::Place& from, const Lattice::Place& to, double leaves, double arrives) const noexcept;

  Query query_;
  const Reference* reference_ = nullptr;
  const Lattice* lattice_ = nullptr;
  const Traffic* traffic_ = nullptr;
  std::vector<double> radius_;  // to keep from each robot [m]
  std::size_t trials_ = 0;
};

}  // namespace skein::core
