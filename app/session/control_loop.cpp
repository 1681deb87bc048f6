#include "app/session/control_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "app/experiment/at_start.h"
#include "app/run/memory_lock.h"
#include "app/session/due.h"
#include "comms/watchdog.h"

namespace skein::app {
namespace {

constexpr double delay_share = 0.02;  // of a new delay in the mean: two seconds' worth of ticks

}  // namespace

ControlLoop::ControlLoop(const Experiment& experiment, SessionClock& clock, Plant& plant,
                         std::function<void(const TickRecord&)> report, OwnController* controller)
    : experiment_(experiment),
      clock_(clock),
      plant_(plant),
      report_(std::move(report)),
      controller_(controller),
      tick_(experiment),
      out_(tick_.record()),
      commands_(64 + EventList::room_for(experiment.robots.size())),
      hand_(64),
      newest_(experiment.cameras() * experiment.robots.size()),
      truth_(experiment.robots.size(), core::Pose{none, none, none}),
      wheels_(experiment.robots.size()),
      command_times_(experiment.robots.size()),
      links_(experiment.robots.size()),
      delays_(experiment.robots.size()),
      pairs_(new PairState[experiment.robots.size() * experiment.robots.size()]),
      compared_(new std::atomic<Compared>[experiment.cameras() * experiment.cameras()]()) {
  out_.events.reserve(tick_.record().events.limit());
  input_.events.reserve(tick_.record().events.limit());
  obeyed_.reserve(tick_.record().events.limit());
  publish_couplings();
}

void ControlLoop::publish_couplings() noexcept {
  const Couplings& couplings = tick_.couplings();
  const std::size_t n = experiment_.robots.size();
  for (const core::GainName name : core::gain_names) {
    const auto k = static_cast<std::size_t>(name);
    const core::PairTable &now = core::table(couplings.now(), name), &target = core::table(couplings.target(), name);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        if (i == j) continue;
        PairState& state = pairs_[pair(i, j)];
        state.now[k].store(now(i, j), std::memory_order_relaxed);
        state.target[k].store(target(i, j), std::memory_order_relaxed);
      }
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      if (i != j) pairs_[pair(i, j)].coupled.store(couplings.coupled(i, j), std::memory_order_relaxed);
}

void ControlLoop::publish_comparisons(double now) noexcept {
  constexpr double open_for = 1.0;  // a robot that is carried off leaves it open [s]
  const std::size_t n = experiment_.cameras();
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      const core::CameraFusion::Comparison& of = tick_.compared(a, b);
      compared_[a * n + b].store({static_cast<float>(of.apart), static_cast<std::uint16_t>(of.robot), of.compared,
                                  !of.compared && now - of.undecided_at < open_for},
                                 std::memory_order_release);
    }
}

std::vector<CameraPair> ControlLoop::camera_pairs() const {
  const std::size_t n = experiment_.cameras();
  std::vector<CameraPair> pairs;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      const Compared of = compared_[a * n + b].load(std::memory_order_acquire);
      pairs.push_back({a, b, of.compared, of.undecided, of.robot, of.apart});
    }
  return pairs;
}

