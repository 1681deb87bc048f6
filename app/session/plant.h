#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/run/session_clock.h"
#include "app/run/status.h"
#include "app/session/cameras.h"
#include "app/session/link_watch.h"
#include "app/session/session_options.h"
#include "app/session/simulated_world.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/link_supervisor.h"

namespace skein::app {

/// Everything between a wheel command and a measured pose, on both sides of the control tick. Simulated, emulated and
/// real robots, a camera or none, as the experiment file defines for each.
class Plant {
 public:
  static tl::expected<std::unique_ptr<Plant>, std::string> open(const Experiment& experiment, SessionClock& clock,
                                                                const SessionOptions& options);
  ~Plant();

  /// The newest pose of each robot at time `now` (and, if `newest` has room, of the other tags), of several cameras
  /// those of camera 1 first; and the true ones of simulated robots. Control thread only. True if the leading camera's
  /// frame has been processed since the last call; `frame` has its times.
  bool measure(double now, std::span<core::Measurement> newest, std::span<core::Pose> truth, FrameTimes& frame);
  /// Waits until the camera's newest frame was ready at `since` or later, at most until `until`; not at all without a
  /// camera. Wall clock only; control thread only.
  void wait_for_frame(double since, double until) noexcept;
  /// The same without sleeping, see CameraRig.
  void watch_for_frame(double since, double until) noexcept;
  /// When every robot's command that was given since `given_at` was written and answered, on the session's clock; none:
  /// not yet. Zeros: the robot has no link. Control thread only.
  void command_times(double given_at, std::span<comms::CommandTimes> robots) const noexcept;
  /// The state of each robot's link for the tick; unchanged without a link, and on the virtual clock. Control thread
  /// only.
  void read_links(std::span<LinkInput> robots) const noexcept;
  /// Sends wheel speeds to every robot. On the virtual clock it returns when every emulated robot has obeyed. Control
  /// thread only.
  void act(std::span<const core::WheelSpeeds> wheels);
  /// Events of links that were lost or came back since the last call, and of a film that broke off. Control thread
  /// only.
  void tell(EventList& events) noexcept {
    if (watch_) watch_->tell(events);
    if (cameras_) cameras_->tell(events);
  }
  /// The status of the robots' links. Control thread only.
  void fill_links(std::vector<RobotRecord>& robots) const noexcept {
    if (watch_) watch_->fill(robots);
  }
  /// The run is over, and robots may still be driven back to their starts: every link stops its robot until it
  /// acknowledges, or until the next command. Control thread only.
  void halt() noexcept;
  /// Stops everything at once and for good. Any thread.
  void stop() noexcept;

  /// True where a robot is simulated; `move` puts it somewhere, `kick` sends it sliding [m/s].
  bool simulated(std::size_t robot) const { return experiment_.robots[robot].simulated(); }
  void move(std::size_t robot, const core::Pose& pose) { world_.place(robot, pose); }
  void kick(std::size_t robot, double vx, double vy) { world_.kick(robot, vx, vy); }
  core::Pose pose(std::size_t robot) const { return world_.pose(robot); }

  /// The tags that the camera looks for, whose newest measurements measure() returns: the robots' first.
  const std::vector<int>& tags() const noexcept { return tags_; }
  /// What the marks on the floor show. Any thread.
  MarksStatus marks() const { return cameras_ ? cameras_->marks() : MarksStatus{}; }
  /// Null: the experiment has none.
  Cameras* cameras() noexcept { return cameras_.get(); }
  const Cameras* cameras() const noexcept { return cameras_.get(); }

  std::vector<RobotStatus> robots() const;
  /// app::check_wheels of a robot that has a link and stands; `act` skips it meanwhile. Blocks for some seconds; one at
  /// a time, on a thread of its own, and only while the control thread runs.
  tl::expected<WheelCheck, std::string> check_wheels(std::size_t robot, const std::function<std::string()>& keep_on);
  /// How often the robot's link has counted comms::LinkStatus::wrong_speeds.
  std::uint64_t wrong_speeds(std::size_t robot) const;
  /// Sends a robot nothing for this long, unless it must be stopped.
  void hush(std::size_t robot, double seconds);
  /// Supervises links and camera: returns why the run cannot go on, if so. Not on the control thread.
  std::optional<std::string> failure();
  /// Links that `failure` found lost since the last call and that do not end the run. The same thread.
  std::vector<LinkWatch::Loss> losses() { return watch_ ? watch_->losses() : std::vector<LinkWatch::Loss>{}; }
  /// Stops every robot and waits, at most a second, until each has acknowledged.
  void close();

 private:
  Plant(const Experiment& experiment, SessionClock& clock, bool every_tag);

  const Experiment& experiment_;
  SessionClock& clock_;
  SimulatedWorld world_;
  std::vector<int> tags_;
  std::vector<std::size_t> linked_;  // robot of each link
  std::unique_ptr<comms::PtyEmulator> emulator_;
  std::unique_ptr<comms::LinkSupervisor> links_;
  std::vector<comms::LinkStatus> final_status_;  // after close()
  std::unique_ptr<Cameras> cameras_;             // last: their threads use the world
  std::atomic<bool> stopped_{false}, unacknowledged_{false};
  std::optional<LinkWatch> watch_;
  static constexpr std::size_t nobody = static_cast<std::size_t>(-1);
  std::atomic<std::size_t> tested_{nobody};  // the robot that `act` skips
  std::atomic<std::uint64_t> acts_{0};       // finished ones
};

/// Why a run ends after its program stalled.
std::string stood_still_sentence(double seconds);
/// Why a run ends, or does not begin, after a camera was bumped, with the command that corrects the calibration.
/// `then`: what follows, "STOP".
std::string camera_moved_sentence(const Experiment& experiment, const events::CameraMoved& moved,
                                  std::string_view then);
/// Why a run ends, or does not begin, after two cameras disagree. `then`: what follows, "STOP".
std::string camera_stop_sentence(const events::CamerasDisagree& differ, std::string_view then = "STOP");
/// Whether two cameras see a robot so far apart that no robot may drive.
bool contradict(const Experiment& experiment, const CameraPair& pair);
/// What is to be said, before a start, of two cameras that see a robot apart.
std::string camera_pair_sentence(const Experiment& experiment, const CameraPair& pair);

/// Why a run ends after robots drove by pictures that were older than their time stamps say.
std::string pictures_late_sentence(const events::PicturesLate& late);
/// Two cameras see a robot apart, and nobody stops for it.
std::string cameras_differ_sentence(const events::CamerasDiffer& differ);

}  // namespace skein::app
