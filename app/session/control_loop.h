#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "app/controllers/own_controller.h"
#include "app/run/session_clock.h"
#include "app/run/status.h"
#include "app/run/timing.h"
#include "app/session/bare_thread.h"
#include "app/session/newest.h"
#include "app/session/plant.h"
#include "app/session/tick_timer.h"
#include "app/tick/control_tick.h"

namespace skein::app {

/// Runs the tick: measure, tick, act, report, 25 times per second or as fast as possible on the virtual clock. The same
/// `cycle` in both.
class ControlLoop {
 public:
  /// `report` gets every record on the control thread; it must neither block nor allocate on the wall clock.
  /// `controller`: the run's own, if it has one.
  ControlLoop(const Experiment& experiment, SessionClock& clock, Plant& plant,
              std::function<void(const TickRecord&)> report, OwnController* controller = nullptr);

  // --- any one controlling thread ---
  /// Moves a simulated robot, as by hand.
  using Gesture = std::variant<events::Move, events::Kick>;

  /// Queues a command for the next ticks, in order. False: the queue is full, and the command is not executed. There is
  /// room for everything that can be set at once: every gain and every coupling of each pair.
  [[nodiscard]] bool post(const OperatorCommand& command) {
    const bool queued = commands_.push(command);
    posted_ += queued ? 1 : 0;
    return queued;
  }
  [[nodiscard]] bool post(const Gesture& gesture) { return hand_.push(gesture); }
  /// From ready or paused: one tick of the experiment, and paused again.
  void step() noexcept { steps_.fetch_add(1, std::memory_order_acq_rel); }
  /// Before start_thread: a simulation is paced at speed 1 as well.
  void always_pace() noexcept { paced_ = true; }
  /// Wall clock: how much faster than real time a simulation runs. At any speed but 1 it is paced: every tick runs at
  /// exactly its time, none is skipped, and a late one delays the rest. Not with links or cameras, which run in real
  /// time.
  void set_speed(double speed) noexcept { speed_.store(speed, std::memory_order_release); }
  double speed() const noexcept { return speed_.load(std::memory_order_acquire); }
  /// Any thread: STOP, latched.
  void stop() noexcept { stop_.store(true, std::memory_order_release); }
  bool stop_asked() const noexcept { return stop_.load(std::memory_order_acquire); }

  /// Wall clock: runs cycles at absolute deadlines until told to end. An exception in it causes a stop and a failure.
  void start_thread();
  void end_thread();
  /// Virtual clock: one tick.
  void cycle_virtual();

  Phase phase() const noexcept { return phase_.load(std::memory_order_acquire); }
  /// Whether the robots stand in the middle of it until it is resumed.
  bool paused() const noexcept { return paused_.load(std::memory_order_acquire); }
  /// Whether every queued command has been executed, so that `phase` is what came of them. The controlling thread's.
  bool has_obeyed_all() const noexcept { return obeyed_so_far_.load(std::memory_order_acquire) == posted_; }
  /// The first robot without a known pose, from 0; -1: all are known.
  int unseen() const noexcept { return unseen_.load(std::memory_order_acquire); }
  /// The couplings of the latest tick: their present gains, where these are going, and which pairs are switched off.
  double gain(core::GainName name, std::size_t i, std::size_t j) const noexcept {
    return pairs_[pair(i, j)].now[static_cast<std::size_t>(name)].load(std::memory_order_relaxed);
  }
  double target(core::GainName name, std::size_t i, std::size_t j) const noexcept {
    return pairs_[pair(i, j)].target[static_cast<std::size_t>(name)].load(std::memory_order_relaxed);
  }
  bool coupled(std::size_t i, std::size_t j) const noexcept {
    return pairs_[pair(i, j)].coupled.load(std::memory_order_relaxed);
  }
  /// Whether some robot whose pose is known is not at its start.
  bool away() const noexcept { return away_.load(std::memory_order_acquire); }
  /// A robot that is not yet at its start within the tolerance of staging.
  struct NotStaged {
    std::int16_t robot = -1;  ///< from 0, one that stands if there is one; -1: all are there
    std::uint8_t mode = 0;    ///< its modes
    float distance = 0.0F;    ///< [m]
  };
  NotStaged not_staged() const noexcept { return not_staged_.load(std::memory_order_acquire); }
  /// How long the control thread's stall lasted that caused a STOP [s]; 0: there was none. Only with real robots: their
  /// links or the guard have stopped them meanwhile, and none drives on by itself afterwards.
  double stood_still() const noexcept { return stood_still_.load(std::memory_order_acquire); }
  /// The event that showed that a camera was moved, if that stopped all robots: CameraMoved, CamerasDisagree or
  /// PicturesLate; empty: they were not stopped.
  std::optional<Event> camera_moved() const noexcept {
    return camera_moved_.load(std::memory_order_acquire) ? std::optional(motion_) : std::nullopt;
  }
  /// What any two of several cameras say of each other.
  std::vector<CameraPair> camera_pairs() const;
  /// Set when the control thread failed; the reason may be read then.
  bool failed() const noexcept { return failed_.load(std::memory_order_acquire); }
  const std::string& reason() const noexcept { return reason_; }
  /// The thread's timing at real-time speed; after end_thread().
  const Timing& timing() const noexcept { return timing_; }
  /// The same while the thread runs; none before its first tick. One thread may ask.
  std::optional<Timing> timing_so_far();
  const TickRecord& prototype() const noexcept { return tick_.record(); }

