#include "app/experiment/experiment.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "core/reference/platoon.h"
#include "core/reference/polyline.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

std::shared_ptr<const core::Path> centred_path(const PathSpec& path) {
  using Shape = PathSpec::Shape;
  switch (path.shape) {
    case Shape::circle:
      return std::make_shared<core::Circle>(path.radius);
    case Shape::ellipse:
      return std::make_shared<core::Ellipse>(path.width, path.height);
    case Shape::lemniscate:
      return std::make_shared<core::Lemniscate>(path.width, path.height);
    case Shape::polyline:
    case Shape::line:
      return std::make_shared<core::Polyline>(path.points, path.radius, path.closed);
    case Shape::spline:
      return std::make_shared<core::Spline>(path.points, path.closed);
    case Shape::rounded_rectangle:
      break;
  }
  return std::make_shared<core::RoundedRectangle>(path.width, path.height, path.radius);
}

std::vector<core::SpacingChange> spacings(const ReferenceSpec& reference) {
  std::vector<core::SpacingChange> changes;
  changes.reserve(reference.changes.size());
  for (const ReferenceChange& change : reference.changes)
    changes.push_back({change.t, change.duration, change.shape.spacing});
  return changes;
}

core::Shape places(const ShapeSpec& spec, std::size_t robots) {
  return spec.offsets.empty() ? core::make_shape(spec.shape, robots, spec.spacing) : spec.offsets;
}

}  // namespace

std::string Experiment::calibration_file(std::size_t number) const {
  const std::string& file = camera_at(number).calibration;
  return file.empty() ? file : (std::filesystem::path(directory) / file).string();
}

std::int64_t Experiment::ticks() const noexcept {
  return std::llround(duration * rate);
}

std::optional<CameraKind> camera_kind(std::string_view source) {
  if (source == "none") return CameraKind::absent;
  if (source == "synthetic") return CameraKind::synthetic;
  const auto address = vision::parse_source(source);
  if (!address) return {};
  return address->live() ? CameraKind::live : CameraKind::recorded;
}

std::optional<std::string> real_time_reason(const Experiment& experiment) {
  if (experiment.camera.kind() != CameraKind::absent)
    return fmt::format("the camera \"{}\" runs in real time", experiment.camera.source);
  for (std::size_t i = 0; i < experiment.robots.size(); ++i)
    if (experiment.robots[i].has_link()) return fmt::format("robot {} has a link, which runs in real time", i + 1);
  return {};
}

std::string camera_prefix(const Experiment& experiment, std::size_t number) {
  return experiment.cameras() == 1 ? std::string() : fmt::format("camera {}: ", number + 1);
}

std::string robot_name(const Experiment& experiment, std::size_t robot) {
  const std::string& name = experiment.robots[robot].name;
  return fmt::format("robot {}{}", robot + 1, name.empty() ? "" : " (" + name + ")");
}

std::shared_ptr<const core::Path> make_path(const PathSpec& path) {
  auto centred = centred_path(path);
  if (path.centre == core::Point{}) return centred;
  return std::make_shared<core::MovedPath>(std::move(centred), path.centre.x, path.centre.y);
}

std::unique_ptr<const core::Trajectory> make_trajectory(const TrajectorySpec& t, const ReferenceSpec& defaults) {
  if (!t.samples.empty()) return std::make_unique<core::Timetable>(t.samples);
  auto path = make_path(t.path);
  const double speed = t.speed.value_or(defaults.speed), most = t.acceleration.value_or(defaults.acceleration);
  if (!t.from_rest_to_rest()) return std::make_unique<core::Rounds>(std::move(path), speed, t.start);
  const double distance = t.distance.value_or(path->length() - t.start);
  const core::Travel travel =
      t.duration ? core::Travel::within(distance, *t.duration, most) : core::Travel(distance, speed, most);
  return std::make_unique<core::Drive>(std::move(path), t.start, t.t, travel, t.turn_rate);
}

