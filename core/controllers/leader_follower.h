#pragma once

#include <array>
#include <string_view>

#include "core/controllers/controller.h"

namespace skein::core {

/// The position of a follower's control point relative to its leader: the distance l from the leader's midpoint [m] and
/// the bearing phi from the leader's heading, counter-clockwise [rad].
struct Separation {
  double l = 0.0, phi = 0.0;
};
/// For the point `ahead` of the follower's midpoint [m].
Separation separation(const Pose& leader, const Pose& follower, double ahead) noexcept;
/// Its rate of change while both drive. Requires l above 0. [m/s, rad/s]
Separation separation_rate(const Pose& leader, const Twist& leads, const Pose& follower, const Twist& follows,
                           double ahead) noexcept;

/// Leader and followers by separation and bearing: the l-phi control of Desai, Ostrowski and Kumar (2001), which
/// linearises input to output, so that
///   l' = l_ref' + alpha_l (l_ref - l)        phi' = phi_ref' + alpha_phi (phi_ref - phi)
/// of the point `ahead` of the follower's midpoint. Robot 1 tracks its own reference (`track_alone`); every other robot
/// follows the robot in front of it. If that robot is out of the group, it follows the nearest one in front that is in
/// the group; if there is none, it leads. l_ref and phi_ref are those of the references, and change where the formation
/// bends. Errors of a leader propagate to its followers: no follower corrects its own place in the world.
class LeaderFollowerController final : public Controller {
 public:
  enum Parameter : std::size_t { alpha_l, alpha_phi, ahead };
  static constexpr std::array<ControllerParameter, 3> parameters{{
      {"alpha_l", "1/s", 0.0, 100.0, 0.8, "how fast the distance is corrected"},
      {"alpha_phi", "1/s", 0.0, 100.0, 0.8, "how fast the bearing is corrected"},
      {"ahead", "m", 0.005, 0.5, 0.03, "where the follower's point is, ahead of its midpoint"},
  }};
  static constexpr std::array<std::string_view, 2> logs{"l", "phi"};

  explicit LeaderFollowerController(std::size_t) {}
  void step(const ControllerInput& input, std::span<Twist> command, std::span<double> log) noexcept override;
};

}  // namespace skein::core
