#include "app/control_tick.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/control/coordination_law.h"
#include "core/control/formation.h"
#include "core/control/lyapunov.h"
#include "core/estimation/pose_filter.h"

namespace skein::app {
namespace {

/// An operator's change of a gain takes at least five seconds from nothing to all of the authority there is: Theorem 1
/// wants gains that are continuous, and a hand on a slider is not.
constexpr double operator_ramp = 5.0;

}  // namespace

struct ControlTick::State {
  explicit State(const Experiment& e);

  // The stages of a tick, in their order.
  void begin(const TickInput& input) noexcept;
  void obey(const OperatorCommand& command) noexcept;
  /// What was measured while nothing is recorded must not matter, or a run could not be repeated from its record.
  void forget_history() noexcept {
    for (core::PoseFilter& filter : filters) filter.forget();
  }
  void look(std::size_t i) noexcept;
  void estimate(const TickInput& input) noexcept;
  void schedule_gains() noexcept;
  void follow_reference() noexcept;
  void apply_law() noexcept;
  void limit_and_shield() noexcept;
  void drive_wheels() noexcept;
  void account(const TickInput& input) noexcept;

  bool running() const noexcept { return record.phase == Phase::running; }
  std::size_t robots() const noexcept { return record.robots.size(); }
  void note(Event::Kind kind, std::size_t robot) noexcept {
    record.events.add({kind, static_cast<int>(robot), {}, {}});
  }
  void note_gain(Event::Kind kind, core::GainName gain, double from, double to) noexcept {
    record.events.add({kind, -1, gain, {from, to, 0.0}});
  }

  // What the experiment says.
  const Experiment experiment;
  const std::unique_ptr<const core::Reference> reference;
  const core::ReferenceDemand demand;
  std::vector<core::CommandLimits> limits;

  // What lasts from tick to tick.
  double last_now = none;
  double dt = 0.0;  // of the experiment, since the tick before; 0 unless running
  std::size_t next_change = 0;
  core::Gains gains;
  core::GainSchedule schedule;
  std::array<bool, 3> changed_before_start{};
  core::Avoidance avoidance;
  core::Shield shield;
  core::LawPairs pairs;  // workspace of the law
  std::vector<core::PoseFilter> filters;
  std::vector<bool> seen_before;
  std::vector<bool> off_nominal;        // follows a modified reference
  std::vector<core::WheelSpeeds> owed;  // what the motors' coarse step rates have left undone

