#include "app/tick/control_tick.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/tick/tick_state.h"
#include "core/control/formation.h"
#include "core/control/lyapunov.h"
#include "core/estimation/pose_filter.h"
#include "core/kinematics/step_motor.h"
#include "core/simulation/simulated_robot.h"

namespace skein::app {
namespace {

/// A detour keeps this much more distance than the shield asks for, so that the shield stays out of it. [m]
constexpr double detour_margin = 0.012;

/// Staging looks so far ahead [s].
constexpr double staging_horizon = 3.0;

/// The time within which the filter comes to believe a new pose. [s]
constexpr double settles = 0.5;

/// The shield keeps bodies inside the arena as well.
core::ShieldParameters shield_of(const Experiment& e) {
  core::ShieldParameters parameters = e.shield;
  parameters.half_width = 0.5 * e.arena_width;
  parameters.half_height = 0.5 * e.arena_height;
  return parameters;
}

/// The formation's, on its clock.
std::unique_ptr<const core::Reference> make_reference_of_tick(const Experiment& e, const core::FormationClock& clock) {
  std::unique_ptr<const core::Reference> on_time = make_reference(e);
  if (!e.avoidance.formation_waits) return on_time;
  return std::make_unique<core::WaitingReference>(std::move(on_time), clock);
}

std::vector<std::optional<core::Pose>> ends_of(const core::Reference& reference, double duration) {
  std::vector<std::optional<core::Pose>> ends(reference.robots());
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (const core::ReferencePoint last = reference.at(i, duration); last.twist == core::Twist{}) ends[i] = last.pose;
  return ends;
}

std::unique_ptr<core::Planner> make_planner(const Experiment& e, const core::Reference& reference,
                                            core::FormationClock& clock, std::size_t obstacles) {
  if (e.avoidance.kind != core::AvoidanceKind::plan || !e.avoidance.enabled) return nullptr;
  const std::vector<double> beyond = sizes_beyond(e);
  const double most = core::Sizes(beyond).most();
  core::Planner::Setup setup{e.robots.size(),
                             obstacles,
                             {0.5 * e.arena_width, 0.5 * e.arena_height},
                             e.shield.distance + 2.0 * most,
                             e.duration,
                             e.shield.gamma,
                             core::standard_radius + most};
  setup.smaller.reserve(beyond.size());
  for (const double larger : beyond) setup.smaller.push_back(most - larger);
  setup.improve = e.avoidance.improve;
  return std::make_unique<core::Planner>(setup, reference, e.avoidance.formation_waits ? &clock : nullptr);
}

/// How far V may seem to rise where poses are noisy: its steepest slope is k_y a metre, and noise stays below eight
/// times its deviation. Half a millimetre is what rounding, whole steps and slip make of exact poses, one what a camera
/// sees.
double rise_tolerance(const Experiment& e) {
  const auto of_poses = [&] {
    switch (e.camera.kind()) {
      case CameraKind::absent:
        return 0.5e-3;
      case CameraKind::synthetic:
      case CameraKind::recorded:
      case CameraKind::live:
        break;
    }
    return 1e-3;
  };
  const double position = std::max(of_poses(), e.simulation.pose_noise);
  constexpr double deviations = 8.0, heading_error = 0.3;  // [rad]: its slope by a heading is that heading's error
  return deviations * (e.controller.k_y * position + heading_error * e.simulation.heading_noise);
}

}  // namespace

TickSetup::TickSetup(const Experiment& e)
    : experiment(e),
      reference(make_reference_of_tick(e, clock)),
      demand(reference->demand(e.controller.k_y)),
      ends(ends_of(*reference, e.duration)),
      shield_parameters(shield_of(e)),
      has_camera(e.camera.kind() != CameraKind::absent),
      sees_commands(has_camera && e.camera.kind() != CameraKind::recorded),
      cameras(e.cameras()),
      beyond(sizes_beyond(e)) {
  for (std::size_t i = 0; i < e.robots.size(); ++i) {
    limits.push_back(make_limits(e, i));
    fields.push_back(make_avoidance(e, i));
  }
}

TickMemory::TickMemory(const Experiment& e, const core::Gains& first, const core::ReferenceDemand& demand)
    : gains(first),
      couplings(e, gains, demand),
      law_parameters(e.controller.law),
      obstacles(e.obstacles),
      avoidance(e.robots.size(), obstacles.all().size()),
      shield(e.robots.size(), obstacles.all().size() + e.robots.size()),
      near(e.robots.size()),
      staging_law(e.robots.size()),
      no_number(e.robots.size()),
      watch(e.robots.size(), rise_tolerance(e)),
      progress(e.robots.size()),
      outside(e.robots.size()),
      had_no_way(e.robots.size()),
      camera_watch(e.cameras(), core::CameraWatch(e.robots.size())),
      fusion(e.robots.size(), e.cameras(), e.estimation.filter, e.estimation.bridge) {
  const std::size_t n = e.robots.size();
  filters.resize(n);
  record.by_camera.resize(e.cameras() > 1 ? e.cameras() * n : 0);
  seen_or_missed.resize(n);
  held.resize(n);
  link_lost.resize(n);
  obedience.resize(n);
  stuck.resize(n);
  standing.reserve(obstacles.all().size() + n);
  off_nominal.resize(n);
  for (const RobotSpec& robot : e.robots) {
    const DrivenWheel wheel{core::ExpectedWheel(robot.motor)};
    wheels.push_back({wheel, wheel});
  }
  acts_at.resize(n, none);
  trust.resize(n, 1.0);
  driving.resize(n);
  poses.resize(n);
  midway.resize(n);
  stands.resize(n);
  nominal.resize(n);
  followed.resize(n);
  followed_twists.resize(n);
  law.resize(n);
  commands.resize(n);
  errors.resize(n);
  v_limits.resize(n);
  doubt.resize(n);
  out.resize(n);
  unseen.resize(n);
  covariance.resize(n);
  spare_log.resize(n * core::controller_type(e.controller.law.kind).logs.size());
  record.robots.resize(n);
  record.logged.resize(n * log_names(e.controller.law).size(), none);
  record.events.reserve(EventList::room_for(n));
  record.delta.resize(n > 0 ? n - 1 : 0);
  record.pair_gains = {gains.k_xx, gains.k_tt, gains.k_yy};
}

TickState::TickState(const Experiment& e)
    : TickSetup(e),
      TickMemory(e, make_gains(e), demand),
      planner(make_planner(e, *reference, clock, obstacles.all().size())),
      controller(core::controller_type(e.controller.law.kind).make(e.robots.size())),
      adrift(new bool[e.robots.size()]()),
      shield_touched(new bool[e.robots.size()]()) {
  question.poses = poses;
  question.covariance = covariance;
  question.twists = driving;
  question.nominal = nominal;
  question.reference = followed;
  question.reference_twists = followed_twists;
  question.errors = errors;
  question.out = out;
  question.gains = &gains;
  question.parameters = law_parameters.of_kind();
}

void ControlTick::go_on_from(const ControlTick& other) {
  TickState& tick = *state_;
  const TickState& from = *other.state_;
  tick.clock = from.clock;
  static_cast<TickMemory&>(tick) = from;
  if (tick.planner) tick.planner->go_on_from(*from.planner);
  std::copy_n(from.adrift.get(), from.robots(), tick.adrift.get());
  std::copy_n(from.shield_touched.get(), from.robots(), tick.shield_touched.get());
}

void ControlTick::see(const TickInput& input) noexcept {
  TickState& tick = *state_;
  tick.asked = false;
  tick.begin(input);
  tick.hear_links(input);
  tick.estimate(input);
}

const core::ControllerInput* ControlTick::ask() noexcept {
  TickState& tick = *state_;
  if (!tick.experiment.controller.law.own() || !tick.running()) return nullptr;
  tick.ask_law();
  return &tick.question;
}

const TickRecord& ControlTick::decide(const TickInput& input) noexcept {
  TickState& tick = *state_;
  tick.ask_law();
  tick.apply_law(input);
  tick.watch_descent();
  tick.limit_and_shield();
  tick.drive_wheels();
  tick.account(input);
  tick.watch_progress();
  if (tick.record.phase == Phase::staging) tick.watch_staging();
  return tick.record;
}

/// One robot's new measurements. A jump that was not announced is a perturbation like those of the file.
void TickState::accept_measurements(std::size_t i, const TickInput& input) noexcept {
  for (const std::size_t c : fusion.news(i, input.measurements)) {
    const core::Measurement& m = input.measurements[c * robots() + i];
    if (has_camera) camera_watch[c].see(i, filters[i], experiment.estimation.filter, fusion.newest(i, c), m);
    const core::CameraFusion::Outcome outcome = fusion.take(i, c, m, filters[i], record.now);
    if (outcome.disagreement && (moving() || record.phase == Phase::paused)) {
      note(events::CamerasDisagree{i, c, outcome.disagreement->other, outcome.disagreement->distance});
      stop_for_camera();
    }
    if (outcome.difference) note(events::CamerasDiffer{i, c, outcome.difference->other, outcome.difference->distance});
    if (outcome.expected && running())
      note(events::Kidnap{i, m.pose.x - outcome.expected->x, m.pose.y - outcome.expected->y,
                          core::wrap_angle(m.pose.theta - outcome.expected->theta)});
  }
}

/// A camera that was bumped makes every pose wrong at once: no robot may drive by them. Before a start robots are
/// placed by hand, and while the run is paused two of them may be carried.
void TickState::watch_cameras(const TickInput& input) noexcept {
  if (!has_camera || input.recorded) return;
  constexpr std::size_t least_driving = 2, least_paused = 3;
  for (std::size_t c = 0; c < cameras; ++c) {
    const std::optional<core::CommonMotion> motion = camera_watch[c].moved(moving() ? least_driving : least_paused);
    if (!motion || !(moving() || record.phase == Phase::paused)) continue;
    note(events::CameraMoved{cameras == 1 ? events::only_camera : c, motion->tags, motion->distance, motion->turn});
    stop_for_camera();
  }
}

/// Robots that drive by pictures that are older than their time stamps say meet where each of them is seen elsewhere.
void TickState::watch_delay(const TickInput& input) noexcept {
  if (!sees_commands || input.recorded || told_of_delay || !moving()) return;
  const std::size_t i = compared = (compared + 1) % robots();
  const core::ObedienceWatch& robot = obedience[i];
  if (robot.motion())  // of one that is lost there is none
    delay_watch.see(filters[i], robot.first_sight(), robot.newest_sight(), 0.5 * experiment.robots[i].drive.track);
  const std::optional<double> late = delay_watch.late();
  if (!late) return;
  told_of_delay = true;
  note(events::PicturesLate{*late});
  stop_for_camera();
}

void TickState::stop_for_camera() noexcept {
  if (experiment.failure.camera_moved == FailureSpec::CameraMoved::go_on) return;
  note(events::Stop{});
  record.phase = Phase::stopped;
}

/// What the links did with the previous tick's commands: prediction goes by what was sent, and a robot is trusted with
/// its speed as far as its link confirms that it obeys. Full speed for the first half of links.blind_distance, then
/// less and less.
void TickState::hear_links(const TickInput& input) noexcept {
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    robot.link.input = input.links.empty() ? LinkInput{} : input.links[i];
    const LinkInput& link = robot.link.input;
    trust[i] = 1.0;
    if (!link.linked) continue;
    const double budget = experiment.links.blind_distance;
    trust[i] = std::clamp(2.0 * (budget - link.blind_way) / budget, 0.0, 1.0);
    if (std::isnan(link.sent_at) || std::isnan(acts_at[i]) || link.sent == robot.wheels) continue;
    const core::MotorModel motor = experiment.robots[i].motor;
    filters[i].command(acts_at[i], experiment.robots[i].drive.twist({core::actual_step_rate(motor, link.sent.left),
                                                                     core::actual_step_rate(motor, link.sent.right)}));
  }
}

