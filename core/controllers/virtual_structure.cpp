#include "core/controllers/virtual_structure.h"

namespace skein::core {

void VirtualStructureController::step(const ControllerInput& input, std::span<Twist> command,
                                      std::span<double>) noexcept {
  const std::span<const double> p = input.parameters;
  // The sums over pairs need no loop over pairs: sum_j (b_i - b_j) = n b_i - sum_j b_j.
  TrackingError sum;
  double robots = 0.0;
  for (std::size_t i = 0; i < command.size(); ++i) {
    if (input.out[i]) continue;
    const TrackingError& e = input.errors[i];
    sum = {sum.x + e.x, sum.y + e.y, sum.theta + e.theta};
    robots += 1.0;
  }
  for (std::size_t i = 0; i < command.size(); ++i) {
    const TrackingError& e = input.errors[i];
    const Twist& reference = input.reference_twists[i];
    const double x = p[c_x] * e.x + p[c_xx] * (robots * e.x - sum.x);
    const double y = p[c_y] * e.y + p[c_yy] * (robots * e.y - sum.y);
    const double theta = p[c_theta] * e.theta + p[c_tt] * (robots * e.theta - sum.theta);
    command[i] = input.out[i] ? Twist{} : Twist{reference.v + x - reference.omega * y, reference.omega + theta};
  }
}

}  // namespace skein::core