  // What lasts for one tick.
  std::vector<core::Pose> poses, midway;
  std::vector<core::ReferencePoint> nominal, followed;
  std::vector<core::Twist> followed_twists, law, commands;
  std::vector<core::TrackingError> errors;
  std::vector<double> v_limits;
  std::unique_ptr<bool[]> shield_touched;
  TickRecord record;
};

ControlTick::State::State(const Experiment& e)
    : experiment(e),
      reference(make_reference(e)),
      demand(reference->demand(e.controller.k_y)),
      gains(make_gains(e)),
      schedule({gains.k_xx, gains.k_tt, gains.k_yy}),
      avoidance(e.robots.size()),
      shield(e.robots.size(), e.obstacles.size()),
      pairs(e.robots.size()),
      shield_touched(new bool[e.robots.size()]()) {
  const std::size_t n = e.robots.size();
  for (std::size_t i = 0; i < n; ++i) limits.push_back(make_limits(e, i));
  filters.resize(n);
  seen_before.resize(n);
  off_nominal.resize(n);
  owed.resize(n);
  poses.resize(n);
  midway.resize(n);
  nominal.resize(n);
  followed.resize(n);
  followed_twists.resize(n);
  law.resize(n);
  commands.resize(n);
  errors.resize(n);
  v_limits.resize(n);
  record.robots.resize(n);
  record.delta.resize(n > 0 ? n - 1 : 0);
}

void ControlTick::see(const TickInput& input) noexcept {
  State& tick = *state_;
  tick.begin(input);
  tick.estimate(input);
}

const TickRecord& ControlTick::decide(const TickInput& input) noexcept {
  State& tick = *state_;
  tick.schedule_gains();
  tick.follow_reference();
  tick.apply_law();
  tick.limit_and_shield();
  tick.drive_wheels();
  tick.account(input);
  return tick.record;
}

/// Phase and time: the experiment's clock counts ticks, and stands still unless the experiment runs.
void ControlTick::State::begin(const TickInput& input) noexcept {
  record.events = input.events;
  record.period = input.now - last_now;
  record.now = last_now = input.now;
  if (input.elapsed > 1)
    record.events.add({Event::Kind::deadline_missed, -1, {}, {static_cast<double>(input.elapsed - 1), 0.0, 0.0}});

  dt = 0.0;
  if (running()) {
    record.tick += input.elapsed;
    dt = input.elapsed * experiment.period();
  }
  for (const OperatorCommand& command : input.commands) obey(command);
  if (input.stop && record.phase != Phase::stopped && record.phase != Phase::finished) {
    record.events.add({Event::Kind::stop, -1, {}, {}});
    record.phase = Phase::stopped;
  }
  if (running() && record.tick >= experiment.ticks()) record.phase = Phase::finished;
  record.t = static_cast<double>(record.tick) / experiment.rate;
}

void ControlTick::State::obey(const OperatorCommand& command) noexcept {
  switch (command.kind) {
    case OperatorCommand::Kind::start:
      if (record.phase != Phase::ready) return;
      record.phase = Phase::running;
      // What was changed before the run began belongs into its record, or it could not be repeated from it.
      for (const core::GainName name : core::gain_names)
        if (changed_before_start[static_cast<std::size_t>(name)])
          note_gain(Event::Kind::gain, name, core::table(experiment.controller.gains, name).largest(),
                    core::table(schedule.target(), name).largest());
      record.events.add({Event::Kind::start, -1, {}, {}});
      forget_history();
      return;
    case OperatorCommand::Kind::pause:
      if (record.phase != Phase::running) return;
      record.phase = Phase::paused;
      record.events.add({Event::Kind::pause, -1, {}, {}});
      return;
    case OperatorCommand::Kind::resume:
      if (record.phase != Phase::paused) return;
      record.phase = Phase::running;
      record.events.add({Event::Kind::resume, -1, {}, {}});
      forget_history();
      return;
    case OperatorCommand::Kind::gain: {
      const double border = core::gain_border(command.gain, gains, schedule.target(), demand);
      const double value = std::clamp(command.value, 0.0, border);
      const double from = core::table(schedule.target(), command.gain).largest();
      if (command.value > border) note_gain(Event::Kind::gain_held, command.gain, command.value, value);
      if (value == from) return;
      if (record.phase == Phase::ready) {  // no motion yet that a jump could disturb
        schedule.move(command.gain, value, std::numeric_limits<double>::infinity());
        schedule.step(1.0);
        changed_before_start[static_cast<std::size_t>(command.gain)] = true;
        note_gain(Event::Kind::gain, command.gain, from, value);
        return;
      }
      const double authority = command.gain == core::GainName::k_xx ? gains.v_max[0] : gains.omega_max[0];
      const auto partners = static_cast<double>(std::max<std::size_t>(1, robots() - 1));
      schedule.move(command.gain, value, authority / partners / operator_ramp);
      note_gain(Event::Kind::gain, command.gain, from, value);
      return;
    }
  }
}

/// One robot's newest measurement. A jump that nobody announced is a perturbation like those of the file.
void ControlTick::State::look(std::size_t i) noexcept {
  const core::Measurement& m = record.robots[i].measurement;
  const std::optional<core::Pose> expected = filters[i].see(experiment.estimation.filter, m);
  if (!expected || !running()) return;
  record.events.add(
      {Event::Kind::kidnap,
       static_cast<int>(i),
       {},
       {m.pose.x - expected->x, m.pose.y - expected->y, core::wrap_angle(m.pose.theta - expected->theta)}});
}

/// Every robot's pose at the moment the command of this tick acts. One that has not been seen within the bridge time is
/// lost.
void ControlTick::State::estimate(const TickInput& input) noexcept {
  for (const Event& event : input.events)
    if (event.kind == Event::Kind::perturb || event.kind == Event::Kind::move)
      filters[static_cast<std::size_t>(event.robot)].displaced(input.now);
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    const bool was_lost = robot.is(lost);
    robot.measurement = input.measurements[i];
    robot.pose_age = input.now - robot.measurement.captured_at;
    const bool seen = robot.measurement.captured_at > core::Measurement{}.captured_at;
    robot.actuation_delay =
        experiment.estimation.actuation_delay.value_or(input.delays.empty() ? 0.0 : input.delays[i]);
    if (seen) look(i);
    robot.pose = poses[i] = seen ? filters[i].predict(input.now + robot.actuation_delay) : core::Pose{none, none, none};
    robot.sigma_xy = seen ? filters[i].sigma_xy() : none;
    robot.mode = robot.pose_age > experiment.estimation.bridge ? lost : 0;
    // One that has never been seen was not lost, and its first sight is what everybody expects.
    if (robot.is(lost) != was_lost && seen_before[i]) note(was_lost ? Event::Kind::found : Event::Kind::lost, i);
    if (seen) seen_before[i] = true;
    if (robot.is(lost)) avoidance.reset(i);
  }
}

