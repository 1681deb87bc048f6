#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/status.h"
#include "app/run/tick_record.h"
#include "app/run/timing.h"
#include "app/session/session_options.h"
#include "vision/frames/frame_source.h"

namespace skein::app {

class OwnController;

struct SessionWiring;

/// An experiment with everything that runs it: plant, camera, links, control thread, recorder. The facade that the
/// window and the command line both use: commands in, records and status out.
///
/// Life: open -> (ready: robots stand, poses flow) -> start -> running <-> paused -> finished or stopped -> close.
/// Everything may be called from one controlling thread; stop() from any thread, at any time.
class Session {
 public:
  using Clock = SessionOptions::Clock;

  /// Opens camera and links and puts the simulated robots at their starts. The error names the failure and the remedy.
  static tl::expected<std::unique_ptr<Session>, std::string> open(const Experiment& experiment, Clock clock,
                                                                  SessionOptions options = {});
  ~Session();  ///< closes

  const Experiment& experiment() const noexcept;

  /// Commands are executed by the next ticks, in order. The result says whether a command was accepted; if not, it has
  /// no effect, and the error is the reason.
  using Answer = tl::expected<void, std::string>;

  /// These four are refused in a phase in which they would change nothing.
  [[nodiscard]] Answer start();
  /// Every robot drives to its start without touching another, and stands there; then the session is ready again, or
  /// finished if the run is over. Before a run and after it.
  [[nodiscard]] Answer stage();
  /// Robots that are running, or driving to their starts, stand until it is resumed.
  [[nodiscard]] Answer pause();
  [[nodiscard]] Answer resume();
  /// One tick from ready or paused on, and paused again. Refused with the reason if a link or camera runs in real time.
  [[nodiscard]] Answer step();
  static constexpr double slowest = 0.1, fastest = 50.0;  ///< of a simulation, times real time
  /// How much faster than real time the simulation runs, `slowest` to `fastest`. At any speed but 1, every tick runs at
  /// exactly its time and none is skipped: an overloaded machine makes the run slower, never different. Refused with
  /// the reason if a link or camera runs in real time.
  [[nodiscard]] Answer set_speed(double speed);
  double speed() const noexcept;
  /// STOP: latched, directly to every link and every simulated wheel, without waiting for the tick; the run is over.
  void stop() noexcept;

  /// A new value for all pairs, clamped at `gain_limit`, the limit of (18). It is approached at a bounded rate, or
  /// more slowly if `seconds` sets a longer ramp.
  [[nodiscard]] Answer set_gain(core::GainName name, double value, double seconds = 0.0);
  /// The same for robots i and j only, from 0.
  [[nodiscard]] Answer set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds = 0.0);
  /// Switches the coupling of two robots off or on: their gains go to zero and come back at the same rate, clamped at
  /// the limit of (18f, g) at that time.
  [[nodiscard]] Answer couple(std::size_t i, std::size_t j, bool on);

  /// What the law declares, with the file's values and what it allows.
  const std::vector<LawParameter>& law_parameters() const noexcept;
  /// A new value of one of them, in force from the next tick on: a controller of the user's own gets it with its next
  /// question. Refused with what is allowed.
  [[nodiscard]] Answer set_parameter(std::string_view name, double value);

  /// The largest value that (18f, g) allow for this gain over the whole reference, with the others unchanged: for all
  /// pairs, or for one.
  double gain_limit(core::GainName name) const;
  /// The same at this tick only, for the formation's present velocities: never less than over the whole
  /// reference.
  double gain_limit(core::GainName name, const TickRecord& now) const;
  double gain_limit(core::GainName name, std::size_t i, std::size_t j) const;
  /// Of two different robots, at the latest tick: the gain, its target (0 while they are switched off), and whether
  /// they are coupled. `name` is one of core::gain_names.
  double gain(core::GainName name, std::size_t i, std::size_t j) const;
  double gain_target(core::GainName name, std::size_t i, std::size_t j) const;
  bool coupled(std::size_t i, std::size_t j) const;

  /// Moves a simulated robot to a pose, as by hand. Refused for a real one, with the reason.
  [[nodiscard]] Answer move_robot(std::size_t robot, const core::Pose& pose);

  /// Kicks a simulated robot: it slides with this velocity [m/s, world frame] until friction has stopped it, and drives
  /// on meanwhile.
  [[nodiscard]] Answer kick_robot(std::size_t robot, double vx, double vy);

