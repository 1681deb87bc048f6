#include "core/controllers/leader_follower.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/controllers/independent.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double nearest = 0.01;  // two midpoints that are no farther apart have no bearing worth the name [m]

/// The heading of the line from the leader to the follower's point, against the follower's.
double gamma_of(const Pose& leader, double phi, const Pose& follower) noexcept {
  return leader.theta + phi - follower.theta;
}

}  // namespace

Separation separation(const Pose& leader, const Pose& follower, double ahead) noexcept {
  const double x = follower.x + ahead * math::cos(follower.theta) - leader.x;
  const double y = follower.y + ahead * math::sin(follower.theta) - leader.y;
  return {math::hypot(x, y), wrap_angle(math::atan2(y, x) - leader.theta)};
}

Separation separation_rate(const Pose& leader, const Twist& leads, const Pose& follower, const Twist& follows,
                           double ahead) noexcept {
  const Separation s = separation(leader, follower, ahead);
  const double gamma = gamma_of(leader, s.phi, follower);
  const double forward = follows.v, sideways = ahead * follows.omega;
  return {forward * math::cos(gamma) + sideways * math::sin(gamma) - leads.v * math::cos(s.phi),
          (-forward * math::sin(gamma) + sideways * math::cos(gamma) + leads.v * math::sin(s.phi)) / s.l - leads.omega};
}

void LeaderFollowerController::step(const ControllerInput& input, std::span<Twist> command,
                                    std::span<double> log) noexcept {
  const double d = input.parameters[ahead];
  const std::size_t none = command.size();
  std::size_t leader = none;
  for (std::size_t i = 0; i < command.size(); ++i) {
    double* const logged = log.data() + logs.size() * i;
    logged[0] = logged[1] = std::numeric_limits<double>::quiet_NaN();
    if (input.out[i]) {
      command[i] = {};
      continue;
    }
    const std::size_t before = leader;
    leader = i;
    if (before == none) {
      command[i] = track_alone(*input.gains, i, input.errors[i], input.reference_twists[i]);
      continue;
    }
    const ReferencePoint &of_leader = input.reference[before], &own = input.reference[i];
    const Separation now = separation(input.poses[before], input.poses[i], d);
    const Separation wanted = separation(of_leader.pose, own.pose, d);
    Separation rate;
    if (wanted.l > nearest) rate = separation_rate(of_leader.pose, of_leader.twist, own.pose, own.twist, d);
    // The wanted motion of the follower's point along the line from the leader and across it; the leader drives as
    // commanded at this tick, as far as (14) lets it.
    const double v_max = input.gains->v_max[before], omega_max = input.gains->omega_max[before];
    const Twist leads{std::clamp(command[before].v, -v_max, v_max),
                      std::clamp(command[before].omega, -omega_max, omega_max)};
    const double l = std::max(now.l, nearest);
    const double along = rate.l + input.parameters[alpha_l] * (wanted.l - now.l) + leads.v * math::cos(now.phi);
    const double across =
        l * (rate.phi + input.parameters[alpha_phi] * wrap_angle(wanted.phi - now.phi) + leads.omega) -
        leads.v * math::sin(now.phi);
    const double gamma = gamma_of(input.poses[before], now.phi, input.poses[i]);
    command[i] = {math::cos(gamma) * along - math::sin(gamma) * across,
                  (math::sin(gamma) * along + math::cos(gamma) * across) / d};
    logged[0] = now.l;
    logged[1] = now.phi;
  }
}

}  // namespace skein::core
