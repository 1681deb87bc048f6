#include "app/session/forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include "app/session/due.h"

namespace skein::app {
namespace {

constexpr double longest_answers = 5.0;  // of a second process, to all questions of a forecast [s]

bool same(double a, double b) noexcept {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// The session's clock at the next tick: on the virtual clock a multiple of the period, in a paced run a period later.
double next(double now, double period, double rate) noexcept {
  const double count = std::round(now * rate);
  return count / rate == now ? (count + 1.0) / rate : now + period;
}

}  // namespace

std::optional<std::string> Forecast::impossible(const Experiment& experiment) {
  if (experiment.controller.law.own() && !experiment.controller.law.preview)
    return "the run has a controller of its own, whose answers could change if it were asked about a future that never "
           "comes. controller.preview = true lets Skein start a second process of it";
  return {};
}

Forecast::Forecast(const Experiment& experiment)
    : experiment_(experiment),
      simulation_(!real_time_reason(experiment)),
      recorded_(experiment_),
      tick_(experiment_),
      ahead_(experiment_),
      world_(experiment_),
      floor_ahead_(experiment_),
      measurements_(experiment_.cameras() * experiment_.robots.size()),
      truth_(experiment_.robots.size()) {}

void Forecast::carry_out(const Event& event, SimulatedWorld& world) const {
  if (const auto* const move = std::get_if<events::Move>(&event)) world.place(move->robot, move->pose);
  if (const auto* const kick = std::get_if<events::Kick>(&event)) world.kick(kick->robot, kick->vx, kick->vy);
  if (const auto* const p = std::get_if<events::Perturb>(&event))
    world.place(p->robot, perturbed(world.pose(p->robot), *p));
}

void Forecast::follow(const TickRecord& record) {
  if (exact()) {
    // The first record has no tick before it; of the others the period tells whether one is missing.
    if (begun_ ? !same(record.now - last_.now, record.period) : !std::isnan(record.period)) complete_ = false;
    for (const Event& event : record.events) carry_out(event, world_);
    world_.advance(record.now);
    for (std::size_t i = 0; i < record.robots.size(); ++i) {
      world_.measure(i, record.now);  // draws the same noise
      const core::Pose here = world_.pose(i), there = record.robots[i].truth;
      complete_ = complete_ && same(here.x, there.x) && same(here.y, there.y) && same(here.theta, there.theta);
    }
  }
  for (const Event& event : record.events)
    if (is<events::Parameter>(event)) changed_.push_back(event);
  tick_.step(recorded_.of(record));
  if (exact())
    for (std::size_t i = 0; i < record.robots.size(); ++i) world_.command(i, record.robots[i].wheels);
  last_ = record;
  begun_ = true;
}

/// What happens by the file before the tick of time t, as ControlLoop does it.
void Forecast::perturb(double t, TickInput& input) {
  const bool running = may_act(experiment_, ahead_.record().phase, t);
  for (; running && next_perturbation_ < experiment_.perturbations.size(); ++next_perturbation_) {
    const Perturbation& p = experiment_.perturbations[next_perturbation_];
    if (!is_due(p.t, t)) break;
    if (!exact()) continue;  // the place from which the run will perturb it is not known yet
    input.events.add(events::Perturb{p.robot, p.dx, p.dy, p.dtheta});
    carry_out(events::Perturb{p.robot, p.dx, p.dy, p.dtheta}, floor_ahead_);
  }
  for (; running && next_action_ < experiment_.actions.size(); ++next_action_) {
    const OperatorAction& action = experiment_.actions[next_action_];
    if (!is_due(action.t, t)) break;
    if (const auto command = command_of(action.event)) {
      commands_.push_back(*command);
    } else if (exact()) {
      input.events.add(action.event);
      carry_out(action.event, floor_ahead_);
    }
  }
}

void Forecast::measure(double now) {
  if (exact()) {
    floor_ahead_.advance(now);
    for (std::size_t i = 0; i < truth_.size(); ++i) measurements_[i] = floor_ahead_.measure(i, now);
    floor_ahead_.poses(truth_);
    return;
  }
  std::fill(measurements_.begin(), measurements_.end(), core::Measurement{});
  for (std::size_t i = 0; i < truth_.size(); ++i) {
    models_[i].step(experiment_.period());
    truth_[i] = models_[i].pose();
    if (std::isnan(truth_[i].x)) continue;
    measurements_[i] = models_[i].measure(now);
  }
}

void Forecast::prepare(const std::function<bool()>& keep_on) {
  if (!experiment_.controller.law.own() || (second_ && !second_asked_)) return;
  rest();
  second_asked_ = false;
  failure_.clear();
  auto started =
      OwnController::start(experiment_, /*waits=*/true, {.for_preview = true, .prints = false, .keep_on = keep_on});
  if (started)
    second_ = std::move(*started);
  else if (!keep_on || keep_on())
    failure_ = started.error();
}

/// Between the two parts of a tick, as the run's own process is asked. False: it failed.
bool Forecast::ask_second(TickInput& input) {
  input.law = {};
  if (!second_) return true;
  second_->heed(ahead_.record().events);
  const core::ControllerInput* const question = ahead_.ask();
  if (!question) return true;
  second_asked_ = true;
  const auto began = std::chrono::steady_clock::now();
  second_->ask(*question);
  second_spent_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  input.law = second_->law();
  if (second_->state() == ControllerState::ended)
    failure_ = second_->why_it_ended();
  else if (second_->state() == ControllerState::late)
    failure_ = fmt::format("the controller has no answer within {:g} s", second_->report().deadline);
  else if (second_spent_ > longest_answers)
    failure_ = fmt::format("the controller takes more than {:g} s for its answers", longest_answers);
  return failure_.empty();
}

std::vector<TickRecord> Forecast::ahead(std::size_t ticks, std::span<const OperatorCommand> commands,
                                        const std::function<bool()>& keep_on) {
  const bool begins = last_.phase == Phase::ready, resumes = last_.phase == Phase::paused;
  if (!begun_ || !(begins || resumes || last_.phase == Phase::running)) return {};
  if (experiment_.controller.law.own()) {
    if (!second_ || second_asked_) return {};  // not prepared, or it failed
    second_->heed(changed_);
  }
  second_spent_ = 0.0;
  ahead_.go_on_from(tick_);
  if (exact()) {
    floor_ahead_.go_on_from(world_);
  } else {
    models_.clear();
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      const RobotSpec& spec = experiment_.robots[i];
      models_.emplace_back(spec.drive, spec.motor, core::Imperfection{}, experiment_.seed, i);
      models_.back().place(last_.robots[i].is(lost) ? core::Pose{none, none, none} : last_.robots[i].pose);
      models_.back().command(last_.robots[i].wheels);
    }
  }
  const auto done = [&](double t) { return last_.tick > 0 && is_due(t, last_.t); };
  next_perturbation_ =
      static_cast<std::size_t>(std::count_if(experiment_.perturbations.begin(), experiment_.perturbations.end(),
                                             [&](const Perturbation& p) { return done(p.t); }));
  next_action_ = static_cast<std::size_t>(
      std::count_if(experiment_.actions.begin(), experiment_.actions.end(),
                    [&](const OperatorAction& action) { return action.t <= 0.0 || done(action.t); }));

  std::vector<TickRecord> rows;
  TickInput input;
  input.events.reserve(EventList::room_for(experiment_.robots.size()));
  for (std::size_t k = 1; k <= ticks; ++k) {
    if (keep_on && !keep_on()) return {};
    input.now = next(k == 1 ? last_.now : input.now, experiment_.period(), experiment_.rate);
    input.events.clear();
    commands_.clear();
    perturb(ahead_.next_time(1), input);
    if (k == 1) {
      commands_.insert(commands_.end(), commands.begin(), commands.end());
      if (begins) commands_.emplace_back(commands::Start{});
      if (resumes) commands_.emplace_back(commands::Resume{});
    }
    measure(input.now);
    input.measurements = measurements_;
    input.truth = truth_;
    input.commands = commands_;
    ahead_.see(input);
    if (!ask_second(input)) {
      rest();
      return {};
    }
    const TickRecord& row = ahead_.decide(input);
    if (row.phase != Phase::running) break;
    rows.push_back(row);
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      if (exact())
        floor_ahead_.command(i, row.robots[i].wheels);
      else
        models_[i].command(row.robots[i].wheels);
    }
  }
  return rows;
}

}  // namespace skein::app
