#include "app/bench/radio_lap.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "app/record/statistics.h"
#include "app/session/link_watch.h"
#include "app/tick/control_tick.h"
#include "comms/asercom_session.h"
#include "comms/emulator/emulated_epuck.h"
#include "core/simulation/simulated_robot.h"

namespace skein::app {
namespace {

constexpr double look_every = 0.02;  // at the links' status [s]
constexpr double metres_per_step = 1.288e-4;

/// How far a wheel has rolled since the newest question that was answered had been sent. [m]
struct BlindWay {
  double way = 0.0, when_asked = 0.0, worst = 0.0;
  bool counted = false;

  /// `counts`: what follows counts.
  void add(double rolled, bool counts) noexcept {
    if (counted) way += rolled;
    counted = counts;
    if (!counted) forget();
    worst = std::max(worst, way);
  }
  void asked() noexcept { when_asked = way; }
  void confirmed() noexcept { way = std::max(0.0, way - when_asked); }
  void forget() noexcept { way = when_asked = 0.0; }
};

/// One robot: its place on the floor, its firmware, and the conversation with it.
class LappingRobot {
 public:
  LappingRobot(const Experiment& experiment, std::size_t i, const RadioLapOptions& options,
               comms::RadioAdapter& adapter)
      : options_(link_options(experiment)),
        session_(options_),
        firmware_(options.motors.value_or(motor(experiment, i)), 0.0, comms::faults_of(options.faults, i),
                  options.seed * 64 + i),
        floor_(experiment.robots[i].true_drive(), options.motors.value_or(motor(experiment, i)), experiment.simulation,
               experiment.seed, i) {
    firmware_.connect(adapter, i % comms::RadioAdapter::most_robots);
  }

  double deadline() const { return std::min(session_.open() ? session_.deadline() : again_at_, firmware_.deadline()); }

  void turn(double now) {
    firmware_.advance(now);
    judge(now);
    if (std::exchange(breaks_, firmware_.breaks()) != firmware_.breaks() && session_.open()) {
      session_.lost("the line hung up", now);
      again_at_ = now + options_.reconnect_first;
    }
    if (!session_.open() && now >= again_at_) {
      if (firmware_.connected())
        session_.opened(now);
      else
        again_at_ = now + options_.reconnect_first;
    }
    const auto heard = firmware_.take();
    if (session_.open()) session_.received(heard, now);
    confirm(now);
    session_.advance(now);
    write(now);
    const std::uint64_t told = firmware_.times_told();
    if (std::exchange(told_, told) != told) obey(now);
    judge(now);
  }
  void command(const core::WheelSpeeds& wheels, double now) {
    session_.command(comms::clamped(static_cast<int>(wheels.left), static_cast<int>(wheels.right)), ++ticket_, now);
    ++commands_;
    write(now);
    if (session_.written().ticket == ticket_) ++written_;
    turn(now);
  }
  void stop(double now) {
    session_.stop(now);
    turn(now);
  }
  void floor_to(double now) {
    if (now > floor_at_) floor_.step(now - floor_at_);
    floor_at_ = std::max(floor_at_, now);
  }
  LinkInput input(double now) const {
    LinkInput input{.linked = true, .blind_way = session_.blind_way(now)};
    if (!session_.up()) input.blind_way = std::max(input.blind_way, options_.blind_distance);
    if (session_.written().count == 0) return input;
    input.sent = {static_cast<double>(session_.written().speeds.left),
                  static_cast<double>(session_.written().speeds.right)};
    input.sent_at = written_at_;
    return input;
  }
  comms::LinkStatus status(double now) const {
    comms::LinkStatus status = session_.status(now);
    status.out_for = std::max(0.0, now - session_.out_since());
    return status;
  }
  core::SimulatedRobot& floor() { return floor_; }
  double share_written() const { return static_cast<double>(written_) / std::max(1.0, static_cast<double>(commands_)); }
  double blind_way() const { return blind_.worst; }
  double held_up_way() const { return blind_or_held_up_.worst; }