/// One that disobeys is commanded to stand until it does. One that is stuck is still commanded to drive, since
/// otherwise it could not be seen when it can drive again, and the others treat it as an obstacle.
void TickState::watch_obedience(std::size_t i) noexcept {
  core::ObedienceWatch& robot = obedience[i];
  const LinkInput& link = record.robots[i].link.input;
  const bool watched = experiment.failure.runaway != FailureSpec::Runaway::ignored;
  const bool changed = robot.see({.now = record.now,
                                  .to_wheel = 0.5 * experiment.robots[i].drive.track,
                                  .kidnap = experiment.estimation.filter.kidnap,
                                  .blind_way = link.linked ? link.blind_way : 0.0,
                                  .lost = record.robots[i].is(lost),
                                  .judged = watched && moving()},
                                 filters[i], fusion.fused(i));
  if (changed) note(robot.disobeys() ? Event(events::Runaway{i, robot.motion()->v}) : Event(events::Obeys{i}));
  stuck[i] = robot.stuck();
  if (stuck[i]) driving[i] = {};
  const bool by_itself = robot.disobeys() || (link.linked && is_out(i));
  adrift[i] = by_itself && robot.motion() && std::abs(robot.motion()->v) >= core::ObedienceWatch::too_slow;
  if (adrift[i]) driving[i] = *robot.motion();
}

