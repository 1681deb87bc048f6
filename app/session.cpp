#include "app/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <thread>

#include "app/control_loop.h"
#include "app/plant.h"
#include "app/record_channel.h"
#include "app/safety_net.h"

namespace skein::app {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t channel_capacity =
    500;  // 20 s at 25 Hz: a disk or a window may hang that long before rows are lost
constexpr auto recorder_period = 20ms;
constexpr double first_sight_timeout = 10.0;  // a camera needs a second or two to open and to settle its exposure [s]

/// The rows of a run: its running ticks, and after the start whatever else something happened in (pause, stop).
bool belongs_to_run(const TickRecord& record, bool started) noexcept {
  const bool driving_back = record.phase == Phase::staging && record.tick > 0;
  return record.phase == Phase::running || (record.phase == Phase::staging && !driving_back) ||
         (started && !driving_back && !record.events.empty());
}

}  // namespace

/// Every arrow of a run: plant -> control loop -> channels -> recorder and window; operator -> queues -> control loop.
struct Session::Impl {
  Impl(const Experiment& e, Clock c, SessionOptions o)
      : experiment(e), options(std::move(o)), clock(c == Clock::wall), obstacles(e.obstacles) {}

  void publish(const TickRecord& record) {  // on the control thread
    if (clock.wall()) {
      recorder_channel->push(record);
      window_channel->push(record);
    } else {
      tell_sinks(record);
    }
  }

  void tell_sinks(const TickRecord& record) {
    if (belongs_to_run(record, started))
      for (RecordSink* sink : options.sinks) sink->record(record);
    started = started || record.phase == Phase::running || record.phase == Phase::staging;
  }

  void fail(std::string reason) {
    {
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::move(reason);
    }
    stop();
  }

  double gain_border(core::GainName name, const core::ReferenceDemand& of) const {
    return core::gain_border(name, gains, targets(), of);
  }

  tl::expected<void, std::string> put(std::size_t number, const core::Obstacle& obstacle) {
    if (number >= obstacles.all().size()) return tl::unexpected(fmt::format("there is no obstacle {}", number + 1));
    OperatorCommand command{OperatorCommand::Kind::obstacle};
    command.number = number;
    command.obstacle = obstacle;
    if (!loop->post(command)) return tl::unexpected(std::string("too much is asked at once"));
    obstacles.put(number, obstacle);
    return {};
  }

  void stop() noexcept {
    loop->stop();
    plant->stop();
  }

  /// Rows to the sinks, an eye on links and camera; a thread of its own, so that a slow disk delays nobody.
  void recorder(const std::stop_token& token) {
    while (true) {
      const bool last = token.stop_requested();
      try {
        recorder_channel->drain([this](const TickRecord& record) { tell_sinks(record); });
      } catch (const std::exception& error) {
        fail(fmt::format("the record of the run could not be kept: {}", error.what()));
        return;
      }
      if (last) return;
      watch();
      std::this_thread::sleep_for(recorder_period);
    }
  }

  void watch() {
    const Phase phase = loop->phase();
    if (loop->failed()) fail(loop->reason());
    if (phase == Phase::stopped || phase == Phase::finished) return;
    if (auto reason = plant->failure()) fail(*reason);
  }

  /// Where the couplings are going.
  core::CouplingGains targets() const;

  const Experiment experiment;
  SessionOptions options;
  SessionClock clock;
  core::ObstacleField obstacles;  // as the operator wants them
  core::Gains gains;
  core::ReferenceDemand demand;
  tl::expected<SafetyNet, std::string> net;
  std::unique_ptr<Plant> plant;
  std::unique_ptr<ControlLoop> loop;
  std::unique_ptr<RecordChannel> recorder_channel, window_channel;
  std::jthread recorder_thread;
  bool started = false;  // the sinks' thread's
  bool closed = false;
  mutable std::mutex failure_mutex;
  std::optional<std::string> failure;
};

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::~Session() {
  close();
}

tl::expected<std::unique_ptr<Session>, std::string> Session::open(const Experiment& experiment, Clock clock,
                                                                  SessionOptions options) {
  auto impl = std::make_unique<Impl>(experiment, clock, std::move(options));
  Impl& i = *impl;
  i.gains = make_gains(experiment);
  i.demand = make_reference(experiment)->demand(experiment.controller.k_y);

  if (i.options.guard) i.net = SafetyNet::spread(i.experiment);
  auto plant = Plant::open(i.experiment, i.clock, i.options);
  if (!plant) {
    if (i.net) i.net->done({});  // those that were reached have been stopped
    return tl::unexpected(plant.error());
  }
  i.plant = std::move(*plant);
  i.loop = std::make_unique<ControlLoop>(i.experiment, i.clock, *i.plant,
                                         [&i](const TickRecord& record) { i.publish(record); });
  if (i.clock.wall()) {
    i.recorder_channel = std::make_unique<RecordChannel>(channel_capacity, i.loop->prototype());
    i.window_channel = std::make_unique<RecordChannel>(channel_capacity, i.loop->prototype());
    i.recorder_thread = std::jthread([&i](const std::stop_token& token) { i.recorder(token); });
    i.loop->start_thread();
  }
  return std::unique_ptr<Session>(new Session(std::move(impl)));
}

