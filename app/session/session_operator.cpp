// What the operator, or the program for them, asks of a session.
#include <algorithm>

#include "app/session/session.h"
#include "app/session/session_wiring.h"

namespace skein::app {
namespace {

constexpr double slowest = 0.1, fastest = 50.0;  // of a simulation, times real time

}  // namespace

void Session::start() {
  wiring_->loop->post({OperatorCommand::Kind::start});
}
void Session::stage() {
  wiring_->loop->post({OperatorCommand::Kind::stage, {}, 0.0});
}
void Session::pause() {
  wiring_->loop->post({OperatorCommand::Kind::pause});
}
void Session::resume() {
  wiring_->loop->post({OperatorCommand::Kind::resume});
}
tl::expected<void, std::string> Session::step() {
  if (auto reason = real_time_reason(wiring_->experiment)) return tl::unexpected(*reason);
  wiring_->loop->step();
  return {};
}

tl::expected<void, std::string> Session::set_speed(double speed) {
  if (auto reason = real_time_reason(wiring_->experiment)) return tl::unexpected(*reason);
  if (!(speed >= slowest && speed <= fastest))
    return tl::unexpected(fmt::format("speed: found {}, allowed: {} to {}", speed, slowest, fastest));
  wiring_->loop->set_speed(speed);
  return {};
}
double Session::speed() const noexcept {
  return wiring_->loop->speed();
}

void Session::stop() noexcept {
  wiring_->stop();
}

void Session::set_gain(core::GainName name, double value, double seconds) {
  OperatorCommand command{OperatorCommand::Kind::gain, name, value};
  command.seconds = seconds;
  wiring_->loop->post(command);
}

void Session::set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds) {
  OperatorCommand command{OperatorCommand::Kind::pair_gain, name, value, i, j};
  command.seconds = seconds;
  wiring_->loop->post(command);
}
void Session::couple(std::size_t i, std::size_t j, bool on) {
  wiring_->loop->post({on ? OperatorCommand::Kind::couple : OperatorCommand::Kind::uncouple, {}, 0.0, i, j});
}

double Session::gain(core::GainName name, std::size_t i, std::size_t j) const {
  return wiring_->loop->gain(name, i, j);
}
double Session::gain_target(core::GainName name, std::size_t i, std::size_t j) const {
  return wiring_->loop->target(name, i, j);
}
bool Session::coupled(std::size_t i, std::size_t j) const {
  return wiring_->loop->coupled(i, j);
}

core::CouplingGains SessionWiring::targets() const {
  const std::size_t n = experiment.robots.size();
  core::CouplingGains all{core::PairTable(n), core::PairTable(n), core::PairTable(n)};
  for (const core::GainName name : core::gain_names)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) core::table(all, name).set(i, j, loop->target(name, i, j));
  return all;
}

double Session::gain_border(core::GainName name) const {
  return wiring_->gain_border(name, wiring_->demand);
}

double Session::gain_border(core::GainName name, const TickRecord& now) const {
  core::ReferenceDemand demand;
  for (const RobotRecord& robot : now.robots) {
    const double v = std::abs(robot.nominal.twist.v), omega = std::abs(robot.nominal.twist.omega);
    demand.v = std::max(demand.v, v);
    demand.turning = std::max(demand.turning, omega + wiring_->gains.k_y * v);
  }
  return wiring_->gain_border(name, demand);
}
double Session::gain_border(core::GainName name, std::size_t i, std::size_t j) const {
  return core::gain_border(name, i, j, wiring_->gains, wiring_->targets(), wiring_->demand);
}

tl::expected<void, std::string> Session::move_robot(std::size_t robot, const core::Pose& pose) {
  if (robot >= wiring_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!wiring_->plant->simulated(robot))
    return tl::unexpected(fmt::format("robot {} is real: put it there by hand", robot + 1));
  if (!wiring_->loop->post_move(robot, pose)) return tl::unexpected(std::string("too many moves at once"));
  return {};
}