/// Every robot's pose at the moment the command of this tick acts. One that has not been seen within the bridge time is
/// lost.
void TickState::estimate(const TickInput& input) noexcept {
  for (const Event& event : input.events)
    if (is<events::Perturb, events::Move, events::Kick>(event)) {
      if (!is<events::Kick>(event)) filters[*robot_of(event)].displaced(input.now);
      const double until = input.now + experiment.simulation.latency + core::SimulatedRobot::slides_for;
      obedience[*robot_of(event)].excuse(until);
      for (core::CameraWatch& of_camera : camera_watch) of_camera.excuse(*robot_of(event), until);
    }
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    const bool was_lost = robot.is(lost), was_known = filters[i].known();
    accept_measurements(i, input);
    robot.measurement = fusion.believed(i);
    robot.pose_age = input.now - robot.measurement.captured_at;
    const bool seen = robot.measurement.ever_seen();
    const auto& known = experiment.robots[i].actuation_delay;
    robot.actuation_delay =
        (known ? known : experiment.estimation.actuation_delay).value_or(input.delays.empty() ? 0.0 : input.delays[i]);
    robot.pose = poses[i] = seen ? filters[i].predict(input.now + robot.actuation_delay) : core::Pose{none, none, none};
    robot.sigma_xy = seen ? filters[i].sigma_xy() : none;
    robot.mode = robot.pose_age > experiment.estimation.bridge ? lost : 0;
    doubt[i] = seen ? core::trusted_deviations *
                          filters[i].sigma_after(experiment.estimation.filter, filters[i].way_to(input.now).driven)
                    : 0.0;
    // The first sight of a robot is expected and no event, unless the robot has been missed.
    if (seen_or_missed[i] && robot.is(lost) != was_lost)
      note(was_lost ? Event(events::Found{i}) : Event(events::Lost{i}));
    else if (!seen_or_missed[i] && !seen && running() && record.t > experiment.estimation.bridge)
      note(events::Lost{i}), seen_or_missed[i] = true;
    // The filter, which had nothing to go by, comes to believe the pose.
    if (seen && !was_known) explained_until = input.now + experiment.simulation.latency + settles;
    if (seen) seen_or_missed[i] = true;
    if (robot.is(lost)) avoidance.reset(i);
    driving[i] = commands[i];
    if (seen) watch_obedience(i);
  }
  std::copy_n(input.measurements.begin(), record.by_camera.size(), record.by_camera.begin());
  watch_cameras(input);
  watch_delay(input);
}