std::unique_ptr<const core::Reference> make_reference(const Experiment& experiment) {
  const ReferenceSpec& r = experiment.reference;
  const std::size_t n = experiment.robots.size();
  if (r.kind == ReferenceSpec::Kind::platoon)
    return std::make_unique<core::Platoon>(make_path(r.path), n, r.spacing, r.speed, r.start, spacings(r));
  if (r.kind == ReferenceSpec::Kind::independent) {
    std::vector<std::unique_ptr<const core::Trajectory>> trajectories;
    trajectories.reserve(n);
    for (const RobotSpec& robot : experiment.robots)
      trajectories.push_back(make_trajectory(robot.trajectory.value_or(TrajectorySpec{}), r));
    return std::make_unique<core::Independent>(std::move(trajectories));
  }
  std::vector<core::ShapeChange> changes;
  changes.reserve(r.changes.size());
  for (const ReferenceChange& change : r.changes)
    changes.push_back({change.t, change.duration, places(change.shape, n)});
  return std::make_unique<core::Formation>(make_path(r.path), r.speed, r.start, places(r.shape, n), std::move(changes));
}

core::TrackingGains make_tracking(const Experiment& experiment) {
  core::TrackingGains tracking;
  for (const RobotSpec& robot : experiment.robots) {
    tracking[core::TrackingGain::k_x].push_back(robot.k_x.value_or(experiment.controller.k_x));
    tracking[core::TrackingGain::k_theta].push_back(robot.k_theta.value_or(experiment.controller.k_theta));
  }
  return tracking;
}

core::Gains make_gains(const Experiment& experiment) {
  const ControllerSpec& c = experiment.controller;
  const std::size_t n = experiment.robots.size();
  core::Gains gains = core::paper_gains(n);  // every member has its size, then its value
  gains.saturation = c.saturation;
  gains.coupling = c.coupling;
  gains.k_y = c.k_y;
  gains.k = c.k;
  for (std::size_t i = 0; i < n; ++i) {
    const RobotSpec& robot = experiment.robots[i];
    gains.v_max[i] = robot.v_max.value_or(c.v_max);
    gains.omega_max[i] = robot.omega_max.value_or(c.omega_max);
    gains.c_x[i] = robot.c_x.value_or(c.c_x);
    gains.c_theta[i] = robot.c_theta.value_or(c.c_theta);
  }
  gains.k_xx = c.gains.k_xx;
  gains.c_xx = c.gains.c_xx;
  gains.l_xx = c.gains.l_xx;
  gains.k_tt = c.gains.k_tt;
  gains.c_tt = c.gains.c_tt;
  gains.l_tt = c.gains.l_tt;
  gains.k_yy = c.gains.k_yy;
  gains.c_yy = c.gains.c_yy;
  gains.policy = c.policy;
  core::TrackingGains tracking = make_tracking(experiment);
  gains.k_x = tracking[core::TrackingGain::k_x];
  gains.k_theta = tracking[core::TrackingGain::k_theta];
  for (const GainChange& change : experiment.gain_changes)
    if (change.t < experiment.duration)
      for (const core::TrackingGain name : core::tracking_names)
        for (std::size_t i = 0; i < change.tracking[name].size(); ++i)
          tracking[name][i] = std::max(tracking[name][i], change.tracking[name][i].value_or(0.0));
  gains.k_x_reserved = tracking[core::TrackingGain::k_x];
  gains.k_theta_reserved = tracking[core::TrackingGain::k_theta];
  core::use_policy(gains, std::vector<core::Twist>(n));
  return gains;
}

core::CommandLimits make_limits(const Experiment& experiment, std::size_t robot) {
  const RobotSpec& own = experiment.robots[robot];
  return {own.v_max.value_or(experiment.controller.v_max), own.omega_max.value_or(experiment.controller.omega_max),
          own.drive};
}

core::AvoidanceParameters make_avoidance(const Experiment& experiment, std::size_t robot) {
  const RobotSpec& own = experiment.robots[robot];
  core::AvoidanceParameters parameters = experiment.avoidance;
  parameters.alpha = own.alpha.value_or(parameters.alpha);
  parameters.beta = own.beta.value_or(parameters.beta);
  parameters.p = static_cast<int>(own.p.value_or(parameters.p));
  parameters.K_a = own.K_a.value_or(parameters.K_a);
  parameters.K_o = own.K_o.value_or(parameters.K_o);
  return parameters;
}

std::vector<double> sizes_beyond(const Experiment& experiment) {
  std::vector<double> beyond;
  beyond.reserve(experiment.robots.size());
  for (const RobotSpec& robot : experiment.robots) beyond.push_back(robot.radius - core::standard_radius);
  return beyond;
}

}  // namespace skein::app
