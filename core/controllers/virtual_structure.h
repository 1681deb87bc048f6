#pragma once

#include <array>

#include "core/controllers/controller.h"

namespace skein::core {

/// The virtual structure with mutual coupling of van den Broek, van de Wouw and Nijmeijer (CDC 2009), in the errors
/// (4):
///   v_i     = v_ref,i + c_x x_i - c_y omega_ref,i y_i + sum_j c_xx (x_i - x_j) - sum_j c_yy omega_ref,i (y_i - y_j)
///   omega_i = omega_ref,i + c_theta theta_i + sum_j c_tt (theta_i - theta_j)
/// the sums over all other robots in the group. Linear and unbounded: for large errors the limits act. Lateral errors
/// vanish only while omega_ref is nonzero (persistently exciting): along a straight line they persist. The gains are
/// its own parameters, not those of [controller].
class VirtualStructureController final : public Controller {
 public:
  enum Parameter : std::size_t { c_x, c_y, c_theta, c_xx, c_yy, c_tt };
  static constexpr std::array<ControllerParameter, 6> parameters{{
      {"c_x", "1/s", 0.0, 100.0, 1.0, "tracking of the error ahead"},
      {"c_y", "", -0.999, 1000.0, 4.0, "tracking of the error to the side, per omega_ref"},
      {"c_theta", "1/s", 0.0, 100.0, 1.0, "tracking of the heading"},
      {"c_xx", "1/s", 0.0, 100.0, 0.5, "coupling of the errors ahead, of every pair"},
      {"c_yy", "", 0.0, 1000.0, 1.0, "coupling of the errors to the side, of every pair, per omega_ref"},
      {"c_tt", "1/s", 0.0, 100.0, 0.2, "coupling of the headings, of every pair"},
  }};

  explicit VirtualStructureController(std::size_t) {}
  void step(const ControllerInput& input, std::span<Twist> command, std::span<double> log) noexcept override;
};

}  // namespace skein::core