/// The coupling gains of this tick: the file's changes and the operator's, ramped.
void ControlTick::State::schedule_gains() noexcept {
  for (; next_change < experiment.gain_changes.size(); ++next_change) {
    const GainChange& change = experiment.gain_changes[next_change];
    if (!running() || record.t < change.t) break;
    for (const core::GainName name : core::gain_names) {
      const std::optional<core::PairTable>& target = name == core::GainName::k_xx   ? change.k_xx
                                                     : name == core::GainName::k_tt ? change.k_tt
                                                                                    : change.k_yy;
      if (!target) continue;
      note_gain(Event::Kind::schedule, name, core::table(schedule.target(), name).largest(), target->largest());
      schedule.ramp(name, *target, change.ramp);
    }
  }
  schedule.step(dt);
  gains.k_xx = schedule.now().k_xx;
  gains.k_tt = schedule.now().k_tt;
  gains.k_yy = schedule.now().k_yy;
}

/// The formation's reference, and what avoidance (29-34) makes of it; then the tracking gains that these leave (36).
void ControlTick::State::follow_reference() noexcept {
  reference->at(record.t, nominal);
  if (running()) {
    avoidance.step(experiment.avoidance, gains, dt, poses, experiment.obstacles, nominal, followed);
    for (std::size_t i = 0; i < robots(); ++i) {
      const bool modified = avoidance.state(i) != core::Avoidance::State::nominal;
      if (modified != off_nominal[i]) note(modified ? Event::Kind::avoid : Event::Kind::clear, i);
      off_nominal[i] = modified;
    }
  } else {
    for (core::ReferencePoint& point : nominal) point.twist = {};
    std::copy(nominal.begin(), nominal.end(), followed.begin());
  }
  for (std::size_t i = 0; i < robots(); ++i) followed_twists[i] = followed[i].twist;
  core::use_all_authority(gains, followed_twists);
}

/// (4) and (15). A lost robot's error counts as zero, which takes it out of the group: nobody is coupled to a guess.
void ControlTick::State::apply_law() noexcept {
  for (std::size_t i = 0; i < robots(); ++i) {
    const bool is_lost = record.robots[i].is(lost);
    errors[i] = is_lost ? core::TrackingError{} : core::tracking_error(followed[i].pose, poses[i]);
  }
  core::coordination_law(gains, errors, followed_twists, law, pairs);
}