/// The coupling gains of this tick: the file's changes and the operator's, ramped.
void TickState::schedule_gains() noexcept {
  if (running()) couplings.follow_file(record.t, record.events);
  couplings.step(dt, gains);
}

/// The formation's reference, and what field or plan makes of it; then the tracking gains that these leave (36).
void TickState::follow_reference() noexcept {
  const bool staging = record.phase == Phase::staging;
  reference->at(staging ? 0.0 : record.t, nominal);
  if (!running())
    for (core::ReferencePoint& point : nominal) point.twist = {};
  if (!moving())
    std::copy(nominal.begin(), nominal.end(), followed.begin());
  else if (planner)
    follow_plan();
  else
    follow_field();
  for (std::size_t i = 0; moving() && i < robots(); ++i) {
    const bool modified = !on_nominal(i);
    if (modified != off_nominal[i] && running()) note(modified ? Event(events::Avoid{i}) : Event(events::Clear{i}));
    off_nominal[i] = modified;
  }
  for (std::size_t i = 0; i < robots(); ++i) followed_twists[i] = followed[i].twist;
  core::use_policy(gains, followed_twists);
}

/// Avoidance by (29)-(34), and detours.
void TickState::follow_field() noexcept {
  const double most_doubt = *std::max_element(doubt.begin(), doubt.end());
  const core::Scene scene{poses,
                          driving,
                          {shield_touched.get(), robots()},
                          obstacles.standing(),
                          experiment.shield.distance + 2.0 * most_doubt + detour_margin,
                          0.5 * experiment.arena_width - core::standard_radius,
                          0.5 * experiment.arena_height - core::standard_radius,
                          sizes};
  core::AvoidanceParameters parameters = experiment.avoidance;
  if (record.phase == Phase::staging) {
    parameters.enabled = true;
    parameters.horizon = std::max(parameters.horizon, staging_horizon);
  }
  avoidance.step(parameters, gains, motion_dt, scene, nominal, followed, fields);
  for (std::size_t i = 0; i < robots(); ++i)
    if (avoidance.stuck(i)) note(events::Deadlock{i});
}

