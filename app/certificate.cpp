#include "app/certificate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace skein::app {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

void keep_smallest(Certificate::Worst& worst, double value, double t) noexcept {
  if (value < worst.value) worst = {value, t};
}
void keep_largest(Certificate::Worst& worst, double value, double t) noexcept {
  if (value > worst.value) worst = {value, t};
}

void keep_smallest(Certificate::Theorem::Least& least, double value, double t, std::size_t robot) noexcept {
  if (value < least.value) least = {value, t, robot};
}

Certificate::Theorem::Case case_of(const Certificate::Theorem& theorem, double v_max, double omega_max) noexcept {
  using Case = Certificate::Theorem::Case;
  constexpr double nothing = 1e-3;  // of a limit: between two ticks it may be a little smaller than at both
  if (theorem.v.value > nothing * v_max) return Case::moving;
  return theorem.omega.value > nothing * omega_max && theorem.continuous_omega ? Case::stopping : Case::neither;
}

std::string as_text(const Certificate::Theorem& theorem) {
  using Case = Certificate::Theorem::Case;
  const std::string v =
      fmt::format("{:.4g} m/s, robot {} at t = {:g} s", theorem.v.value, theorem.v.robot + 1, theorem.v.t);
  const std::string omega = fmt::format("{:.4g} rad/s, robot {} at t = {:g} s", theorem.omega.value,
                                        theorem.omega.robot + 1, theorem.omega.t);
  if (theorem.holds == Case::moving)
    return fmt::format("case 1, v_ref is nonzero (smallest: {}), bounded and uniformly continuous", v);
  if (theorem.holds == Case::stopping)
    return fmt::format("case 2, v_ref vanishes ({}) while omega_ref is nonzero (smallest: {}) and uniformly continuous",
                       v, omega);
  return fmt::format(
      "does not apply: v_ref vanishes ({}), against case 1, and omega_ref {}, against case 2; errors stay "
      "bounded but need not vanish",
      v, theorem.continuous_omega ? fmt::format("vanishes ({})", omega) : "jumps along the path");
}

std::array<std::pair<core::PairTable*, core::GainName>, core::pair_names.size()> parts_of(core::Gains& g) {
  using Name = core::GainName;
  return {{{&g.k_xx, Name::k_xx},
           {&g.k_tt, Name::k_tt},
           {&g.k_yy, Name::k_yy},
           {&g.c_xx, Name::c_xx},
           {&g.c_tt, Name::c_tt},
           {&g.c_yy, Name::c_yy},
           {&g.l_xx, Name::l_xx},
           {&g.l_tt, Name::l_tt}}};
}

}  // namespace

bool Certificate::holds() const noexcept {
  constexpr double rounding = -1e-12;
  return std::all_of(robots.begin(), robots.end(), [](const Robot& r) {
    return r.k_x.value > 0.0 && r.k_theta.value > 0.0 && r.b.value >= 0.0 && r.f.value >= rounding &&
           r.g.value >= rounding && r.v.value < 1.0 && r.omega.value < 1.0 && r.wheel.value <= 1.0;
  });
}

Certificate certify(const Experiment& experiment) {
  const std::unique_ptr<const core::Reference> reference = make_reference(experiment);
  core::Gains gains = make_gains(experiment);
  core::GainSchedule schedule(experiment.controller.gains);
  const std::size_t n = experiment.robots.size();

  Certificate certificate;
  certificate.fixed = gains.policy == core::GainPolicy::fixed;
  certificate.v_max = experiment.controller.v_max;
  certificate.omega_max = experiment.controller.omega_max;
  Certificate::Robot start;
  start.k_x.value = start.k_theta.value = start.b.value = start.f.value = start.g.value = infinite;
  start.v.value = start.omega.value = start.wheel.value = -infinite;
  certificate.robots.assign(n, start);

  certificate.theorem.v.value = certificate.theorem.omega.value = infinite;
  certificate.theorem.continuous_omega = reference->smooth();

  std::vector<core::ReferencePoint> points(n);
  std::vector<core::Twist> twists(n);
  std::size_t next_change = 0;
  for (std::int64_t k = 0; k < experiment.ticks(); ++k) {
    const double t = static_cast<double>(k) / experiment.rate;
    for (; next_change < experiment.gain_changes.size() && t >= experiment.gain_changes[next_change].t; ++next_change) {
      const GainChange& change = experiment.gain_changes[next_change];
      for (const core::GainName name : core::pair_names)
        if (change[name]) schedule.ramp(name, *change[name], change.ramp);
    }
    if (k > 0) schedule.step(experiment.period());
    for (const auto& [target, name] : parts_of(gains)) *target = core::table(schedule.now(), name);
    reference->at(t, points);
    for (std::size_t i = 0; i < n; ++i) twists[i] = points[i].twist;
    core::use_policy(gains, twists);
    for (std::size_t i = 0; i < n; ++i) {
      Certificate::Robot& robot = certificate.robots[i];
      const core::CommandLimits limits = make_limits(experiment, i);
      const double v = std::abs(twists[i].v), omega = std::abs(twists[i].omega);
      keep_smallest(certificate.theorem.v, v, t, i);
      keep_smallest(certificate.theorem.omega, omega, t, i);
      keep_smallest(robot.k_x, gains.k_x[i], t);
      keep_smallest(robot.k_theta, gains.k_theta[i], t);
      const core::Margins margins = core::margins(gains, i, twists[i]);
      keep_smallest(robot.b, margins.b, t);
      keep_smallest(robot.f, margins.f, t);
      keep_smallest(robot.g, margins.g, t);
      keep_largest(robot.v, v / limits.v_max, t);
      keep_largest(robot.omega, omega / limits.omega_max, t);
      keep_largest(robot.wheel, (v + 0.5 * limits.drive.track * omega) / limits.drive.max_wheel_speed(), t);
    }
  }
  certificate.theorem.holds = case_of(certificate.theorem, certificate.v_max, certificate.omega_max);
  return certificate;
}

std::string as_lines(const Certificate& certificate) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < certificate.robots.size(); ++i) {
    const Certificate::Robot& r = certificate.robots[i];
    fmt::format_to(out, "robot_{}_smallest_k_x: {:.4g} m/s ({:.0f} % of v_max) at t = {:g} s\n", i + 1, r.k_x.value,
                   100.0 * r.k_x.value / certificate.v_max, r.k_x.t);
    fmt::format_to(out, "robot_{}_smallest_k_theta: {:.4g} rad/s ({:.0f} % of omega_max) at t = {:g} s\n", i + 1,
                   r.k_theta.value, 100.0 * r.k_theta.value / certificate.omega_max, r.k_theta.t);
    if (certificate.fixed) {
      fmt::format_to(out, "robot_{}_smallest_margin_f: {:.4g} m/s at t = {:g} s\n", i + 1, r.f.value, r.f.t);
      fmt::format_to(out, "robot_{}_smallest_margin_g: {:.4g} rad/s at t = {:g} s\n", i + 1, r.g.value, r.g.t);
    }
    fmt::format_to(
        out, "robot_{}_reference: at most {:.0f} % of v_max, {:.0f} % of omega_max, {:.0f} % of a wheel (t = {:g} s)\n",
        i + 1, 100.0 * r.v.value, 100.0 * r.omega.value, 100.0 * r.wheel.value, r.wheel.t);
  }
  fmt::format_to(out, "theorem_1: {}\n", as_text(certificate.theorem));
  fmt::format_to(out, "conditions_18: {}\n", certificate.holds() ? "hold over the whole reference" : "VIOLATED");
  return text;
}

}  // namespace skein::app