/// The law does not imply (14), and (14) not what the wheels can do; the shield has the last word.
void ControlTick::State::limit_and_shield() noexcept {
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    if (!running() || robot.is(lost)) {
      robot.mode |= stopped;
      commands[i] = {};
      v_limits[i] = 0.0;
      continue;
    }
    robot.mode |= followed[i] == nominal[i] ? tracking : avoiding;
    commands[i] = limits[i].limit(law[i]);
    v_limits[i] = limits[i].v_limit(commands[i].omega);
    if (commands[i] != law[i]) robot.mode |= limited;
  }
  // A robot that turns drives, over a tick, as its heading in the middle of it.
  for (std::size_t i = 0; i < robots(); ++i) {
    midway[i] = poses[i];
    midway[i].theta += 0.5 * commands[i].omega * experiment.period();
  }
  shield.apply(experiment.shield, midway, experiment.obstacles, v_limits, commands, {shield_touched.get(), robots()});
  for (std::size_t i = 0; i < robots(); ++i)
    if (shield_touched[i]) record.robots[i].mode |= shielded;
}

/// Twists to step rates. A real motor runs only some rates: what one tick does too much or too little, the next ones
/// make good.
void ControlTick::State::drive_wheels() noexcept {
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    const RobotSpec& spec = experiment.robots[i];
    const core::WheelSpeeds wanted = spec.drive.wheels(commands[i]);
    core::WheelSpeeds runs;
    const auto choose = [&](double wish, double& debt, double& command, double& actual) {
      command = core::nearest_command(spec.motor, wish + debt);
      actual = core::actual_step_rate(spec.motor, command);
      debt = spec.motor == core::MotorModel::ideal || robot.is(stopped) ? 0.0 : wish + debt - actual;
    };
    if (robot.is(stopped)) owed[i] = {};
    choose(wanted.left, owed[i].left, robot.wheels.left, runs.left);
    choose(wanted.right, owed[i].right, robot.wheels.right, runs.right);
    filters[i].command(record.now + robot.actuation_delay, spec.drive.twist(runs));
  }
}

/// Everything that this tick did, for the log, the plots and the tests.
void ControlTick::State::account(const TickInput& input) noexcept {
  record.k_xx = gains.k_xx.largest();
  record.k_tt = gains.k_tt.largest();
  record.k_yy = gains.k_yy.largest();
  record.V = core::lyapunov(gains, errors);
  record.V_dot = core::lyapunov_rate(gains, errors);
  record.min_distance = none;
  for (std::size_t i = 0; i < robots(); ++i) {
    RobotRecord& robot = record.robots[i];
    robot.truth = input.truth.empty() ? core::Pose{none, none, none} : input.truth[i];
    robot.nominal = nominal[i];
    robot.reference = followed[i];
    robot.error = robot.is(lost) ? core::TrackingError{none, none, none} : errors[i];
    robot.law = law[i];
    robot.command = commands[i];
    robot.k_x = gains.k_x[i];
    robot.k_theta = gains.k_theta[i];
    robot.margins = core::margins(gains, i, followed_twists[i]);
  }
  const auto stands = [&](const RobotRecord& r) { return std::isnan(r.truth.x) ? r.pose : r.truth; };
  for (std::size_t i = 0; i < robots(); ++i)
    for (std::size_t j = i + 1; j < robots(); ++j)
      record.min_distance =
          std::fmin(record.min_distance, core::distance(stands(record.robots[i]), stands(record.robots[j])));
  for (std::size_t i = 0; i + 1 < robots(); ++i)
    record.delta[i] = core::formation_error(nominal[i].pose, nominal[i + 1].pose, poses[i], poses[i + 1]);
}

ControlTick::ControlTick(const Experiment& experiment) : state_(std::make_unique<State>(experiment)) {}
ControlTick::~ControlTick() = default;

double ControlTick::next_time(int elapsed) const noexcept {
  const State& tick = *state_;
  return static_cast<double>(tick.record.tick + (tick.running() ? elapsed : 0)) / tick.experiment.rate;
}

double ControlTick::gain_target(core::GainName name) const noexcept {
  return core::table(state_->schedule.target(), name).largest();
}

const TickRecord& ControlTick::record() const noexcept {
  return state_->record;
}

}  // namespace skein::app