/// Planned routes. A robot on a way of its own has no couplings: they are ramped, so that Theorem 1's gains stay
/// continuous, and what they leave goes to the route.
void TickState::follow_plan() noexcept {
  for (std::size_t i = 0; i < robots(); ++i) {
    out[i] = is_out(i);
    unseen[i] = out[i] && !made_to_stand(i);
  }
  const double hurry = experiment.avoidance.formation_waits ? core::FormationClock::hurry(gains, demand) : 0.0;
  const auto release = [&](core::PairTable& table) {
    if (table.none()) return;  // there is nothing to release
    for (std::size_t i = 0; i < robots(); ++i)
      for (std::size_t j = i + 1; j < robots(); ++j)
        if (const double share = planner->share(i) * planner->share(j); share < 1.0 && table(i, j) > 0.0)
          table.set(i, j, share * table(i, j));
  };
  release(gains.k_xx);
  release(gains.k_tt);
  release(gains.k_yy);
  // While staging the experiment's time stands still, and routes need one that goes on.
  const bool staging = record.phase == Phase::staging;
  staging_time = staging ? staging_time + motion_dt : 0.0;
  const core::Planner::Scene scene{staging ? staging_time : record.t,
                                   record.phase == Phase::staging,
                                   poses,
                                   driving,
                                   out,
                                   stuck,
                                   obstacles.standing(),
                                   *std::max_element(doubt.begin(), doubt.end()),
                                   hurry,
                                   unseen};
  planner->step(scene, gains, motion_dt, nominal, followed);
  for (std::size_t i = 0; i < robots(); ++i) {
    const std::size_t by = planner->taken_by(i);
    if (planner->no_way(i) && !had_no_way[i])
      note(by < robots() ? events::NoWay{i, by} : events::NoWay{i, events::nobody, planner->margin()});
    had_no_way[i] = planner->no_way(i);
  }
}

/// The gains, the reference and the errors (4) of this tick: all inputs of a law, once a tick. The error of a robot
/// that is lost or held counts as zero, which takes it out of the group: no robot is coupled to a guess, or waits for
/// one that stands.
void TickState::ask_law() noexcept {
  if (std::exchange(asked, true)) return;
  schedule_gains();
  follow_reference();
  for (std::size_t i = 0; i < robots(); ++i) {
    out[i] = is_out(i);
    errors[i] = out[i] ? core::TrackingError{} : core::tracking_error(followed[i].pose, poses[i]);
    covariance[i] = filters[i].covariance();
  }
  question.t = record.t;
  question.dt = dt;
  question.tick = record.tick;
  question.obstacles = obstacles.standing();
}

/// The law: (15), or what the experiment has instead. (15) drives the robots to their starts: other laws may not be
/// able to drive to a place and stand there. A robot stands if the law's command for it is not a number.
void TickState::apply_law(const TickInput& input) noexcept {
  const LawSpec& spec = experiment.controller.law;
  std::fill(record.logged.begin(), record.logged.end(), none);
  const auto number = [](const core::Twist& twist) {
    constexpr double most = 1e6;  // [m/s, rad/s]
    return std::abs(twist.v) <= most && std::abs(twist.omega) <= most;
  };
  if (!running()) {
    staging_law.step(question, law, {});
  } else if (!spec.own()) {
    controller->step(question, law, record.logged);
  } else {
    const bool helped = spec.failure == LawSpec::Failure::built_in;
    if (helped) controller->step(question, law, spare_log);
    for (std::size_t i = 0; i < robots(); ++i)
      if (i < input.law.size() && (number(input.law[i]) || !helped))
        law[i] = input.law[i];
      else if (!helped)
        law[i] = {none, none};
    std::copy_n(input.logged.begin(), std::min(input.logged.size(), record.logged.size()), record.logged.begin());
    if (input.controller != controller_state) note(events::Controller{input.controller});
    controller_state = input.controller;
  }
  for (std::size_t i = 0; i < robots(); ++i) {
    const bool bad = !number(law[i]);
    if (bad) law[i] = {none, none};
    if (bad && !no_number[i] && !is_out(i) && controller_state == ControllerState::answered) note(events::NoNumber{i});
    no_number[i] = bad;
  }
}

