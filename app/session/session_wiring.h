#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "app/controllers/own_controller.h"
#include "app/experiment/experiment.h"
#include "app/guard/kept_awake.h"
#include "app/guard/safety_net.h"
#include "app/run/status.h"
#include "app/session/control_loop.h"
#include "app/session/experiment_cameras.h"
#include "app/session/plant.h"
#include "app/session/record_channel.h"
#include "app/session/session_options.h"

namespace skein::app {

inline constexpr auto recorder_period = std::chrono::milliseconds(20);
inline constexpr auto supervisor_period = std::chrono::milliseconds(20);
inline constexpr auto longest_hold =
    std::chrono::seconds(1);                   // how long a paced simulation waits for its sinks and its window
inline constexpr double window_silence = 3.0;  // robots with links are stopped when the window hangs for longer [s]

/// The rows of a run: its running ticks, and after the start all other ticks with events (pause, stop).
inline bool belongs_to_run(const TickRecord& record, bool started) noexcept {
  const bool driving_back = record.phase == Phase::staging && record.tick > 0;
  return record.phase == Phase::running || (record.phase == Phase::staging && !driving_back) ||
         (started && !driving_back && !record.events.empty());
}

/// The data flow of a run: plant -> control loop -> channels -> recorder and window; operator -> queues -> control
/// loop.
struct SessionWiring {
  SessionWiring(const Experiment& e, SessionOptions::Clock c, SessionOptions o)
      : experiment(e), options(std::move(o)), clock(c == SessionOptions::Clock::wall), obstacles(e.obstacles) {}

  void publish(const TickRecord& record) {  // on the control thread
    if (clock.wall()) {
      if (!clock.runs()) hold();
      recorder_channel->push(record);
      window_channel->push(record);
    } else if (recorded) {
      recorded = tell_sinks_or_fail([&] { tell_sinks(record); });
    }
  }

