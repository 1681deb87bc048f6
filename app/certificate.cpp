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

}  // namespace

bool Certificate::holds() const noexcept {
  return std::all_of(robots.begin(), robots.end(), [](const Robot& r) {
    return r.k_x.value > 0.0 && r.k_theta.value > 0.0 && r.b.value >= 0.0 && r.v.value < 1.0 && r.omega.value < 1.0 &&
           r.wheel.value <= 1.0;
  });
}

Certificate certify(const Experiment& experiment) {
  const std::unique_ptr<const core::Reference> reference = make_reference(experiment);
  core::Gains gains = make_gains(experiment);
  core::GainSchedule schedule({gains.k_xx, gains.k_tt, gains.k_yy});
  const std::size_t n = experiment.robots.size();

  Certificate certificate;
  certificate.v_max = experiment.controller.v_max;
  certificate.omega_max = experiment.controller.omega_max;
  Certificate::Robot start;
  start.k_x.value = start.k_theta.value = start.b.value = infinite;
  start.v.value = start.omega.value = start.wheel.value = -infinite;
  certificate.robots.assign(n, start);

  std::vector<core::ReferencePoint> points(n);
  std::vector<core::Twist> twists(n);
  std::size_t next_change = 0;
  for (std::int64_t k = 0; k < experiment.ticks(); ++k) {
    const double t = static_cast<double>(k) / experiment.rate;
    for (; next_change < experiment.gain_changes.size() && t >= experiment.gain_changes[next_change].t; ++next_change) {
      const GainChange& change = experiment.gain_changes[next_change];
      if (change.k_xx) schedule.ramp(core::GainName::k_xx, *change.k_xx, change.ramp);
      if (change.k_tt) schedule.ramp(core::GainName::k_tt, *change.k_tt, change.ramp);
      if (change.k_yy) schedule.ramp(core::GainName::k_yy, *change.k_yy, change.ramp);
    }
    if (k > 0) schedule.step(experiment.period());
    gains.k_xx = schedule.now().k_xx;
    gains.k_tt = schedule.now().k_tt;
    gains.k_yy = schedule.now().k_yy;
    reference->at(t, points);
    for (std::size_t i = 0; i < n; ++i) twists[i] = points[i].twist;
    core::use_all_authority(gains, twists);
    for (std::size_t i = 0; i < n; ++i) {
      Certificate::Robot& robot = certificate.robots[i];
      const core::CommandLimits limits = make_limits(experiment, i);
      const double v = std::abs(twists[i].v), omega = std::abs(twists[i].omega);
      keep_smallest(robot.k_x, gains.k_x[i], t);
      keep_smallest(robot.k_theta, gains.k_theta[i], t);
      keep_smallest(robot.b, core::margins(gains, i, twists[i]).b, t);
      keep_largest(robot.v, v / limits.v_max, t);
      keep_largest(robot.omega, omega / limits.omega_max, t);
      keep_largest(robot.wheel, (v + 0.5 * limits.drive.track * omega) / limits.drive.max_wheel_speed(), t);
    }
  }
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
    fmt::format_to(
        out, "robot_{}_reference: at most {:.0f} % of v_max, {:.0f} % of omega_max, {:.0f} % of a wheel (t = {:g} s)\n",
        i + 1, 100.0 * r.v.value, 100.0 * r.omega.value, 100.0 * r.wheel.value, r.wheel.t);
  }
  fmt::format_to(out, "conditions_18: {}\n", certificate.holds() ? "hold over the whole reference" : "VIOLATED");
  return text;
}

}  // namespace skein::app
