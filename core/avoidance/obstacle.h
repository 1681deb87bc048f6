#pragma once

namespace skein::core {

/// A round obstacle that stands on the floor.
struct Obstacle {
  double x = 0.0;       ///< [m]
  double y = 0.0;       ///< [m]
  double radius = 0.0;  ///< [m]
};

/// Radius of an e-puck's body; two robots touch at twice this distance. [m]
inline constexpr double robot_radius = 0.035;

}  // namespace skein::core