void ControlLoop::cycle(double now, int elapsed) {
  TickInput& input = input_;
  input.events.clear();
  obeyed_.clear();
  perturb(elapsed, input.events);
  plant_.tell(input.events);
  complete_latency();
  const Latency tick_before = latency_;
  new_frame_ = plant_.measure(now, newest_, truth_, frame_);

  plant_.read_links(links_);
  take_commands(input.events);
  input.now = now;
  input.elapsed = elapsed;
  input.stop = stop_.load(std::memory_order_acquire);
  input.measurements = newest_;
  input.truth = truth_;
  input.delays = delays_;
  input.links = links_;
  input.commands = obeyed_;

  const double began = clock_.now();
  tick_.see(input);
  const double estimated = clock_.now();
  ask_controller();
  const TickRecord& record = tick_.decide(input);
  decided_at_ = clock_.now();

  heed_camera(record);
  for (std::size_t i = 0; i < wheels_.size(); ++i) wheels_[i] = record.robots[i].wheels;
  plant_.act(wheels_);
  if (clock_.wall() && record.phase == Phase::finished && phase() != Phase::finished) plant_.halt();

  out_ = record;
  plant_.fill_links(out_.robots);
  if (clock_.runs()) {
    out_.compute_time = decided_at_ - began;
    out_.latency = tick_before;
    latency_ = {};
    latency_[Stage::estimate] = estimated - began;
    latency_[Stage::law] = decided_at_ - estimated;
    if (new_frame_) {
      latency_[Stage::capture] = frame_.arrived_at - frame_.captured_at;
      latency_[Stage::dequeue] = frame_.grey_at - frame_.arrived_at;
      latency_[Stage::detect] = frame_.ready_at - frame_.grey_at;
      latency_[Stage::hand_over] = began - frame_.ready_at;
    }
  }
  publish_couplings();
  publish_comparisons(input.now);
  const auto unseen =
      std::find_if(record.robots.begin(), record.robots.end(), [](const RobotRecord& r) { return r.is(lost); });
  unseen_.store(unseen == record.robots.end() ? -1 : static_cast<int>(unseen - record.robots.begin()),
                std::memory_order_release);
  const StartTolerance tolerance = start_tolerance(experiment_.staging);
  away_.store(std::any_of(record.robots.begin(), record.robots.end(),
                          [&](const RobotRecord& r) { return !at_start(r.pose, r.nominal.pose, tolerance); }),
              std::memory_order_release);
  const auto is_behind = [](const RobotRecord& r) {
    return r.is(lost) || !at_start(r.pose, r.nominal.pose, staged_tolerance);
  };
  // A robot that stands is named first: the others may wait for it.
  auto behind = std::find_if(record.robots.begin(), record.robots.end(),
                             [&](const RobotRecord& r) { return is_behind(r) && r.is(stopped); });
  if (behind == record.robots.end()) behind = std::find_if(record.robots.begin(), record.robots.end(), is_behind);
  NotStaged not_staged;
  if (behind != record.robots.end())
    not_staged = {static_cast<std::int16_t>(behind - record.robots.begin()), behind->mode,
                  static_cast<float>(core::distance(behind->pose, behind->nominal.pose))};
  not_staged_.store(not_staged, std::memory_order_release);
  report_(out_);
  paused_.store(record.paused(), std::memory_order_release);
  phase_.store(record.phase, std::memory_order_release);
  obeyed_so_far_.store(taken_, std::memory_order_release);
}

/// The run's own controller has its turn between the two parts of the tick, and a deadline: the tick itself never
/// waits.
void ControlLoop::ask_controller() noexcept {
  input_.law = {};
  input_.logged = {};
  if (!controller_) return;
  controller_->heed(tick_.record().events);
  const core::ControllerInput* const question = tick_.ask();
  if (!question) return;
  controller_->ask(*question);
  input_.law = controller_->law();
  input_.logged = controller_->logged();
  input_.controller = controller_->state();
}

/// If the tick has stopped all robots because of a camera's wrong or late poses, so do the links.
void ControlLoop::heed_camera(const TickRecord& record) noexcept {
  if (record.phase != Phase::stopped || camera_moved_.load(std::memory_order_relaxed)) return;
  for (const Event& event : record.events)
    if (is<events::CameraMoved, events::CamerasDisagree, events::PicturesLate>(event)) {
      motion_ = event;
      camera_moved_.store(true, std::memory_order_release);
      stop();
      plant_.stop();
      return;
    }
}

