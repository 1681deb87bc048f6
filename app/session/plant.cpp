#include "app/session/plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

#include "app/experiment/control_settings.h"
#include "app/session/experiment_cameras.h"
#include "app/session/robot_lines.h"
#include "app/session/wheel_check.h"

namespace skein::app {
namespace {

constexpr double longest_standstill = 0.5;  // of the program, with real robots: beyond it no robot drives on [s]
constexpr double lock_step_timeout = 2.0;   // an emulated robot answers in well under a millisecond [s]

/// The command that finds out where a camera hangs now; whole, if its calibration has the marks.
std::string calibrate_floor(const Experiment& experiment, std::size_t camera, bool by_marks) {
  const CameraSpec& spec = experiment.camera_at(camera);
  if (!by_marks) return "skein calibrate floor";
  std::string settings;
  for (const auto& [name, value] : control_settings(spec)) settings += fmt::format(" --set {}={}", name, value);
  const auto source = [&]() -> std::string {
    switch (spec.kind()) {
      case CameraKind::synthetic:  // it exists only in its run: a film of the run shows what it saw
        return "video:FILM.mkv";
      case CameraKind::absent:
      case CameraKind::recorded:
      case CameraKind::live:
        break;
    }
    return spec.source;
  };
  return fmt::format("skein calibrate floor {} --camera {}{}", source(), experiment.calibration_file(camera), settings);
}

}  // namespace

Plant::Plant(const Experiment& experiment, SessionClock& clock, bool every_tag)
    : experiment_(experiment), clock_(clock), world_(experiment), tags_(wanted_tags(experiment, every_tag)) {}

Plant::~Plant() {
  close();
}

tl::expected<std::unique_ptr<Plant>, std::string> Plant::open(const Experiment& experiment, SessionClock& clock,
                                                              const SessionOptions& options) {
  if (!options.video.empty() && experiment.camera.kind() == CameraKind::absent)
    return tl::unexpected(fmt::format("{}: there is no camera to record (camera.source = \"none\")", options.video));
  if (const auto readable = check_calibrations(experiment); !readable) return tl::unexpected(readable.error());
  std::unique_ptr<Plant> plant(new Plant(experiment, clock, options.every_tag));

  SimulatedWorld& world = plant->world_;
  auto lines = open_lines(
      experiment,
      [&world, &clock](std::size_t robot, const core::WheelSpeeds& told) { world.turn(robot, clock.now(), told); },
      [&clock] { return clock.now(); }, options.faults);
  if (!lines) return tl::unexpected(lines.error());
  plant->linked_ = std::move(lines->robots);
  plant->emulator_ = std::move(lines->emulator);
  if (const std::vector<comms::LinkAddress>& addresses = lines->addresses; !addresses.empty()) {
    comms::LinkOptions link_options;
    link_options.blind_distance = experiment.links.blind_distance;
    link_options.reply_timeout = experiment.links.reply_timeout;
    link_options.command_silence = experiment.command_silence();
    link_options.heartbeat = link_heartbeat;
    link_options.ask_version = true;
    link_options.battery_period = link_battery_period;
    // In lock-step a tick takes as long as it takes: silence on the wall clock says nothing.
    if (!clock.wall()) {
      link_options.command_silence = link_options.heartbeat = link_options.battery_period = 0.0;
      link_options.blind_distance = 0.0;
      link_options.reply_timeout = lock_step_timeout;
    }
    const bool real = std::any_of(experiment.robots.begin(), experiment.robots.end(),
                                  [](const RobotSpec& robot) { return !robot.simulated(); });
    if (clock.wall() && real) link_options.standstill = std::max(longest_standstill, link_options.command_silence);
    plant->links_ = std::make_unique<comms::LinkSupervisor>(addresses, link_options);
    plant->watch_.emplace(plant->linked_, experiment.failure.link_bridge, clock.wall());
    if (auto started = plant->links_->start(comms::reach_patience(addresses), options.keep_on); !started)
      return tl::unexpected(started.error());
  }
  if (experiment.camera.kind() != CameraKind::absent) {
    auto cameras =
        Cameras::open(experiment, clock, plant->world_, options.pictures, plant->tags_, options.await_camera);
    if (!cameras) return tl::unexpected(cameras.error());
    if (!options.video.empty())
      if (auto begun = (*cameras)->keep(options.video); !begun) return tl::unexpected(begun.error());
    (*cameras)->keep_crops(options.crops);
    plant->cameras_ = std::move(*cameras);
    if (clock.wall()) plant->cameras_->start();
  }
  return plant;
}

bool Plant::measure(double now, std::span<core::Measurement> newest, std::span<core::Pose> truth, FrameTimes& frame) {
  world_.advance(now);
  bool looked = false;
  if (cameras_) {
    if (!clock_.wall()) cameras_->process_frames();
    looked = cameras_->newest(newest, frame);
  } else {
    for (std::size_t i = 0; i < experiment_.robots.size(); ++i)
      if (simulated(i)) newest[i] = world_.measure(i, now);
  }
  world_.poses(truth);
  return looked;
}

void Plant::wait_for_frame(double since, double until) noexcept {
  if (cameras_) cameras_->wait_for_frame(since, until);
}

void Plant::watch_for_frame(double since, double until) noexcept {
  if (cameras_) cameras_->watch_for_frame(since, until);
}

void Plant::command_times(double given_at, std::span<comms::CommandTimes> robots) const noexcept {
  std::fill(robots.begin(), robots.end(), comms::CommandTimes{});
  if (!links_) return;
  const auto since = [&](double monotonic) {
    const double at = clock_.from_monotonic(monotonic);
    return at < given_at ? none : at;
  };
  for (std::size_t k = 0; k < linked_.size(); ++k) {
    const comms::CommandTimes times = links_->times(k);
    robots[linked_[k]].written = since(times.written);
    robots[linked_[k]].answered = since(times.answered);
  }
}

void Plant::read_links(std::span<LinkInput> robots) const noexcept {
  if (!links_ || !clock_.wall()) return;
  for (std::size_t k = 0; k < linked_.size(); ++k) {
    const comms::CommandTimes times = links_->times(k);
    LinkInput& robot = robots[linked_[k]];
    robot = {.linked = true, .blind_way = times.blind_way};
    if (times.written == 0.0) continue;
    robot.sent = {static_cast<double>(times.speeds.left), static_cast<double>(times.speeds.right)};
    robot.sent_at = clock_.from_monotonic(times.written);
  }
}

void Plant::act(std::span<const core::WheelSpeeds> wheels) {
  const bool stopped = stopped_.load(std::memory_order_acquire);
  for (std::size_t i = 0; i < wheels.size(); ++i)
    if (!experiment_.robots[i].has_link()) world_.command(i, stopped ? core::WheelSpeeds{} : wheels[i]);
  if (!links_ || stopped) return;
  const std::size_t tested = tested_.load(std::memory_order_acquire);
  for (std::size_t k = 0; k < linked_.size(); ++k) {
    if (linked_[k] == tested) continue;
    const core::WheelSpeeds& w = wheels[linked_[k]];
    links_->command(k, static_cast<int>(w.left), static_cast<int>(w.right));
  }
  acts_.fetch_add(1, std::memory_order_release);
  if (!clock_.wall() && !links_->wait_acknowledged(lock_step_timeout))
    unacknowledged_.store(true, std::memory_order_release);
}

tl::expected<WheelCheck, std::string> Plant::check_wheels(std::size_t robot,
                                                          const std::function<std::string()>& keep_on) {
  const auto link = std::find(linked_.begin(), linked_.end(), robot);
  if (!links_ || link == linked_.end()) return tl::unexpected(std::string("it has no link"));
  tested_.store(robot, std::memory_order_release);
  // A tick that is under way has not seen that yet: the one after it has.
  for (const std::uint64_t acts = acts_.load(std::memory_order_acquire); acts_.load() < acts + 2;) {
    if (std::string reason = keep_on(); !reason.empty()) {
      tested_.store(nobody, std::memory_order_release);
      return tl::unexpected(std::move(reason));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  auto check = app::check_wheels(*links_, static_cast<std::size_t>(link - linked_.begin()),
                                 *experiment_.robots[robot].type, keep_on);
  tested_.store(nobody, std::memory_order_release);
  return check;
}

std::uint64_t Plant::wrong_speeds(std::size_t robot) const {
  const auto link = std::find(linked_.begin(), linked_.end(), robot);
  if (!links_ || link == linked_.end()) return 0;
  return links_->status().at(static_cast<std::size_t>(link - linked_.begin())).wrong_speeds;
}

void Plant::hush(std::size_t robot, double seconds) {
  const auto link = std::find(linked_.begin(), linked_.end(), robot);
  if (links_ && link != linked_.end()) links_->hush(static_cast<std::size_t>(link - linked_.begin()), seconds);
}

void Plant::halt() noexcept {
  if (!links_ || links_->stopped()) return;
  links_->emergency_stop();
  links_->release_stop();
  if (stopped_.load(std::memory_order_acquire)) links_->emergency_stop();  // a STOP that came in between
}

void Plant::stop() noexcept {
  stopped_.store(true, std::memory_order_release);
  if (links_) links_->emergency_stop();
  try {
    world_.stop();
  } catch (...) {  // a mutex that cannot be locked; the control thread's next act stops the simulated robots as well
  }
}

std::vector<RobotStatus> Plant::robots() const {
  std::vector<RobotStatus> all(experiment_.robots.size());
  for (RobotStatus& robot : all) {
    robot.link = LinkState::simulated;
    robot.stop_acknowledged = true;
  }
  if (!links_) return all;
  const std::vector<comms::LinkStatus> links = final_status_.empty() ? links_->status() : final_status_;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const comms::LinkStatus& link = links[k];
    RobotStatus& robot = all[linked_[k]];
    robot.link = state_of(link.state);
    robot.reason = link.reason;
    if (link.exchanges > 0) robot.round_trip = link.rtt_median, robot.round_trip_p99 = link.rtt_p99;
    robot.exchanges = link.exchanges;
    robot.timeouts = link.timeouts;
    robot.resynchronisations = link.resynchronisations;
    robot.reconnects = link.reconnects;
    robot.bytes_sent = link.bytes_sent;
    robot.bytes_received = link.bytes_received;
    robot.battery = link.battery.volts;
    robot.battery_low = link.battery.low;
    robot.battery_text = comms::to_text(link.battery);
    robot.version = link.version;
    if (link.counted_by > 0.0) {
      // In lock-step an answer takes none of the session's time.
      const auto at = [&](double monotonic) { return clock_.wall() ? clock_.from_monotonic(monotonic) : clock_.now(); };
      robot.count = {at(link.counted_since), at(link.counted_by), static_cast<double>(link.left_steps),
                     static_cast<double>(link.right_steps)};
    }
    robot.stop_acknowledged = link.stop_acknowledged;
  }
  return all;
}

std::string stood_still_sentence(double seconds) {
  return fmt::format(
      "the program stalled for {:.1f} s (suspended, stopped by a debugger, or the machine was too busy): STOP",
      seconds);
}

std::string camera_moved_sentence(const Experiment& experiment, const events::CameraMoved& moved,
                                  std::string_view then) {
  const bool only = moved.camera == events::only_camera;
  const double turned = std::abs(moved.turn) * 180.0 / std::numbers::pi;
  const std::string which = only ? "the camera" : fmt::format("camera {}", moved.camera + 1);
  if (moved.scale != 0.0)
    return fmt::format(
        "{} moved, or its zoom or focus changed: all {} tags look {:.1f} % {} at once: {}. Poses are wrong until it is "
        "calibrated again ({}; skein calibrate intrinsics, if it was the zoom)",
        which, moved.tags, 100.0 * std::abs(moved.scale), moved.scale > 0.0 ? "larger" : "smaller", then,
        calibrate_floor(experiment, only ? 0 : moved.camera, false));
  return fmt::format(
      "{} moved (or the floor under it): {}: {}. Poses are wrong until the floor is calibrated again ({})", which,
      moved.marks == 0
          ? fmt::format("all {} tags moved by {:.0f} mm and turned by {:.1f} deg at once", moved.tags, 1e3 * moved.by,
                        turned)
          : fmt::format("{} marks on the floor are {:.0f} mm from where they were when it was calibrated, turned by "
                        "{:.1f} deg",
                        moved.marks, 1e3 * moved.by, turned),
      then, calibrate_floor(experiment, only ? 0 : moved.camera, moved.marks > 0));
}

std::string camera_stop_sentence(const events::CamerasDisagree& differ, std::string_view then) {
  constexpr double farther_than_a_bump = 0.1;  // [m]
  return fmt::format(
      "cameras {} and {} see robot {} {:.0f} mm apart: one of them has moved since it was calibrated{}: {}. `skein "
      "calibrate check` tells which; its floor must be calibrated again (skein calibrate floor)",
      std::min(differ.camera, differ.other) + 1, std::max(differ.camera, differ.other) + 1, differ.robot + 1,
      1e3 * differ.by,
      differ.by > farther_than_a_bump
          ? ", has the calibration of another camera, or was calibrated for a floor with another origin or other axes"
          : "",
      then);
}

bool contradict(const Experiment& experiment, const CameraPair& pair) {
  return pair.apart > experiment.estimation.filter.kidnap &&
         experiment.failure.camera_moved == FailureSpec::CameraMoved::all_stop;
}

std::string camera_pair_sentence(const Experiment& experiment, const CameraPair& pair) {
  if (contradict(experiment, pair))
    return camera_stop_sentence({pair.robot, pair.first, pair.second, pair.apart}, "no robot drives");
  return cameras_differ_sentence({pair.robot, pair.first, pair.second, pair.apart});
}

std::string pictures_late_sentence(const events::PicturesLate& late) {
  return fmt::format(
      "the camera shows robots that obey their commands {:.1f} s later than the known delays explain: STOP. Its "
      "pictures are older than their time stamps say, or commands are held up, so that it is not known where the "
      "robots are. `skein camera latency` measures the delay, for camera.latency (at most 0.5 s)",
      late.by);
}

std::string cameras_differ_sentence(const events::CamerasDiffer& differ) {
  return fmt::format(
      "cameras {} and {} see robot {} {:.0f} mm apart, and go on to: poses under one of them are wrong by as much. "
      "Their calibrations do not agree (skein calibrate joint corrects it), or the time stamps of one are late (skein "
      "camera latency measures it)",
      std::min(differ.camera, differ.other) + 1, std::max(differ.camera, differ.other) + 1, differ.robot + 1,
      1e3 * differ.by);
}

std::optional<std::string> Plant::failure() {
  if (cameras_) {
    cameras_->watch();
    if (std::string gone = cameras_->failure(); !gone.empty()) return gone;
  }
  if (unacknowledged_.load(std::memory_order_acquire)) return "an emulated robot did not answer a command";
  if (!links_ || !final_status_.empty()) return {};
  if (const double gap = links_->stood_still(); gap > 0.0) return stood_still_sentence(gap);
  auto lost = watch_->update(links_->status());
  if (experiment_.failure.link_lost == FailureSpec::LinkLost::others_go_on) return {};
  return lost;
}

void Plant::close() {
  stopped_.store(true, std::memory_order_release);
  if (cameras_) cameras_->end();
  if (links_ && final_status_.empty()) final_status_ = links_->close(link_close_timeout);
  world_.stop();
}

}  // namespace skein::app