 private:
  static comms::LinkOptions link_options(const Experiment& experiment) {
    comms::LinkOptions options;
    options.blind_distance = experiment.links.blind_distance;
    options.reply_timeout = experiment.links.reply_timeout;
    options.command_silence = experiment.command_silence();
    options.heartbeat = 0.05;
    return options;
  }
  static core::MotorModel motor(const Experiment& experiment, std::size_t i) {
    const core::MotorModel own = experiment.robots[i].motor;
    switch (own) {
      case core::MotorModel::ideal:
        return core::MotorModel::epuck2;
      case core::MotorModel::epuck1:
      case core::MotorModel::epuck2:
      case core::MotorModel::servo:
        return own;
    }
    return own;
  }
  void write(double now) {
    while (session_.open() && !session_.output().empty()) {
      const std::vector<std::uint8_t> bytes(session_.output().begin(), session_.output().end());
      session_.sent(bytes.size(), now);
      written_at_ = now;
      // Longer: a stop.
      static const std::size_t speeds_alone = comms::wheel_request(comms::WheelCommand{}, comms::Question::none).size();
      if (bytes.size() != speeds_alone && bytes.size() <= comms::longest_request) for_both(&BlindWay::asked);
      firmware_.receive(bytes, now);
    }
  }
  void obey(double now) {
    floor_to(now);
    floor_.turn(firmware_.told());
  }
  /// How far its wheels have rolled since the host had its last proof, while nothing could lose a stop. That one is on
  /// its way slowly is no excuse, unless a fault holds it up: that is counted for itself.
  void judge(double now) {
    const double speed = metres_per_step * std::max(std::abs(rolling_.left), std::abs(rolling_.right));
    rolling_ = firmware_.wheels();
    const double way = speed * (now - judged_at_);
    judged_at_ = now;
    const bool able = session_.open() && !firmware_.loses();
    blind_.add(way, able && !firmware_.delays());
    blind_or_held_up_.add(way, able);
  }
  /// A question that was answered proves what was true when it was sent.
  void confirm(double now) {
    const std::uint64_t exchanges = session_.status(now).exchanges;
    if (std::exchange(exchanges_, exchanges) != exchanges) for_both(&BlindWay::confirmed);
    if (session_.stop_acknowledged()) for_both(&BlindWay::forget);
  }

  void for_both(void (BlindWay::*what)() noexcept) noexcept {
    (blind_.*what)();
    (blind_or_held_up_.*what)();
  }

