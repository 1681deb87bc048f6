// Three robots in a line behind one another under the coupled law (15) of Kostic et al. 2010, the last of them 15 cm
// off its place: prints how far the group is from its references, second by second.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>

#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"

namespace core = skein::core;

int main() {
  constexpr std::size_t robots = 3;
  constexpr double period = 0.04;  // [s]
  core::Gains gains = core::paper_gains(robots);
  const std::array<core::Twist, robots> reference{{{0.05, 0.0}, {0.05, 0.0}, {0.05, 0.0}}};  // 5 cm/s along x
  core::use_all_authority(gains, reference);

  std::array<core::Pose, robots> place{{{0.0, 0.0, 0.0}, {-0.2, 0.0, 0.0}, {-0.4, 0.0, 0.0}}}, pose = place;
  pose[2].y -= 0.15;
  std::array<core::TrackingError, robots> error;
  std::array<core::Twist, robots> command;
  double largest = 0.0;
  for (int tick = 0; tick <= 1000; ++tick) {
    largest = 0.0;
    for (std::size_t i = 0; i < robots; ++i) {
      error[i] = core::tracking_error(place[i], pose[i]);
      largest = std::max(largest, core::distance(place[i], pose[i]));
    }
    if (tick % 125 == 0) std::printf("%4.0f s: %6.1f mm\n", tick * period, 1000.0 * largest);
    core::coordination_law(gains, error, reference, command);
    for (std::size_t i = 0; i < robots; ++i) {
      place[i] = core::advance(place[i], reference[i], period);
      pose[i] = core::advance(pose[i], command[i], period);
    }
  }
  return largest < 0.001 ? 0 : 1;  // within a millimetre after 40 s
}