const Experiment& Session::experiment() const noexcept {
  return impl_->experiment;
}

void Session::start() {
  impl_->loop->post({OperatorCommand::Kind::start});
}
void Session::stage() {
  impl_->loop->post({OperatorCommand::Kind::stage, {}, 0.0});
}
void Session::pause() {
  impl_->loop->post({OperatorCommand::Kind::pause});
}
void Session::resume() {
  impl_->loop->post({OperatorCommand::Kind::resume});
}
void Session::stop() noexcept {
  impl_->stop();
}

void Session::set_gain(core::GainName name, double value) {
  impl_->loop->post({OperatorCommand::Kind::gain, name, value});
}

void Session::set_gain(core::GainName name, std::size_t i, std::size_t j, double value) {
  impl_->loop->post({OperatorCommand::Kind::pair_gain, name, value, i, j});
}
void Session::couple(std::size_t i, std::size_t j, bool on) {
  impl_->loop->post({on ? OperatorCommand::Kind::couple : OperatorCommand::Kind::uncouple, {}, 0.0, i, j});
}

double Session::gain(core::GainName name, std::size_t i, std::size_t j) const {
  return impl_->loop->gain(name, i, j);
}
double Session::gain_target(core::GainName name, std::size_t i, std::size_t j) const {
  return impl_->loop->target(name, i, j);
}
bool Session::coupled(std::size_t i, std::size_t j) const {
  return impl_->loop->coupled(i, j);
}

core::CouplingGains Session::Impl::targets() const {
  const std::size_t n = experiment.robots.size();
  core::CouplingGains all{core::PairTable(n), core::PairTable(n), core::PairTable(n)};
  for (const core::GainName name : core::gain_names)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) core::table(all, name).set(i, j, loop->target(name, i, j));
  return all;
}

double Session::gain_border(core::GainName name) const {
  return impl_->gain_border(name, impl_->demand);
}

double Session::gain_border(core::GainName name, const TickRecord& now) const {
  core::ReferenceDemand demand;
  for (const RobotRecord& robot : now.robots) {
    const double v = std::abs(robot.nominal.twist.v), omega = std::abs(robot.nominal.twist.omega);
    demand.v = std::max(demand.v, v);
    demand.turning = std::max(demand.turning, omega + impl_->gains.k_y * v);
  }
  return impl_->gain_border(name, demand);
}
double Session::gain_border(core::GainName name, std::size_t i, std::size_t j) const {
  return core::gain_border(name, i, j, impl_->gains, impl_->targets(), impl_->demand);
}

tl::expected<void, std::string> Session::move_robot(std::size_t robot, const core::Pose& pose) {
  if (robot >= impl_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!impl_->plant->simulated(robot))
    return tl::unexpected(fmt::format("robot {} is real: put it there by hand", robot + 1));
  if (!impl_->loop->post_move(robot, pose)) return tl::unexpected(std::string("too many moves at once"));
  return {};
}

tl::expected<void, std::string> Session::kick_robot(std::size_t robot, double vx, double vy) {
  if (robot >= impl_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!impl_->plant->simulated(robot))
    return tl::unexpected(fmt::format("robot {} is real: only simulated ones are kicked", robot + 1));
  if (!std::isfinite(vx) || !std::isfinite(vy)) return tl::unexpected(std::string("a kick needs a velocity"));
  if (!impl_->loop->post_kick(robot, vx, vy)) return tl::unexpected(std::string("too many kicks at once"));
  return {};
}

tl::expected<void, std::string> Session::hold_robot(std::size_t robot, bool hold) {
  if (robot >= impl_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!hold)
    if (const RobotStatus status = robots()[robot]; status.link != "up" && status.link != "simulated")
      return tl::unexpected(fmt::format("robot {}: its link is {}", robot + 1, status.link));
  OperatorCommand command{hold ? OperatorCommand::Kind::hold : OperatorCommand::Kind::release};
  command.number = robot;
  if (!impl_->loop->post(command)) return tl::unexpected(std::string("too much is asked at once"));
  return {};
}

tl::expected<std::size_t, std::string> Session::add_obstacle(const core::Obstacle& obstacle) {
  const std::size_t number = impl_->obstacles.free();
  if (number == impl_->obstacles.all().size())
    return tl::unexpected(fmt::format("there are {} obstacles, no more can be added", number));
  if (auto put = move_obstacle(number, obstacle); !put) return tl::unexpected(put.error());
  return number;
}