 private:
  struct PairState {
    std::array<std::atomic<double>, 3> now{}, target{};
    std::atomic<bool> coupled{true};
  };
  std::size_t pair(std::size_t i, std::size_t j) const noexcept { return i * experiment_.robots.size() + j; }
  void publish_couplings() noexcept;
  void publish_comparisons(double now) noexcept;
  void thread(const std::stop_token& stop);
  double pace(std::chrono::steady_clock::time_point& last, const std::stop_token& stop);
  void count_lateness(double late) noexcept;
  bool asked() const noexcept;
  void cycle(double now, int elapsed);
  void await_frame(const TickTimer::Window& window) noexcept;
  void wake_controller(const TickTimer::Window& window) noexcept;
  void ask_controller() noexcept;
  void heed_camera(const TickRecord& record) noexcept;
  void complete_latency() noexcept;
  void take_commands(const EventList& events);
  std::size_t room_for_events(const EventList& events) const noexcept;
  std::size_t most_events(const OperatorCommand& command) const noexcept;
  void perturb(int elapsed, EventList& events);
  void do_actions(double t, bool running, EventList& events);
  void carry_out(const Gesture& gesture, EventList& events);

  const Experiment& experiment_;
  SessionClock& clock_;
  Plant& plant_;
  std::function<void(const TickRecord&)> report_;
  OwnController* const controller_;
  ControlTick tick_;
  TickRecord out_;

  boost::lockfree::spsc_queue<OperatorCommand> commands_;
  boost::lockfree::spsc_queue<Gesture> hand_;
  TickInput input_;
  std::vector<OperatorCommand> obeyed_;  // by this tick; commands whose events have no room wait for the next
  std::vector<core::Measurement> newest_;
  std::vector<core::Pose> truth_;
  std::vector<core::WheelSpeeds> wheels_;
  FrameTimes frame_;          // the newest frame's
  bool new_frame_ = false;    // it came since the previous tick
  Latency latency_;           // of this tick, as far as it is known
  double decided_at_ = none;  // when this tick's commands were given
  std::vector<comms::CommandTimes> command_times_;
  std::vector<LinkInput> links_;
  std::vector<double> delays_;  // from a robot's command to the moment its wheels obey, a moving mean
  std::size_t next_perturbation_ = 0, next_action_ = 0;
  std::int64_t virtual_ticks_ = 0;

  std::atomic<bool> stop_{false}, failed_{false}, away_{false}, camera_moved_{false};
  Event motion_;  // written once, before camera_moved_
  std::atomic<double> speed_{1.0}, stood_still_{0.0};
  std::atomic<int> steps_{0};
  bool paced_ = false;     // at every speed
  bool stepping_ = false;  // the next tick ends a step
  std::atomic<Phase> phase_{Phase::ready};
  std::atomic<bool> paused_{false};
  std::uint64_t posted_ = 0;  // commands; the controlling thread's
  std::uint64_t taken_ = 0;   // of them, by the control thread
  std::atomic<std::uint64_t> obeyed_so_far_{0};
  std::atomic<int> unseen_{0};
  std::atomic<NotStaged> not_staged_{};
  static_assert(std::atomic<NotStaged>::is_always_lock_free);
  std::unique_ptr<PairState[]> pairs_;
  struct Compared {  // two cameras
    float apart = 0.0F;
    std::uint16_t robot = 0;
    bool compared = false, undecided = false;
  };
  static_assert(std::atomic<Compared>::is_always_lock_free);
  std::unique_ptr<std::atomic<Compared>[]> compared_;  // camera a and a later one, b, at a * cameras + b
  std::string reason_;
  Timing timing_;
  Newest<Histogram> late_;          // of timing_.tick
  std::atomic<bool> ticks_{false};  // the rest of timing_ holds
  const bool several_processors_ = std::thread::hardware_concurrency() > 1;
  std::unique_ptr<BareThread> bare_;
  std::jthread thread_;
};

}  // namespace skein::app
