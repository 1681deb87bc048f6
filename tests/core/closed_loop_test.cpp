// Theorem 1 at work: from wherever the robots start, the law brings them onto their references, and V falls all the
// way.
#include <algorithm>
#include <memory>
#include <ostream>
#include <string>

#include "core/control/coordination_law.h"
#include "core/control/lyapunov.h"
#include "core/kinematics/unicycle.h"
#include "core/reference/platoon.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Coupling;
using core::Pose;
using core::ReferencePoint;
using core::Saturation;
using core::TrackingError;
using core::Twist;

constexpr double corner_radius = 0.119, speed = 0.05;

struct Variant {
  Coupling coupling;
  Saturation saturation;
  std::string name;

  friend void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.name; }
};

class ClosedLoop : public ::testing::TestWithParam<Variant> {};

bool within(const std::vector<TrackingError>& errors, double distance, double angle) {
  return std::all_of(errors.begin(), errors.end(), [&](const TrackingError& e) {
    return std::hypot(e.x, e.y) < distance && std::abs(e.theta) < angle;
  });
}

/// The errors' size that counts as arrived: a tenth of what a camera over the floor can tell.
bool arrived(const std::vector<TrackingError>& errors) {
  return within(errors, 1e-4, 1e-3);
}

/// And stays there, but for what a sampled command leaves at a corner's joint: a heading of dt v_ref / R = 0.0021 at
/// most on top of what was left, and the way to the side that it leads to before it is gone.
bool stays(const std::vector<TrackingError>& errors) {
  return within(errors, 1e-3, 4e-3);
}

/// How much V may rise over one step of dt although (20) holds at its start, because the commands are held meanwhile:
/// by Taylor, half dt^2 times the curvature of V along the motion, which is at most k_y k / N for the positions and 1
/// for the headings; twice that for the change of the motion itself. Where a reference enters or leaves a corner
/// within the step, its heading also turns by up to dt v_ref / R that the command at the step's start knew nothing of.
double rise_of_a_held_command(const core::Gains& gains, const std::vector<TrackingError>& errors,
                              const std::vector<Twist>& reference, const std::vector<Twist>& command,
                              const std::vector<ReferencePoint>& after, double dt) {
  const double to_position = gains.k_y * gains.k / core::group_normaliser(gains.k, errors);
  double rise = 1e-13;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TrackingError de = core::error_rate(errors[i], reference[i], command[i]);
    rise += dt * dt * (to_position * (de.x * de.x + de.y * de.y) + de.theta * de.theta);
    const bool at_a_joint = after[i].twist.omega != reference[i].omega;
    if (at_a_joint) rise += (dt * std::abs(errors[i].theta) + to_position * dt * dt) * speed / corner_radius;
  }
  return rise;
}

TEST_P(ClosedLoop, ConvergesFromAnywhereAndVNeverRises) {
  const auto path = std::make_shared<core::RoundedRectangle>(1.3, 0.9, corner_radius);
  for (int start = 0; start < 36; ++start) {
    Draw draw(1000 + static_cast<std::uint64_t>(start));
    const auto n = static_cast<std::size_t>(1 + start % 6);
    const double dt = start < 12 ? 0.005 : draw.between(0.001, 0.005);
    const core::Platoon platoon(path, n, 0.12, speed, draw.between(0.0, 4.0));
    core::Gains gains = core::paper_gains(n);
    gains.coupling = GetParam().coupling;
    gains.saturation = GetParam().saturation;

    std::vector<Pose> poses;
    for (std::size_t i = 0; i < n; ++i) {
      const Pose there = platoon.at(i, 0.0).pose;
      const double away = draw.between(0.0, 1.0), direction = draw.angle();
      poses.push_back({there.x + away * std::cos(direction), there.y + away * std::sin(direction), draw.angle()});
    }

    std::vector<ReferencePoint> points(n);
    std::vector<TrackingError> errors(n);
    std::vector<Twist> reference(n), command(n);
    double v_before = 1e300, allowed_rise = 0.0, arrived_at = -1.0;
    constexpr double patience = 600.0;  // virtual seconds; with six robots k_x leaves 1 cm/s for tracking
    long step = 0;
    for (double t = 0.0; t < patience; t = dt * static_cast<double>(++step)) {
      platoon.at(t, points);
      if (step > 0) allowed_rise = rise_of_a_held_command(gains, errors, reference, command, points, dt);
      for (std::size_t i = 0; i < n; ++i) {
        reference[i] = points[i].twist;
        errors[i] = core::tracking_error(points[i].pose, poses[i]);
      }
      core::use_all_authority(gains, reference);
      for (std::size_t i = 0; i < n; ++i) ASSERT_TRUE(core::margins(gains, i, reference[i]).hold());

      const double v = core::lyapunov(gains, errors);
      ASSERT_LE(v - v_before, allowed_rise) << "start " << start << ", n " << n << ", dt " << dt << ", t " << t;
      v_before = v;
      if (arrived(errors) && arrived_at < 0.0) arrived_at = t;
      if (arrived_at >= 0.0) {
        ASSERT_TRUE(stays(errors)) << "start " << start << ", n " << n << ", t " << t;
      }
      if (arrived_at >= 0.0 && t > arrived_at + 20.0) break;

      core::coordination_law(gains, errors, reference, command);
      for (std::size_t i = 0; i < n; ++i) {
        if (gains.coupling == Coupling::bounded) {
          ASSERT_LE(std::abs(command[i].v), gains.v_max[i] * (1.0 + 1e-12));
          ASSERT_LE(std::abs(command[i].omega), gains.omega_max[i] * (1.0 + 1e-12));
        }
        poses[i] = core::advance(poses[i], command[i], dt);
      }
    }
    EXPECT_GE(arrived_at, 0.0) << "start " << start << ", n " << n << ": V still " << v_before;
  }
}

INSTANTIATE_TEST_SUITE_P(Theorem1, ClosedLoop,
                         ::testing::Values(Variant{Coupling::paper, Saturation::tanh, "PaperTanh"},
                                           Variant{Coupling::paper, Saturation::algebraic, "PaperAlgebraic"},
                                           Variant{Coupling::bounded, Saturation::tanh, "BoundedTanh"},
                                           Variant{Coupling::bounded, Saturation::algebraic, "BoundedAlgebraic"}),
                         [](const auto& variant) { return variant.param.name; });

}  // namespace
}  // namespace skein::test
