#include "app/control_loop.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace skein::app {

ControlLoop::ControlLoop(const Experiment& experiment, SessionClock& clock, Plant& plant,
                         std::function<void(const TickRecord&)> report)
    : experiment_(experiment),
      clock_(clock),
      plant_(plant),
      report_(std::move(report)),
      tick_(experiment),
      out_(tick_.record()),
      newest_(experiment.robots.size()),
      truth_(experiment.robots.size(), core::Pose{none, none, none}),
      wheels_(experiment.robots.size()) {
  for (const core::GainName name : core::gain_names) targets_[static_cast<std::size_t>(name)] = tick_.gain_target(name);
}

void ControlLoop::cycle(double now, int elapsed) {
  TickInput input;
  perturb(elapsed, input.events);
  plant_.measure(now, newest_, truth_);

  std::size_t obeyed = 0;
  while (obeyed < obeyed_.size() && commands_.pop(obeyed_[obeyed])) ++obeyed;
  input.now = now;
  input.elapsed = elapsed;
  input.stop = stop_.load(std::memory_order_acquire);
  input.measurements = newest_;
  input.truth = truth_;
  input.commands = {obeyed_.data(), obeyed};

  const double began = clock_.now();
  const TickRecord& record = tick_.step(input);
  const double compute_time = clock_.now() - began;

  for (std::size_t i = 0; i < wheels_.size(); ++i) wheels_[i] = record.robots[i].wheels;
  plant_.act(wheels_);

  out_ = record;
  if (clock_.wall()) out_.compute_time = compute_time;
  for (const core::GainName name : core::gain_names)
    targets_[static_cast<std::size_t>(name)].store(tick_.gain_target(name), std::memory_order_relaxed);
  const auto unseen =
      std::find_if(record.robots.begin(), record.robots.end(), [](const RobotRecord& r) { return r.is(lost); });
  unseen_.store(unseen == record.robots.end() ? -1 : static_cast<int>(unseen - record.robots.begin()),
                std::memory_order_release);
  report_(out_);
  phase_.store(record.phase, std::memory_order_release);
}

/// What happens to the simulated robots before this tick looks at them: the file's perturbations and the operator's
/// hand.
void ControlLoop::perturb(int elapsed, EventList& events) {
  const double t = tick_.next_time(elapsed);
  const bool running = phase() == Phase::running;
  for (; running && next_perturbation_ < experiment_.perturbations.size(); ++next_perturbation_) {
    const Perturbation& p = experiment_.perturbations[next_perturbation_];
    // Half a nanosecond: t is a quotient, and the file's number a decimal.
    if (t < p.t - 0.5e-9) break;
    if (!plant_.simulated(p.robot)) continue;
    const core::Pose pose = plant_.pose(p.robot);
    plant_.move(p.robot, {pose.x + p.dx, pose.y + p.dy, core::wrap_angle(pose.theta + p.dtheta)});
    events.add({Event::Kind::perturb, static_cast<int>(p.robot), {}, {p.dx, p.dy, p.dtheta}});
  }
  for (Move move; moves_.pop(move);) {
    plant_.move(move.robot, move.pose);
    events.add({Event::Kind::move, static_cast<int>(move.robot), {}, {move.pose.x, move.pose.y, move.pose.theta}});
  }
}

void ControlLoop::cycle_virtual() {
  const double now = static_cast<double>(virtual_ticks_++) / experiment_.rate;
  clock_.set(now);
  cycle(now, 1);
}

void ControlLoop::start_thread() {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    try {
      thread(stop);
    } catch (const std::exception& error) {
      reason_ = fmt::format("the control thread failed: {}", error.what());
      failed_.store(true, std::memory_order_release);
      plant_.stop();
    }
  });
}

void ControlLoop::end_thread() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void ControlLoop::thread(const std::stop_token& stop) {
  // Real-time priority where the system grants it; without it the deadlines are kept as well as an ordinary thread can.
  sched_param priority{};
  priority.sched_priority = 20;
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);

  const double period = experiment_.period();
  double deadline = clock_.now() + period;
  int elapsed = 1;
  while (!stop.stop_requested()) {
    std::this_thread::sleep_until(clock_.at(deadline));
    cycle(clock_.now(), elapsed);
    // Absolute deadlines: lateness does not add up. Those that have passed by now are missed, and the next tick says
    // how many.
    elapsed = 1 + static_cast<int>(std::max(0.0, std::floor((clock_.now() - deadline) / period)));
    deadline += elapsed * period;
  }
}

}  // namespace skein::app
