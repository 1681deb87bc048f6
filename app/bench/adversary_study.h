#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "app/controllers/adversary.h"

namespace skein::app {

/// One run with a hostile controller (adversary.h).
struct AdversaryOutcome {
  std::uint64_t seed = 0;
  Adversary kind{};
  std::int64_t ticks = 0;
  std::int64_t collisions = 0;
  double min_distance = 0.0;  ///< [m]
  double outside = 0.0;       ///< farthest that a body was over the arena's edge [m]
  double longest_wait = 0.0;  ///< of the control thread [s]
  std::int64_t late = 0;      ///< ticks without an answer
  bool stop_asked = false;    ///< STOP was pressed in the middle of the run
  bool stands = false;        ///< at the end every robot was commanded to stand, and acknowledged it
  std::string failure;        ///< why the run failed, if it did; this does not count as harm
};

/// One run of 10 s: the paper's platoon beside two obstacles, anywhere along its lap, under the adversary of this seed;
/// every third run is ended by STOP. `program`: a `skein`; empty: this program. `failure` has the reason if there is no
/// run.
AdversaryOutcome run_under_adversary(std::uint64_t seed, const std::string& program = {});

/// The results of all runs, as `key: value` lines.
std::string as_lines(const std::vector<AdversaryOutcome>& outcomes, double period);

/// Whether no robot collided or left the arena, no tick was more than a period late, and all robots stood at the end.
bool harmless(const AdversaryOutcome& outcome, double period) noexcept;

inline constexpr double adversary_period = 0.04;  // [s]

}  // namespace skein::app