/// The tick before this one: by now its commands are written and answered, or late.
void ControlLoop::complete_latency() noexcept {
  if (!clock_.wall() || std::isnan(decided_at_)) return;
  plant_.command_times(decided_at_, command_times_);
  double written_at = none, answered_at = none;
  bool first = true;
  for (std::size_t i = 0; i < command_times_.size(); ++i) {
    const double written = command_times_[i].written, answered = command_times_[i].answered;
    if (written == 0.0) continue;  // no link
    const auto last = [first](double a, double b) { return first ? b : a >= b || std::isnan(a) ? a : b; };
    written_at = last(written_at, written);
    answered_at = last(answered_at, answered);
    first = false;
    // Wheels obey when the command arrives: half of the way there and back.
    const double delay = 0.5 * (written + answered) - decided_at_;
    if (!std::isnan(delay)) delays_[i] += delays_[i] == 0.0 ? delay : delay_share * (delay - delays_[i]);
  }
  latency_[Stage::write] = written_at - decided_at_;
  latency_[Stage::acknowledge] = answered_at - written_at;
  if (new_frame_) latency_.total = written_at - frame_.arrived_at;
}

/// What happens to the simulated robots before this tick looks at them: the file's perturbations and the operator's
/// hand.
void ControlLoop::perturb(int elapsed, EventList& events) {
  const double t = tick_.next_time(elapsed);
  const bool running = may_act(experiment_, phase(), t);
  for (; running && next_perturbation_ < experiment_.perturbations.size(); ++next_perturbation_) {
    const Perturbation& p = experiment_.perturbations[next_perturbation_];
    if (!is_due(p.t, t)) break;
    if (!plant_.simulated(p.robot)) continue;
    plant_.move(p.robot, perturbed(plant_.pose(p.robot), p));
    events.add(events::Perturb{p.robot, p.dx, p.dy, p.dtheta});
  }
  do_actions(t, running, events);
  while (room_for_events(events) > 0 && hand_.read_available() > 0) {
    carry_out(hand_.front(), events);
    hand_.pop();
  }
}

void ControlLoop::carry_out(const Gesture& gesture, EventList& events) {
  std::visit(Overloaded{
                 [&](const events::Move& move) {
                   plant_.move(move.robot, move.pose);
                   events.add(move);
                 },
                 [&](const events::Kick& kick) {
                   plant_.kick(kick.robot, kick.vx, kick.vy);
                   events.add(kick);
                 },
             },
             gesture);
}

/// The file's actions that are due, as if the operator had commanded them; those of t = 0 while the robots still stand.
void ControlLoop::do_actions(double t, bool running, EventList& events) {
  const std::vector<OperatorAction>& actions = experiment_.actions;
  for (; next_action_ < actions.size() && room_for_events(events) > 0; ++next_action_) {
    const auto& [when, event] = actions[next_action_];
    if (when > 0.0 && (!running || !is_due(when, t))) return;
    if (const auto command = command_of(event))
      obeyed_.push_back(*command);
    else if (const auto* const move = std::get_if<events::Move>(&event))
      carry_out(*move, events);
    else if (const auto* const kick = std::get_if<events::Kick>(&event))
      carry_out(*kick, events);
  }
}

/// The most events that a tick can make of a command: what it does, and what (18) makes less of it.
std::size_t ControlLoop::most_events(const OperatorCommand& command) const noexcept {
  return std::visit(
      Overloaded{
          [&](const one_of<commands::Start, commands::Stage> auto&) {  // tell of everything that was changed before
            const std::size_t robots = experiment_.robots.size(), pairs = robots * (robots - 1) / 2;
            return 4 * pairs + robots + most_parameters + experiment_.obstacles.size() +
                   core::ObstacleField::room_for_more + 4;
          },
          [](const one_of<commands::Pause, commands::Resume, commands::PutObstacle, commands::Hold,
                          commands::SetParameter> auto&) { return std::size_t{1}; },
          [](const one_of<commands::SetGain, commands::SetPairGain> auto&) { return std::size_t{2}; },
          [](const commands::Couple& couple) { return couple.on ? 2 * core::gain_names.size() + 1 : std::size_t{1}; },
      },
      command);
}