/// How much of its command a robot with a link may drive, 0 to 1: a robot out of radio contact cannot be stopped, so
/// its blind distance must last until a reply counts as lost. The speed of the reference itself is the experiment's
/// choice; a robot that is behind catches up no faster than this.
double TickState::blind_share(std::size_t i) const noexcept {
  if (!record.robots[i].link.input.linked) return 1.0;
  const core::DifferentialDrive& drive = experiment.robots[i].drive;
  const auto faster_wheel = [&](const core::Twist& twist) {
    return std::abs(twist.v) + 0.5 * drive.track * std::abs(twist.omega);
  };
  const double may =
      std::max(experiment.links.blind_distance / experiment.links.reply_timeout, faster_wheel(nominal[i].twist));
  const double wheel = faster_wheel(commands[i]);
  return wheel > may ? may / wheel : 1.0;
}

/// The law does not imply (14), and (14) not what the wheels can do; the shield has the last word.
void TickState::limit_and_shield() noexcept {
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    robot.limits = 0;
    if (!moving() || is_out(i) || no_number[i]) {
      robot.mode |= stopped;
      if (record.phase == Phase::staging && record.paused()) robot.mode |= staging;  // the CSV has no phase
      if (trust[i] < 1.0) robot.mode |= late;
      commands[i] = {};
      v_limits[i] = 0.0;
      if (!adrift[i]) continue;
      commands[i] = driving[i];  // for the shield; taken back below
      v_limits[i] = std::abs(driving[i].v);
      continue;
    }
    robot.mode |= !running() ? staging : followed[i] == nominal[i] ? tracking : avoiding;
    const core::CommandLimits::Biting biting = limits[i].biting(law[i]);
    robot.limits = static_cast<std::uint8_t>((biting.v ? limit_v : 0) | (biting.omega ? limit_omega : 0) |
                                             (biting.wheels ? limit_wheels : 0));
    commands[i] = limits[i].limit(law[i]);
    if (const double share = blind_share(i); share < 1.0) {
      commands[i] = {share * commands[i].v, share * commands[i].omega};
      robot.limits |= limit_link;
    }
    v_limits[i] = limits[i].v_limit(commands[i].omega);
    if (commands[i] != law[i]) robot.mode |= limited;
    if (trust[i] < 1.0) {
      robot.mode |= late;
      commands[i] = {trust[i] * commands[i].v, trust[i] * commands[i].omega};
    }
  }
  // A robot that turns drives, over a tick, as its heading in the middle of it.
  for (std::size_t i = 0; i < robots(); ++i) {
    midway[i] = poses[i];
    midway[i].theta += 0.5 * commands[i].omega * experiment.period();
  }
  // A robot that is stuck is an obstacle to all others, but not to itself, whose distance from it is 0.
  standing.assign(obstacles.standing().begin(), obstacles.standing().end());
  for (std::size_t i = 0; i < robots(); ++i)
    if (stuck[i]) standing.push_back({midway[i].x, midway[i].y, experiment.robots[i].radius + doubt[i]});
  shield.apply(shield_parameters,
               {.poses = midway,
                .obstacles = standing,
                .v_limit = v_limits,
                .doubt = doubt,
                .adrift = {adrift.get(), robots()},
                .sizes = sizes},
               commands, {shield_touched.get(), robots()});
  for (std::size_t i = 0; i < robots(); ++i) {
    if (shield_touched[i]) record.robots[i].mode |= shielded;
    if (adrift[i]) commands[i] = {};
  }
}