  /// Holds one robot, real or simulated, and takes it out of the group until it is released; the others drive on. This
  /// goes through the tick: in danger, use stop().
  [[nodiscard]] Answer hold_robot(std::size_t robot, bool hold);

  /// Turns each wheel of a robot with a link about 10 mm forward and compares its counters with that. Only while the
  /// session is ready; it takes some seconds, and is ended by STOP, a start or the end of the session. Refused with the
  /// reason.
  [[nodiscard]] Answer check_wheels(std::size_t robot);
  /// Its result, once, as soon as it is known. The error names the robot and the reason why it could not be tested.
  std::optional<tl::expected<WheelCheck, std::string>> wheel_check();

  /// Adds an obstacle that avoidance and shield keep clear of from the next tick on; returns its number, from 0. The
  /// file's obstacles come first, and can be moved and removed as well.
  [[nodiscard]] tl::expected<std::size_t, std::string> add_obstacle(const core::Obstacle& obstacle);
  [[nodiscard]] Answer move_obstacle(std::size_t number, const core::Obstacle& obstacle);
  [[nodiscard]] Answer remove_obstacle(std::size_t number);
  /// As requested; an obstacle of radius 0 is absent.
  std::span<const core::Obstacle> obstacles() const noexcept;

  /// Returns every record since the last call (ready and paused ones too), oldest first. For one thread: the
  /// window's.
  std::size_t drain(const std::function<void(const TickRecord&)>& take);

  /// The timing of the run, after close(); empty on the virtual clock.
  std::optional<Timing> timing() const;
  /// The same while it goes on, until now. One thread may ask.
  std::optional<Timing> timing_so_far() const;

  /// Rows of the run that its sinks did not get, because they were too slow for 20 s; 0 on the virtual clock.
  std::uint64_t dropped_rows() const noexcept;
  /// Records that `drain` did not return, because it was not called for 20 s.
  std::uint64_t undrained_rows() const noexcept;

  /// The newest camera image, if it is newer than the last one returned. For one thread: the
  /// window's.
  bool picture(Picture& out);
  bool has_camera() const noexcept;
  /// Why the camera does not see robots' tags: "tag 3 is there, but its edge is 40 mm, 33 % smaller than [tags] size
  /// 60 mm ...". Takes up to some seconds; wall clock only, one caller at a time.
  std::vector<UnseenTag> why_not_seen() const;
  /// Projects a point of the plane of the robots' tags into the camera's image, (0, 0) is the centre of its top-left
  /// pixel.
  std::array<double, 2> pixel(double x, double y) const;

  std::vector<RobotStatus> robots() const;
  /// Any thread.
  vision::SourceStatus camera() const;
  /// What is known about the cameras before a start.
  CameraStatus camera_status() const;
  /// What the marks on the floor show about the camera. If they show that it has moved, the session refuses to start,
  /// and stops if it runs. Any thread.
  MarksStatus marks() const;
  /// Complete after close(). Any thread.
  VideoStatus video() const;
  /// Ends the film; the run goes on. The returned function completes the file, which may take a second, on any thread,
  /// even when the session is gone; null: there is no film any more.
  std::function<VideoStatus()> end_film();
  /// The run's own controller, null: it has none. After close() it has its statistics.
  const OwnController* controller() const noexcept;
  /// Why there is no guard although one was requested: if this program is killed, nothing stops the robots.
  std::optional<std::string> unguarded() const;
  /// Sentences that the operator must see, each once: about the guard, an external STOP, a machine that may suspend.
  /// One thread.
  std::vector<std::string> alarms();
  /// Why the session failed (camera gone, a link that could not be held, an exception), if it did.
  std::optional<std::string> failure() const;

  /// Virtual clock: runs from start to the end (finished, stopped or failed); `keep_on` is called regularly, and false
  /// stops the run. Wall clock: starts, and waits for the end.
  Phase run(const std::function<bool()>& keep_on = {});

  /// Stops every robot, waits until each has acknowledged (at most a second), ends all threads. Idempotent. After it,
  /// `robots` shows which have acknowledged.
  void close();

 private:
  explicit Session(std::unique_ptr<SessionWiring> wiring);
  std::unique_ptr<SessionWiring> wiring_;
};

}  // namespace skein::app