tl::expected<void, std::string> Session::move_obstacle(std::size_t number, const core::Obstacle& obstacle) {
  const Experiment& e = impl_->experiment;
  const bool on_floor = std::abs(obstacle.x) <= e.arena_width / 2 && std::abs(obstacle.y) <= e.arena_height / 2;
  if (!on_floor) return tl::unexpected(std::string("an obstacle stands inside the arena"));
  if (!(obstacle.radius > 0.0 && obstacle.radius <= std::max(e.arena_width, e.arena_height)))
    return tl::unexpected(fmt::format("an obstacle cannot have a radius of {} m", obstacle.radius));
  return impl_->put(number, obstacle);
}

tl::expected<void, std::string> Session::remove_obstacle(std::size_t number) {
  return impl_->put(number, {});
}

std::span<const core::Obstacle> Session::obstacles() const noexcept {
  return impl_->obstacles.all();
}

std::size_t Session::drain(const std::function<void(const TickRecord&)>& take) {
  return impl_->window_channel ? impl_->window_channel->drain(take) : 0;
}

std::uint64_t Session::dropped_rows() const noexcept {
  return impl_->recorder_channel ? impl_->recorder_channel->dropped() : 0;
}

std::uint64_t Session::undrained_rows() const noexcept {
  return impl_->window_channel ? impl_->window_channel->dropped() : 0;
}

bool Session::picture(Picture& out) {
  return has_camera() && !impl_->closed && impl_->plant->camera()->picture(out);
}
bool Session::has_camera() const noexcept {
  return impl_->experiment.camera.source != "none";
}

std::array<double, 2> Session::pixel(double x, double y) const {
  const CameraRig* camera = impl_->plant->camera();
  return camera ? camera->pixel(x, y) : std::array{none, none};
}

std::vector<RobotStatus> Session::robots() const {
  return impl_->plant->robots();
}

VideoStatus Session::video() const {
  const CameraRig* camera = impl_->plant->camera();
  return camera ? camera->video() : VideoStatus{};
}

std::optional<std::string> Session::unguarded() const {
  return impl_->net ? std::nullopt : std::optional(impl_->net.error());
}

std::optional<std::string> Session::failure() const {
  const std::lock_guard lock(impl_->failure_mutex);
  return impl_->failure;
}

Phase Session::run(const std::function<bool()>& keep_on) {
  Impl& i = *impl_;
  const auto over = [&] { return i.loop->phase() == Phase::stopped || i.loop->phase() == Phase::finished; };
  const auto ask = [&] {
    if (keep_on && !keep_on()) i.stop();
  };
  int turns = 0;
  const auto turn = [&] {
    constexpr int between_questions = 16;  // ticks: a fraction of a second even where a camera is rendered
    if (i.clock.wall() || turns++ % between_questions == 0) ask();
    if (i.clock.wall()) {
      std::this_thread::sleep_for(5ms);
    } else {
      i.loop->cycle_virtual();
      i.watch();
    }
  };
  const auto drive_to_starts = [&] {
    stage();
    const double give_up = i.clock.now() + i.experiment.staging.timeout;
    for (bool began = false; !i.loop->failed() && i.loop->phase() != Phase::stopped; turn()) {
      if (i.loop->phase() == Phase::staging)
        began = true;
      else if (began)
        return;
      if (i.clock.now() < give_up) continue;
      i.fail(fmt::format("staging: not everybody has reached its start within {} s", i.experiment.staging.timeout));
      while (!over() && !i.loop->failed()) turn();
    }
  };

  bool away = false;
  if (i.clock.wall()) {
    // Nobody drives blind: every robot has to be seen before the start.
    const double give_up = i.clock.now() + first_sight_timeout;
    for (int unseen = 0; (unseen = i.loop->unseen()) >= 0 && !over() && !i.loop->failed(); turn()) {
      if (i.clock.now() < give_up) continue;
      i.fail(fmt::format("robot {}: its tag {} is not seen", unseen + 1,
                         i.experiment.robots[static_cast<std::size_t>(unseen)].tag));
      break;
    }
    away = i.loop->away();
  } else {  // simulated robots stand at their starts, unless the file puts them elsewhere
    away = std::any_of(i.experiment.robots.begin(), i.experiment.robots.end(),
                       [](const RobotSpec& robot) { return robot.start.has_value(); });
  }
  if (away && i.experiment.staging.automatic && !over()) drive_to_starts();
  start();
  while (!over() && !i.loop->failed()) turn();
  if (i.experiment.staging.back && i.loop->phase() == Phase::finished) drive_to_starts();
  return i.loop->phase();
}

void Session::close() {
  Impl& i = *impl_;
  if (i.closed) return;
  i.closed = true;
  i.stop();
  i.loop->end_thread();
  i.plant->close();
  if (i.net) i.net->done(i.plant->robots());
  if (i.recorder_thread.joinable()) {
    i.recorder_thread.request_stop();
    i.recorder_thread.join();
  }
}

}  // namespace skein::app