namespace {

/// What a wheel is told of which `wanted` is wanted [steps/s]: never to turn against that. It waits where it has rolled
/// too far.
double to_command(core::MotorModel motor, DrivenWheel& wheel, double wanted) noexcept {
  const double due = wanted + wheel.owed(wanted);
  return due * wanted > 0.0 ? core::nearest_command(motor, due) : 0.0;
}

}  // namespace

/// Twists to step rates. What one tick does too much or too little, the next ones make good.
void TickState::drive_wheels() noexcept {
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    const RobotSpec& spec = experiment.robots[i];
    const core::WheelSpeeds wanted = spec.drive.wheels(commands[i]);
    auto& [left, right] = wheels[i];
    if (robot.is(stopped)) left = {left.expected}, right = {right.expected};
    const core::WheelSpeeds before = robot.wheels;
    robot.wheels = {to_command(spec.motor, left, wanted.left), to_command(spec.motor, right, wanted.right)};
    const bool sent = robot.wheels != before;  // to both wheels, or to none
    const auto run = [&](DrivenWheel& wheel, double told, double wanted_of_it) {
      const double rate = wheel.expected.command(told, sent, record.period, experiment.period());
      if (spec.motor != core::MotorModel::ideal) wheel.owed(wanted_of_it) += wanted_of_it - rate;
      return rate;
    };
    const core::WheelSpeeds runs{run(left, robot.wheels.left, wanted.left),
                                 run(right, robot.wheels.right, wanted.right)};
    const double from = record.now + robot.actuation_delay;
    // Ticks in which nobody is driven are not all recorded: what follows must not depend on what links and robots did
    // then.
    filters[i].command(from, adrift[i] && moving() ? driving[i] : spec.drive.twist(runs));
    acts_at[i] = moving() ? from : none;
    watch.drives(i, is_out(i) ? core::Pose{none, none, none} : poses[i], spec.drive.twist(runs));
  }
}

namespace {

/// Whether V may rise after such an event: a hand moved a robot, or the group lost or gained one.
bool may_raise_v(const Event& event) noexcept {
  using namespace events;
  return std::visit(
      Overloaded{
          [](const one_of<Perturb, Kidnap, Move, Kick, Hold, Release, Lost, Found, Runaway, Obeys> auto&) {
            return true;
          },
          [](const one_of<Start, Pause, Resume, Stop, PutObstacle, Gain, Schedule, ScheduleTracking, GainHeld, PairGain,
                          PairGainHeld, Parameter, Couple, Uncouple, Avoid, Clear, events::Stage, Staged, Deadlock,
                          NoWay, NoProgress, Outside, DeadlineMissed, VRise, events::Link, CameraMoved, PicturesLate,
                          CamerasDisagree, CamerasDiffer, CameraLost, CameraFound, events::NotSeen, FilmBroken,
                          events::Controller, NoNumber> auto&) { return false; },
      },
      event);
}

}  // namespace

/// (20) forbids that V rises. Says where it does and nothing explains it: neither a hand nor a robot that was lost or
/// found (within the time in which the filter comes to believe the new pose).
void TickState::watch_descent() noexcept {
  for (const Event& event : record.events)
    if (may_raise_v(event)) explained_until = record.now + experiment.simulation.latency + settles;
  if (std::any_of(trust.begin(), trust.end(), [](double t) { return t < 1.0; })) explained_until = record.now + settles;
  if (!running() || record.now < explained_until || !experiment.controller.law.of_the_paper()) watch.forget();
  const double rise = watch.step(gains, poses, followed, errors, record.period);
  if (rise > 0.0) note(events::VRise{rise});
}

Hindrance TickState::hindrance(std::size_t i) const noexcept {
  const RobotRecord& robot = record.robots[i];
  if (robot.is(lost)) return Hindrance::lost;
  if (held[i]) return Hindrance::held;
  if (obedience[i].disobeys()) return Hindrance::runaway;
  if (outside[i]) return Hindrance::outside;
  if (planner && planner->no_way(i)) return Hindrance::no_way;
  if (planner && planner->waits_for(i) < robots()) return Hindrance::turn;
  if (robot.is(shielded)) return Hindrance::shield;
  if (robot.is(avoiding)) return Hindrance::avoidance;
  if (robot.is(limited)) return Hindrance::limits;
  return Hindrance::law;
}