/// How many more events may come of what is asked of this tick, beside those that the tick makes itself.
std::size_t ControlLoop::room_for_events(const EventList& events) const noexcept {
  const std::size_t own = 16 + 4 * experiment_.robots.size();
  std::size_t expected = own;
  for (const OperatorCommand& command : obeyed_) expected += most_events(command);
  return events.room() - std::min(events.room(), expected);
}

/// The operator's commands to this tick. A step is a resume (or the start) now and a pause at the tick that follows:
/// the record of it can be replayed like any other. What the tick's events have no room for waits for the next tick.
void ControlLoop::take_commands(const EventList& events) {
  const bool ends_step = std::exchange(stepping_, false);
  if (ends_step) obeyed_.push_back(commands::Pause{});
  std::size_t room = room_for_events(events);
  bool asked_more = false;
  while (commands_.read_available() > 0) {
    const OperatorCommand& next = commands_.front();
    const std::size_t takes = most_events(next);
    if (takes > room && !obeyed_.empty()) break;
    obeyed_.push_back(next);
    commands_.pop();
    ++taken_;
    room -= std::min(room, takes);
    asked_more = true;
  }
  const Phase now = phase();
  if (!ends_step && !asked_more && steps_.load(std::memory_order_acquire) > 0) {
    steps_.fetch_sub(1, std::memory_order_acq_rel);
    stepping_ = now == Phase::ready || now == Phase::paused;
    if (now == Phase::ready) obeyed_.push_back(commands::Start{});
    if (now == Phase::paused) obeyed_.push_back(commands::Resume{});
  }
}

void ControlLoop::cycle_virtual() {
  const double now = static_cast<double>(virtual_ticks_++) / experiment_.rate;
  clock_.set(now);
  cycle(now, 1);
}

void ControlLoop::start_thread() {
  constexpr double longest = 0.1;  // so that the end of a slow run does not wait for it [s]
  bare_ = std::make_unique<BareThread>(std::min(experiment_.period(), longest), control_priority);
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
  if (bare_) timing_.bare = bare_->end();
}

std::optional<Timing> ControlLoop::timing_so_far() {
  if (!ticks_.load(std::memory_order_acquire)) return {};
  late_.take();
  Timing timing;
  timing.tick = late_.value();
  if (bare_) timing.bare = bare_->so_far();
  timing.priority = timing_.priority;
  timing.no_priority = timing_.no_priority;
  timing.cpu_latency = timing_.cpu_latency;
  timing.no_cpu_latency = timing_.no_cpu_latency;
  timing.memory_locked = timing_.memory_locked;
  timing.no_memory_lock = timing_.no_memory_lock;
  return timing;
}

