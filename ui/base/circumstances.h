#pragma once

#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::ui {

/// What the experiment and the events of a run until now say about its robots and obstacles, and a single record does
/// not. Robots from 0.
struct Circumstances {
  Circumstances() = default;
  explicit Circumstances(const app::Experiment& experiment);  ///< before its first event
  void note(const app::TickRecord& record);                   ///< every one, in order

  std::vector<core::Obstacle> obstacles;  ///< by number; radius 0: absent
  std::set<int> held;                     ///< by the operator, or because their link was lost
  std::set<int> disobedient;              ///< did not drive as commanded, and are commanded to stand
  struct Moved {
    app::Event how;  ///< Move, Kick, Perturb or Kidnap
    double t;        ///< [s]
  };
  std::map<int, Moved> moved;  ///< the last time, and not in place again since

  std::vector<double> radii;                             ///< of the robots' bodies [m]
  double half_width = HUGE_VAL, half_height = HUGE_VAL;  ///< of the arena, centred on the origin [m]
  double detects = 0.0;  ///< avoidance sets in at this distance of two standard bodies' midpoints [m]
};

}  // namespace skein::ui