  comms::LinkOptions options_;
  comms::AsercomSession session_;
  comms::EmulatedEpuck firmware_;
  core::SimulatedRobot floor_;
  double floor_at_ = 0.0, again_at_ = 0.0, written_at_ = 0.0;
  std::uint64_t breaks_ = 0, told_ = 0, commands_ = 0, written_ = 0, exchanges_ = 0;
  std::uint16_t ticket_ = 0;
  core::WheelSpeeds rolling_;
  double judged_at_ = 0.0;
  BlindWay blind_, blind_or_held_up_;
};

}  // namespace

RadioLap radio_lap(const Experiment& experiment, const RadioLapOptions& options) {
  const std::size_t n = experiment.robots.size();
  std::deque<comms::RadioAdapter> adapters;
  std::deque<LappingRobot> robots;
  const auto reference = make_reference(experiment);
  for (std::size_t i = 0; i < n; ++i) {
    if (i % comms::RadioAdapter::most_robots == 0) adapters.emplace_back(options.radio, options.seed * 64 + i);
    robots.emplace_back(experiment, i, options, adapters.back());
    robots.back().floor().place(experiment.robots[i].start.value_or(reference->at(i, 0.0).pose));
  }
  std::vector<std::size_t> everybody(n);
  for (std::size_t i = 0; i < n; ++i) everybody[i] = i;
  LinkWatch watch(everybody, experiment.failure.link_bridge, true);
  ControlTick tick(experiment);
  Statistics statistics(experiment);

  RadioLap lap;
  std::vector<core::Measurement> measured(n);
  std::vector<core::Pose> truth(n);
  std::vector<LinkInput> links(n);
  std::size_t next_perturbation = 0;
  std::uint64_t late_ticks = 0, ticks = 0;
  std::vector<double> squares(n);  // of x_e, once it is steady
  double steady_ticks = 0.0;
  // The links come up first, as in a session.
  constexpr double opening = 5.0;  // [s]
  bool started = false;
  std::int64_t k = 0;
  for (double now = 0.0, look_at = 0.0; now < opening + experiment.duration + 0.5 * experiment.period();) {
    const double tick_at = opening + static_cast<double>(k) * experiment.period();
    double next = std::min(tick_at, look_at);
    for (const LappingRobot& robot : robots) next = std::min(next, robot.deadline());
    now = std::max(now, next);
    for (LappingRobot& robot : robots) robot.turn(now);
    if (now >= look_at) {
      look_at += look_every;
      std::vector<comms::LinkStatus> status;
      status.reserve(robots.size());
      for (const LappingRobot& robot : robots) status.push_back(robot.status(now));
      if (auto lost = watch.update(status); lost && started && !lap.all_stop) {
        lap.all_stop = true;
        lap.why = *lost;
        if (experiment.failure.link_lost == FailureSpec::LinkLost::all_stop) {
          for (LappingRobot& robot : robots) robot.stop(now);
          break;
        }
      }
    }
    if (now < tick_at) continue;
    TickInput input;
    input.events.reserve(tick.record().events.limit());
    const double t = static_cast<double>(k) / experiment.rate;
    for (; next_perturbation < experiment.perturbations.size() &&
           experiment.perturbations[next_perturbation].t <= t + 0.5e-9;
         ++next_perturbation) {
      const Perturbation& p = experiment.perturbations[next_perturbation];
      core::SimulatedRobot& floor = robots[p.robot].floor();
      robots[p.robot].floor_to(now);
      const core::Pose& pose = floor.pose();
      floor.place({pose.x + p.dx, pose.y + p.dy, core::wrap_angle(pose.theta + p.dtheta)});
      input.events.add(events::Perturb{p.robot, p.dx, p.dy, p.dtheta});
    }
    for (std::size_t i = 0; i < n; ++i) {
      robots[i].floor_to(now);
      measured[i] = robots[i].floor().measure(now);
      truth[i] = robots[i].floor().pose();
      links[i] = robots[i].input(now);
    }
    const OperatorCommand start = commands::Start{};
    input.now = now;
    input.measurements = measured;
    input.truth = truth;
    input.links = links;
    if (!std::exchange(started, true)) input.commands = {&start, 1};
    const TickRecord& record = tick.step(input);
    if (record.phase == Phase::running) statistics.record(record);
    if (t >= experiment.duration - options.steady) {
      ++steady_ticks;
      for (std::size_t i = 0; i < n; ++i) {
        const double x_e = record.robots[i].error.x;
        squares[i] += x_e * x_e;
        lap.largest_x_e = std::fmax(lap.largest_x_e, std::abs(x_e));
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (record.phase == Phase::running) {
        late_ticks += record.robots[i].is(late) ? 1u : 0u;
        ++ticks;
      }
      robots[i].command(record.robots[i].wheels, now);
    }
    ++k;
  }
  for (const double sum : squares)
    lap.steady_x_e = std::fmax(lap.steady_x_e, std::sqrt(sum / std::max(1.0, steady_ticks)));
  const Statistics::Summary summary = statistics.summary();
  lap.perturbations = summary.perturbations.size();
  lap.final_error = summary.final_error;
  lap.min_distance = summary.min_distance;
  for (const PerturbationResult& p : summary.perturbations) lap.recovered += p.settling.tracking_1cm ? 1u : 0u;
  const double end = opening + experiment.duration;
  for (const LappingRobot& robot : robots) {
    const comms::LinkStatus status = robot.status(end);
    lap.rtt_median = std::max(lap.rtt_median, status.rtt_median);
    lap.rtt_p99 = std::max(lap.rtt_p99, status.rtt_p99);
    lap.rtt_p999 = std::max(lap.rtt_p999, status.rtt_p999);
    lap.written += robot.share_written() / static_cast<double>(n);
    lap.blind_stops += status.blind_stops;
    lap.timeouts += status.timeouts;
    lap.wrong_speeds += status.wrong_speeds;
    lap.blind_way = std::max(lap.blind_way, robot.blind_way());
    lap.held_up_way = std::max(lap.held_up_way, robot.held_up_way());
  }
  lap.late_ticks = static_cast<double>(late_ticks) / std::max(1.0, static_cast<double>(ticks));
  return lap;
}

}  // namespace skein::app