void ControlLoop::thread(const std::stop_token& stop) {
  // Real-time priority where the system grants it; without it the deadlines are kept as well as an ordinary thread can.
  timing_.no_priority = ask_for_priority(control_priority);
  timing_.priority = timing_.no_priority.empty() ? control_priority : 0;

  const double period = experiment_.period();
  const double patience = std::max(experiment_.command_silence(), 3.0 * period);
  const double longest_silence = std::max(0.3, patience), standstill = std::max(0.5, patience);  // [s]
  const bool real = std::any_of(experiment_.robots.begin(), experiment_.robots.end(),
                                [](const RobotSpec& robot) { return !robot.simulated(); });
  std::optional<CpuLatencyLimit> awake;
  std::optional<MemoryLock> memory;
  if (real_time_reason(experiment_) || controller_) {
    awake.emplace();
    timing_.cpu_latency = awake->granted();
    timing_.no_cpu_latency = awake->refused();
    memory.emplace();
    timing_.memory_locked = memory->granted();
    timing_.no_memory_lock = memory->refused();
  }
  comms::Heart heart(longest_silence);
  double cycled_at = clock_.now();
  TickTimer timer(period, clock_.now() + period);
  int elapsed = 1;
  auto last = std::chrono::steady_clock::now();
  while (!stop.stop_requested()) {
    if (paced_ || speed() != 1.0) {
      const double late = pace(last, stop);
      const double now = timer.window().latest;
      clock_.set(now);
      cycle(now, 1);
      if (speed() == 1.0) count_lateness(late);
      timer = TickTimer(period, now + period);
      elapsed = 1;
      continue;
    }
    clock_.run();
    const TickTimer::Window window = timer.window();
    if (controller_ && phase() == Phase::running) wake_controller(window);
    std::this_thread::sleep_until(clock_.at(window.earliest));
    if (window.latest > window.earliest) await_frame(window);
    const double woke = clock_.now();
    heart.beat();
    const double gap = clock_.now() - cycled_at - period;
    cycled_at += gap + period;
    if (real && gap > standstill && !stop_asked()) {
      stood_still_.store(gap, std::memory_order_release);
      this->stop();
      plant_.stop();
    }
    cycle(clock_.now(), elapsed);
    count_lateness(std::max(0.0, woke - window.due(frame_.ready_at)));
    if (new_frame_) timer.frame(frame_.captured_at, frame_.ready_at);
    // Deadlines that have passed by now are missed, and the next tick says how many.
    elapsed = timer.ticked(clock_.now());
  }
}

/// Of a tick at real-time speed. [s]
void ControlLoop::count_lateness(double late) noexcept {
  timing_.tick.add(late);
  late_.draft() = timing_.tick;
  late_.publish();
  ticks_.store(true, std::memory_order_release);
}

/// Sleeps, except for the moments around the time at which the frame is expected: then the tick begins when its poses
/// are there, not when this thread has been woken. Where there is no second processor, watching would only delay the
/// camera's thread.
void ControlLoop::await_frame(const TickTimer::Window& window) noexcept {
  constexpr double watch = 2e-4;  // to either side of `expected`: 1 % of a period at 25 Hz at most [s]
  if (several_processors_) {
    plant_.wait_for_frame(window.since, window.expected - watch);
    plant_.watch_for_frame(window.since, std::min(window.expected + watch, window.latest));
  }
  plant_.wait_for_frame(window.since, window.latest);
}

/// Shortly before the tick, so that it is awake when the question comes.
void ControlLoop::wake_controller(const TickTimer::Window& window) noexcept {
  const double soon = window.expected - OwnController::wake_lead;
  std::this_thread::sleep_until(clock_.at(std::min(soon, window.earliest)));
  if (soon > window.earliest) plant_.wait_for_frame(window.since, soon);
  controller_->wake();
}

/// Waits until a paced simulation's next tick is due, or the operator gives a command: at a tenth of real time the
/// response to a button must not wait for a tick. `last`: when the previous tick was due. The result: how late it is.
/// [s]
double ControlLoop::pace(std::chrono::steady_clock::time_point& last, const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  constexpr auto slice = std::chrono::milliseconds(10);
  constexpr auto most_behind = std::chrono::milliseconds(100);  // made good; what is more only makes the run slower
  while (true) {
    const auto due = last + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(experiment_.period() / speed()));
    const auto now = Clock::now();
    if (now >= due) {
      last = std::max(due, now - most_behind);
      return std::chrono::duration<double>(now - due).count();
    }
    if (stop.stop_requested() || asked()) {
      last = now;
      return 0.0;
    }
    std::this_thread::sleep_until(std::min(due, now + slice));
  }
}

bool ControlLoop::asked() const noexcept {
  const Phase now = phase();
  const bool over = now == Phase::stopped || now == Phase::finished;
  const bool steps = steps_.load(std::memory_order_acquire) > 0 && (now == Phase::ready || now == Phase::paused);
  return (stop_asked() && !over) || steps || commands_.read_available() > 0 || hand_.read_available() > 0;
}

}  // namespace skein::app