tl::expected<void, std::string> Session::kick_robot(std::size_t robot, double vx, double vy) {
  if (robot >= wiring_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!wiring_->plant->simulated(robot))
    return tl::unexpected(fmt::format("robot {} is real: only simulated ones are kicked", robot + 1));
  if (!std::isfinite(vx) || !std::isfinite(vy)) return tl::unexpected(std::string("a kick needs a velocity"));
  if (!wiring_->loop->post_kick(robot, vx, vy)) return tl::unexpected(std::string("too many kicks at once"));
  return {};
}

tl::expected<void, std::string> Session::hold_robot(std::size_t robot, bool hold) {
  if (robot >= wiring_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!hold)
    if (const RobotStatus status = robots()[robot]; status.link != "up" && status.link != "simulated")
      return tl::unexpected(fmt::format("robot {}: its link is {}", robot + 1, status.link));
  OperatorCommand command{hold ? OperatorCommand::Kind::hold : OperatorCommand::Kind::release};
  command.number = robot;
  if (!wiring_->loop->post(command)) return tl::unexpected(std::string("too much is asked at once"));
  return {};
}

tl::expected<void, std::string> Session::check_wheels(std::size_t robot) {
  SessionWiring& impl = *wiring_;
  if (robot >= impl.experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  const std::string name = fmt::format("robot {}", robot + 1);
  if (impl.experiment.robots[robot].link == RobotSpec::Link::sim)
    return tl::unexpected(name + " is simulated: it has neither a link nor a battery to test");
  if (!impl.clock.wall()) return tl::unexpected(std::string("robots are tested in real time"));
  if (impl.test.valid()) return tl::unexpected(std::string("one test at a time"));
  if (impl.loop->phase() != Phase::ready || impl.loop->stop_asked())
    return tl::unexpected(name + ": robots are tested before a start, while they stand ready");
  if (const RobotStatus status = robots()[robot]; status.link != "up")
    return tl::unexpected(fmt::format("{}: its link is {}", name, status.link));
  impl.test = std::async(std::launch::async, [&impl, robot, name]() -> tl::expected<WheelCheck, std::string> {
    auto check = impl.plant->check_wheels(robot, [&impl] { return impl.test_ends(); });
    if (!check) return tl::unexpected(fmt::format("{} could not be tested: {}", name, check.error()));
    check->robot = robot;
    return check;
  });
  return {};
}

std::optional<tl::expected<WheelCheck, std::string>> Session::wheel_check() {
  auto& test = wiring_->test;
  if (!test.valid() || test.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
  return test.get();
}

tl::expected<std::size_t, std::string> Session::add_obstacle(const core::Obstacle& obstacle) {
  const auto all = wiring_->obstacles.all();
  const auto taken = [&](std::size_t k) {
    const auto will_be = [k](const OperatorAction& a) {
      return a.event.kind == Event::Kind::obstacle && a.event.robot == static_cast<int>(k);
    };
    const auto& actions = wiring_->experiment.actions;
    return all[k].radius > 0.0 || std::any_of(actions.begin(), actions.end(), will_be);
  };
  std::size_t number = 0;
  while (number < all.size() && taken(number)) ++number;
  if (number == all.size()) return tl::unexpected(fmt::format("there are {} obstacles, no more can be added", number));
  if (auto put = move_obstacle(number, obstacle); !put) return tl::unexpected(put.error());
  return number;
}

tl::expected<void, std::string> Session::move_obstacle(std::size_t number, const core::Obstacle& obstacle) {
  const Experiment& e = wiring_->experiment;
  const bool on_floor = std::abs(obstacle.x) <= e.arena_width / 2 && std::abs(obstacle.y) <= e.arena_height / 2;
  if (!on_floor) return tl::unexpected(std::string("an obstacle stands inside the arena"));
  if (!(obstacle.radius > 0.0 && obstacle.radius <= std::max(e.arena_width, e.arena_height)))
    return tl::unexpected(fmt::format("an obstacle cannot have a radius of {} m", obstacle.radius));
  return wiring_->put(number, obstacle);
}

tl::expected<void, std::string> Session::remove_obstacle(std::size_t number) {
  return wiring_->put(number, {});
}

std::span<const core::Obstacle> Session::obstacles() const noexcept {
  return wiring_->obstacles.all();
}

}  // namespace skein::app