/// Says who comes no nearer to its place, and whose body is over the edge of the arena.
void TickState::watch_progress() noexcept {
  for (const Event& event : record.events) {
    // One that is released has begun anew: what was said of it while it was held says nothing of what holds it up now.
    const bool anew = is<events::Perturb, events::Kidnap, events::Move, events::Kick, events::Release>(event);
    if (const auto robot = robot_of(event); anew && robot) progress.restart(*robot);
    if (is<events::Start>(event))
      for (std::size_t i = 0; i < robots(); ++i) progress.restart(i);
  }
  for (std::size_t i = 0; i < robots(); ++i) {
    const double over = std::max(std::abs(stands[i].x) - shield_parameters.half_width,
                                 std::abs(stands[i].y) - shield_parameters.half_height) +
                        experiment.robots[i].radius;
    if (over > 0.0 && !outside[i]) note(events::Outside{i, over});
    outside[i] = over > 0.0;
    const double away = core::distance(poses[i], nominal[i].pose);
    // Beside an obstacle on its lane a robot is abreast of its place, and nothing keeps it from it.
    if (planner && planner->state(i) == core::Planner::State::passing) progress.restart(i);
    const bool to_start = record.phase == Phase::staging, to_its_end = !to_start && ends[i];
    // Beside its route it is held up, and does not wait.
    const double from_wait = followed[i].twist == core::Twist{} ? core::distance(poses[i], followed[i].pose) : none;
    const core::ProgressWatch::Away how_far{away,
                                            to_its_end ? core::distance(poses[i], *ends[i]) : none,
                                            planner ? planner->time_left(i) : none,
                                            poses[i],
                                            from_wait,
                                            !to_start && !ends[i]};
    if (!moving() || std::isnan(away) || !progress.stuck(i, how_far, motion_dt)) continue;
    note(events::NoProgress{i, away, hindrance(i)});
  }
}

/// Everything that this tick did, for the log, the plots and the tests.
void TickState::account(const TickInput& input) noexcept {
  record.k_xx = gains.k_xx.largest();
  record.k_tt = gains.k_tt.largest();
  record.k_yy = gains.k_yy.largest();
  record.pair_gains[0] = gains.k_xx;  // same sizes: no allocation
  record.pair_gains[1] = gains.k_tt;
  record.pair_gains[2] = gains.k_yy;
  record.lag = clock.behind(record.t);
  record.planning = planner && moving() ? planner->nodes() : 0;
  record.V = core::lyapunov(gains, errors);
  record.V_dot = experiment.controller.law.of_the_paper() ? core::lyapunov_rate(gains, errors) : none;
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    robot.truth = input.truth.empty() ? core::Pose{none, none, none} : input.truth[i];
    robot.nominal = nominal[i];
    robot.reference = followed[i];
    robot.error = is_out(i) ? core::TrackingError{none, none, none} : errors[i];
    robot.law = law[i];
    robot.command = commands[i];
    robot.k_x = gains.k_x[i];
    robot.k_theta = gains.k_theta[i];
    robot.margins = core::margins(gains, i, followed_twists[i]);
  }
  for (std::size_t i = 0; i < robots(); ++i) {
    const RobotRecord& robot = record.robots[i];
    stands[i] = std::isnan(robot.truth.x) ? robot.pose : robot.truth;
  }
  record.min_distance = near.smallest_distance(stands);
  for (std::size_t i = 0; i + 1 < robots(); ++i)
    record.delta[i] = core::formation_error(nominal[i].pose, nominal[i + 1].pose, poses[i], poses[i + 1]);
}

ControlTick::ControlTick(const Experiment& experiment) : state_(std::make_unique<TickState>(experiment)) {}
ControlTick::~ControlTick() = default;

double ControlTick::next_time(int elapsed) const noexcept {
  const TickState& tick = *state_;
  return static_cast<double>(tick.record.tick + (tick.running() ? elapsed : 0)) / tick.experiment.rate;
}

const Couplings& ControlTick::couplings() const noexcept {
  return state_->couplings;
}

const core::CameraFusion::Comparison& ControlTick::compared(std::size_t first, std::size_t second) const noexcept {
  return state_->fusion.comparison(first, second);
}
const TickRecord& ControlTick::record() const noexcept {
  return state_->record;
}

}  // namespace skein::app
