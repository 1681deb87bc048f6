// The operator's commands to a session, or those of the program on their behalf.
#include <algorithm>

#include "app/session/session.h"
#include "app/session/session_wiring.h"

namespace skein::app {
namespace {

const std::string over = "the run is over", paused = "it is paused: resume it";

/// Why a start would change nothing in this phase; empty: it would.
std::string no_start(Phase phase, bool is_paused) {
  switch (phase) {
    case Phase::ready:
      return {};
    case Phase::staging:
      return is_paused ? paused : "the robots drive to their starts: the run can start when they stand there";
    case Phase::running:
      return "the run has started";
    case Phase::paused:
      return paused;
    case Phase::stopped:
    case Phase::finished:
      return over;
  }
  return {};
}
std::string no_staging(Phase phase, bool is_paused) {
  switch (phase) {
    case Phase::ready:
    case Phase::finished:
      return {};
    case Phase::staging:
      return is_paused ? paused : "the robots drive to their starts already";
    case Phase::running:
    case Phase::paused:
      return "the run has started";
    case Phase::stopped:
      return over;
  }
  return {};
}
std::string no_pause(Phase phase, bool is_paused) {
  switch (phase) {
    case Phase::ready:
      return "no robot drives";
    case Phase::staging:
    case Phase::running:
    case Phase::paused:
      return is_paused ? "it is paused" : "";
    case Phase::stopped:
    case Phase::finished:
      return over;
  }
  return {};
}
std::string no_resume(Phase phase, bool is_paused) {
  const bool is_over = phase == Phase::stopped || phase == Phase::finished;
  return is_paused ? "" : is_over ? over : "it is not paused";
}

}  // namespace

SessionWiring::Answer SessionWiring::ask_in_phase(const OperatorCommand& command, std::string (*why_not)(Phase, bool)) {
  std::string why = loop->has_obeyed_all() ? why_not(loop->phase(), loop->paused()) : std::string();
  if (why.empty() && loop->stop_asked()) why = over;
  return why.empty() ? ask(command) : Answer(tl::unexpected(std::move(why)));
}

Session::Answer Session::start() {
  if (auto may = wiring_->may_drive(); !may) return may;
  return wiring_->ask_in_phase(commands::Start{}, no_start);
}
Session::Answer Session::stage() {
  if (auto may = wiring_->may_drive(); !may) return may;
  return wiring_->ask_in_phase(commands::Stage{}, no_staging);
}
Session::Answer Session::pause() {
  return wiring_->ask_in_phase(commands::Pause{}, no_pause);
}
Session::Answer Session::resume() {
  return wiring_->ask_in_phase(commands::Resume{}, no_resume);
}
Session::Answer Session::step() {
  if (auto reason = real_time_reason(wiring_->experiment)) return tl::unexpected(*reason);
  wiring_->loop->step();
  return {};
}

Session::Answer Session::set_speed(double speed) {
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

Session::Answer Session::set_gain(core::GainName name, double value, double seconds) {
  return wiring_->ask(commands::SetGain{name, value, seconds});
}

Session::Answer Session::set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds) {
  if (auto pair = wiring_->check_pair(i, j); !pair) return pair;
  return wiring_->ask(commands::SetPairGain{i, j, name, value, seconds});
}

Session::Answer Session::couple(std::size_t i, std::size_t j, bool on) {
  if (auto pair = wiring_->check_pair(i, j); !pair) return pair;
  return wiring_->ask(commands::Couple{i, j, on});
}

const std::vector<LawParameter>& Session::law_parameters() const noexcept {
  return wiring_->law_parameters;
}

Session::Answer Session::set_parameter(std::string_view name, double value) {
  const auto& declared = wiring_->law_parameters;
  if (const std::string allowed = wrong_parameter(declared, name, value); !allowed.empty())
    return tl::unexpected(fmt::format("parameter {}: found {}, allowed: {}", name, value, allowed));
  if (!is_plain_name(name))
    return tl::unexpected(
        fmt::format("parameter {}: cannot be recorded, allowed: names of letters, digits and underscores", name));
  const auto found =
      std::find_if(declared.begin(), declared.end(), [&](const LawParameter& p) { return p.name == name; });
  return wiring_->ask(commands::SetParameter{ParameterName(name), found->value, value});
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

SessionWiring::Answer SessionWiring::check_pair(std::size_t i, std::size_t j) const {
  const std::size_t robots = experiment.robots.size();
  if (i < robots && j < robots && i != j) return {};
  return tl::unexpected(
      fmt::format("robots {} and {} are not a pair, allowed: two different robots from 1 to {}", i + 1, j + 1, robots));
}

core::CouplingGains SessionWiring::targets() const {
  const std::size_t n = experiment.robots.size();
  core::CouplingGains all{core::PairTable(n), core::PairTable(n), core::PairTable(n)};
  for (const core::GainName name : core::gain_names)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) core::table(all, name).set(i, j, loop->target(name, i, j));
  return all;
}

double Session::gain_limit(core::GainName name) const {
  return wiring_->gain_limit(name, wiring_->demand);
}

double Session::gain_limit(core::GainName name, const TickRecord& now) const {
  core::ReferenceDemand demand;
  for (const RobotRecord& robot : now.robots) {
    const double v = std::abs(robot.nominal.twist.v), omega = std::abs(robot.nominal.twist.omega);
    demand.v = std::max(demand.v, v);
    demand.turning = std::max(demand.turning, omega + wiring_->gains.k_y * v);
  }
  return wiring_->gain_limit(name, demand);
}
double Session::gain_limit(core::GainName name, std::size_t i, std::size_t j) const {
  return core::gain_limit(name, i, j, wiring_->gains, wiring_->targets(), wiring_->demand);
}

Session::Answer Session::move_robot(std::size_t robot, const core::Pose& pose) {
  if (robot >= wiring_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!wiring_->plant->simulated(robot))
    return tl::unexpected(fmt::format("robot {} is real: move it by hand", robot + 1));
  return wiring_->ask(events::Move{robot, pose});
}

Session::Answer Session::kick_robot(std::size_t robot, double vx, double vy) {
  if (robot >= wiring_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!wiring_->plant->simulated(robot))
    return tl::unexpected(fmt::format("robot {} is real: only simulated robots can be kicked", robot + 1));
  if (!std::isfinite(vx) || !std::isfinite(vy)) return tl::unexpected(std::string("a kick needs a velocity"));
  return wiring_->ask(events::Kick{robot, vx, vy});
}

Session::Answer Session::hold_robot(std::size_t robot, bool hold) {
  if (robot >= wiring_->experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  if (!hold)
    if (const RobotStatus status = robots()[robot]; !reachable(status.link))
      return tl::unexpected(fmt::format("robot {}: its link is {}", robot + 1, word(status.link)));
  return wiring_->ask(commands::Hold{robot, hold});
}

Session::Answer Session::check_wheels(std::size_t robot) {
  SessionWiring& impl = *wiring_;
  if (robot >= impl.experiment.robots.size()) return tl::unexpected(fmt::format("there is no robot {}", robot + 1));
  const std::string name = fmt::format("robot {}", robot + 1);
  if (!impl.experiment.robots[robot].has_link())
    return tl::unexpected(name + " is simulated: it has no link and no battery to test");
  if (!impl.clock.wall()) return tl::unexpected(std::string("robots are tested in real time"));
  if (impl.test.valid()) return tl::unexpected(std::string("one test at a time"));
  if (impl.loop->phase() != Phase::ready || impl.loop->stop_asked())
    return tl::unexpected(name + ": robots are tested before a start, while they stand ready");
  if (const RobotStatus status = robots()[robot]; status.link != LinkState::up)
    return tl::unexpected(fmt::format("{}: its link is {}", name, word(status.link)));
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
      const auto* const put = std::get_if<events::PutObstacle>(&a.event);
      return put && put->number == k;
    };
    const auto& actions = wiring_->experiment.actions;
    return all[k].radius > 0.0 || std::any_of(actions.begin(), actions.end(), will_be);
  };
  std::size_t number = 0;
  while (number < all.size() && taken(number)) ++number;
  if (number == all.size())
    return tl::unexpected(fmt::format("there are {} obstacles, and no more can be added", number));
  if (auto put = move_obstacle(number, obstacle); !put) return tl::unexpected(put.error());
  return number;
}

Session::Answer Session::move_obstacle(std::size_t number, const core::Obstacle& obstacle) {
  const Experiment& e = wiring_->experiment;
  const bool on_floor = std::abs(obstacle.x) <= e.arena_width / 2 && std::abs(obstacle.y) <= e.arena_height / 2;
  if (!on_floor) return tl::unexpected(std::string("an obstacle must be inside the arena"));
  if (!(obstacle.radius > 0.0 && obstacle.radius <= std::max(e.arena_width, e.arena_height)))
    return tl::unexpected(fmt::format("an obstacle cannot have a radius of {} m", obstacle.radius));
  return wiring_->put(number, obstacle);
}

Session::Answer Session::remove_obstacle(std::size_t number) {
  return wiring_->put(number, {});
}

std::span<const core::Obstacle> Session::obstacles() const noexcept {
  return wiring_->obstacles.all();
}

}  // namespace skein::app