  /// A paced simulation waits for a slow disk or window instead of losing a row. STOP ends the wait.
  void hold() const {
    const auto give_up = std::chrono::steady_clock::now() + longest_hold;
    while ((recorder_channel->full() || (!std::isnan(last_look.load()) && window_channel->full())) &&
           !loop->stop_asked() && std::chrono::steady_clock::now() < give_up)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  void tell_sinks(const TickRecord& record) {
    // Also a run that is paused in the tick that starts it: its events are told here alone.
    started =
        started || record.phase == Phase::running || record.phase == Phase::staging || record.phase == Phase::paused;
    if (belongs_to_run(record, started))
      for (RecordSink* sink : options.sinks) sink->record(record);
  }

  /// False: a sink failed, and the run with it.
  bool tell_sinks_or_fail(const std::function<void()>& tell) {
    try {
      tell();
      return true;
    } catch (const std::exception& error) {
      fail(fmt::format("the run could not be recorded: {}", error.what()));
      return false;
    }
  }

  void fail(std::string reason) {
    {
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::move(reason);
    }
    stop();
  }

  double gain_limit(core::GainName name, const core::ReferenceDemand& of) const {
    return core::gain_limit(name, gains, targets(), of);
  }

  using Answer = tl::expected<void, std::string>;

  /// Passes a command to the next ticks.
  Answer ask(const OperatorCommand& command) { return taken(loop->post(command)); }
  /// The same, unless `why_not` has a reason why it would change nothing now. Until earlier commands are executed the
  /// phase is not known in which the next tick finds it: then it is passed on.
  Answer ask_in_phase(const OperatorCommand& command, std::string (*why_not)(Phase phase, bool is_paused));
  Answer ask(const ControlLoop::Gesture& gesture) { return taken(loop->post(gesture)); }
  static Answer taken(bool posted) {
    if (posted) return {};
    return tl::unexpected(std::string("too many commands at once: this one was not executed, repeat it"));
  }

  Answer put(std::size_t number, const core::Obstacle& obstacle) {
    if (number >= obstacles.all().size()) return tl::unexpected(fmt::format("there is no obstacle {}", number + 1));
    auto answer = ask(commands::PutObstacle{number, obstacle});
    if (answer) obstacles.put(number, obstacle);
    return answer;
  }

  void stop() noexcept {
    loop->stop();
    plant->stop();
  }

  void stop_from_outside(const std::string& why) {
    {
      const std::lock_guard lock(failure_mutex);
      alarms.push_back(why);
    }
    stop();
  }

  /// Passes rows to the sinks, on a separate thread: only it waits for a slow sink.
  void recorder(const std::stop_token& token) {
    while (true) {
      const bool last = token.stop_requested();
      if (!tell_sinks_or_fail(
              [this] { recorder_channel->drain([this](const TickRecord& record) { tell_sinks(record); }); }))
        return;
      if (last) return;
      std::this_thread::sleep_for(recorder_period);
    }
  }

  /// Supervises links, camera, window and guard: a separate thread, which waits for no file.
  void supervise(const std::stop_token& token) {
    for (; !token.stop_requested(); std::this_thread::sleep_for(supervisor_period)) {
      try {
        watch();
        keep_awake();
      } catch (const std::exception& error) {
        fail(fmt::format("the supervision of the run failed: {}", error.what()));
        return;
      }
    }
  }

  void keep_awake() {
    if (!sleep) return;
    const Phase phase = loop->phase();
    const bool moves = phase == Phase::running || phase == Phase::staging;
    const bool over = phase == Phase::stopped || phase == Phase::finished;
    sleep->hold(moves || (over && sleep->held() && !all_acknowledged()));
  }

  /// Whether every real robot is known to stand.
  bool all_acknowledged() const {
    const std::vector<StopResult> robots = stop_results(experiment, plant->robots());
    return std::all_of(robots.begin(), robots.end(), [](const StopResult& robot) { return robot.stopped; });
  }

  void heed_camera() {
    const auto moved = loop->camera_moved();
    if (!moved) return;
    if (const auto* const bumped = std::get_if<events::CameraMoved>(&*moved))
      fail(camera_moved_sentence(experiment, *bumped, "STOP"));
    if (const auto* const differ = std::get_if<events::CamerasDisagree>(&*moved)) fail(camera_stop_sentence(*differ));
    if (const auto* const late = std::get_if<events::PicturesLate>(&*moved)) fail(pictures_late_sentence(*late));
  }
  /// Of any two, once. Of those that contradict each other the refusal of a start tells, or the reason of the STOP.
  void tell_of_differences(Phase phase) {
    const bool stands = phase == Phase::ready || phase == Phase::stopped;
    for (const CameraPair& pair : loop->camera_pairs()) {
      if (pair.apart == 0.0 || (stands && contradict(experiment, pair))) continue;
      if (!differences_told.emplace(pair.first, pair.second).second) continue;
      const std::lock_guard lock(failure_mutex);
      alarms.push_back(cameras_differ_sentence({pair.robot, pair.first, pair.second, pair.apart}));
    }
  }

  /// Why no robot may drive by a camera's poses, unless the file allows it: the marks on the floor, or the size of all
  /// tags, show that the camera has moved, or the marks that its calibration is another one's. `then`: what follows.
  std::string wrong_camera(std::string_view then) const {
    if (experiment.failure.camera_moved == FailureSpec::CameraMoved::go_on) return {};
    const MarksStatus marks = plant->marks();
    if (!marks.exchanged.empty()) return fmt::format("{}: {}", marks.exchanged, then);
    return marks.moved ? camera_moved_sentence(experiment, *marks.moved, then) : std::string();
  }
  /// Refuses commands that make robots drive.
  Answer may_drive() const {
    if (std::string why = wrong_camera("no robot drives"); !why.empty()) return tl::unexpected(std::move(why));
    for (const CameraPair& pair : loop->camera_pairs())
      if (contradict(experiment, pair)) return tl::unexpected(camera_pair_sentence(experiment, pair));
    return {};
  }

  void watch() {
    const Phase phase = loop->phase();
    heed_camera();
    tell_of_differences(phase);
    if (loop->failed()) fail(loop->reason());
    if (const double gap = loop->stood_still(); gap > 0.0) fail(stood_still_sentence(gap));
    if (phase == Phase::stopped || phase == Phase::finished) return;
    if (auto reason = plant->failure()) fail(*reason);
    tell_of_losses();
    if (phase != Phase::ready)
      if (std::string why = wrong_camera("STOP"); !why.empty()) fail(std::move(why));
    watch_controller();
    const bool moves = phase == Phase::running || phase == Phase::staging;
    if (real_time && moves && clock.now() - last_look.load() > window_silence)
      fail(fmt::format("the window has not responded for {:g} s: the operator could neither see nor stop the robots",
                       window_silence));
  }

  /// Where the others go on without a robot whose link is lost.
  void tell_of_losses() {
    constexpr double again_after = 10.0;  // of a link that is lost again and again [s]
    const double now = clock.now();
    for (LinkWatch::Loss& loss : plant->losses()) {
      if (experiment.failure.link_lost != FailureSpec::LinkLost::others_go_on) continue;
      loss_told_at.resize(experiment.robots.size(), none);
      double& told_at = loss_told_at[loss.robot];
      if (now - told_at < again_after) continue;
      told_at = now;
      const std::lock_guard lock(failure_mutex);
      alarms.push_back(loss.sentence +
                       "; it is told to stop until it answers, then it waits for its release, and the "
                       "others go on");
    }
  }

  /// Ends a run whose controller has ended, unless the built-in law drives on.
  void watch_controller() {
    if (!controller || controller->state() != ControllerState::ended || told_of_controller) return;
    told_of_controller = true;
    const std::string why = controller->why_it_ended();
    if (experiment.controller.law.failure == LawSpec::Failure::hold) return fail(why);
    const std::lock_guard lock(failure_mutex);
    alarms.push_back(why + "; the built-in law drives on");
  }

  /// Why a robot's test must end; empty: it may go on.
  std::string test_ends() const {
    if (loop->stop_asked()) return "STOP was pressed";
    const bool ready = !ends_test.load() && loop->phase() == Phase::ready;
    return ready ? "" : "the robots are no longer ready";
  }

  Answer check_pair(std::size_t i, std::size_t j) const;
  /// The targets of the couplings.
  core::CouplingGains targets() const;

  const Experiment experiment;
  SessionOptions options;
  SessionClock clock;
  core::ObstacleField obstacles;  // as set by the operator
  core::Gains gains;
  core::ReferenceDemand demand;
  tl::expected<SafetyNet, std::string> net;
  std::vector<std::string> alarms;  // guarded by failure_mutex: those of neither safety net nor cameras
  std::vector<UnguardedCalibration> unguarded;
  std::unique_ptr<Plant> plant;
  std::unique_ptr<OwnController> controller;  // of a run that has one
  std::vector<LawParameter> law_parameters;   // as the law declares them, with the file's values
  std::unique_ptr<ControlLoop> loop;
  std::unique_ptr<RecordChannel> recorder_channel, window_channel;
  std::jthread recorder_thread, supervisor_thread;
  std::optional<KeptAwake> sleep;  // of a machine with real robots
  const bool real_time = real_time_reason(experiment).has_value();
  std::atomic<bool> ends_test{false};
  std::future<tl::expected<WheelCheck, std::string>> test;  // under way, or not yet asked for
  std::atomic<double> last_look{none};  // time of the last drain, on the session's clock [s]; none: there was none
  bool started = false;                 // the sinks' thread's
  bool recorded = true;                 // on the virtual clock: no sink has failed
  bool closed = false;
  bool told_of_controller = false;
  std::set<std::pair<std::size_t, std::size_t>> differences_told;  // cameras; the supervisor's
  std::vector<double> loss_told_at;                                // of each robot; the supervisor's [s]
  mutable std::mutex failure_mutex;
  std::optional<std::string> failure;
};

}  // namespace skein::app
