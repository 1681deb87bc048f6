#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
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

  /// Opens camera and links and puts the simulated robots at their starts. The error says what failed and what to do.
  static tl::expected<std::unique_ptr<Session>, std::string> open(const Experiment& experiment, Clock clock,
                                                                  SessionOptions options = {});
  ~Session();  ///< closes

  const Experiment& experiment() const noexcept;

  /// What is asked of the session is done by the next ticks, in the order in which it was asked for. The answer says
  /// whether it was taken; where not, nothing of it is done, and the error says why.
  using Answer = tl::expected<void, std::string>;

  [[nodiscard]] Answer start();
  /// Every robot drives to its start without touching anybody, and stands there; then the session is ready again, or
  /// finished if the run is over. Does nothing while it runs.
  [[nodiscard]] Answer stage();
  [[nodiscard]] Answer pause();
  [[nodiscard]] Answer resume();
  /// One tick from ready or paused on, and paused again. Refused where anything lives in real time, with the reason.
  [[nodiscard]] Answer step();
  /// How much faster than real time the simulation runs, 0.1 to 50. Other than 1, every tick runs at exactly its time
  /// and none is skipped: what cannot keep up makes the run slower, never different. Refused where anything lives in
  /// real time, with the reason.
  [[nodiscard]] Answer set_speed(double speed);
  double speed() const noexcept;
  /// STOP: latched, straight to every link and every simulated wheel, without waiting for the tick; the run is over.
  void stop() noexcept;

  /// A new value for all pairs, held at `gain_border` where (18) ends. It is approached at a bounded rate, and slower
  /// where `seconds` asks for a ramp that takes longer.
  [[nodiscard]] Answer set_gain(core::GainName name, double value, double seconds = 0.0);
  /// The same for robots i and j alone, from 0.
  [[nodiscard]] Answer set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds = 0.0);
  /// Switches the coupling of two robots off or on: their gains go to zero and come back at the same rate, held where
  /// (18f, g) end by then.
  [[nodiscard]] Answer couple(std::size_t i, std::size_t j, bool on);

  /// The largest value that (18f, g) leave to this gain over the whole reference, with the others as they are: for all
  /// pairs, or for one.
  double gain_border(core::GainName name) const;
  /// The same at this tick alone, for what the formation asks of the robots now: never less than over the whole
  /// reference.
  double gain_border(core::GainName name, const TickRecord& now) const;
  double gain_border(core::GainName name, std::size_t i, std::size_t j) const;
  /// Of two different robots, at the latest tick: the gain, where it is going (0 while they are switched off), and
  /// whether they are coupled. `name` is one of core::gain_names.
  double gain(core::GainName name, std::size_t i, std::size_t j) const;
  double gain_target(core::GainName name, std::size_t i, std::size_t j) const;
  bool coupled(std::size_t i, std::size_t j) const;

  /// Puts a simulated robot somewhere, as a hand does. Refused for a real one, with the reason.
  [[nodiscard]] Answer move_robot(std::size_t robot, const core::Pose& pose);

  /// Kicks one: it slides with this velocity [m/s, world frame] until friction has stopped it, and drives on meanwhile.
  [[nodiscard]] Answer kick_robot(std::size_t robot, double vx, double vy);

  /// Makes one robot stand, real or not, and takes it out of the group until it is let go again; the others drive on.
  /// This goes through the tick: in danger, stop().
  [[nodiscard]] Answer hold_robot(std::size_t robot, bool hold);

  /// Turns each wheel of a robot with a link about 10 mm forward and compares its counters with that. Only while the
  /// session is ready; it takes some seconds, and STOP, a start and the end of the session end it. Refused with the
  /// reason.
  [[nodiscard]] Answer check_wheels(std::size_t robot);
  /// What it found, once, as soon as that is known. The error names the robot and says why it could not be tested.
  std::optional<tl::expected<WheelCheck, std::string>> wheel_check();

  /// Puts an obstacle onto the floor that avoidance and shield keep clear of from the next tick on; the answer is its
  /// number, from 0. The file's obstacles come first, and can be moved and taken away as well.
  [[nodiscard]] tl::expected<std::size_t, std::string> add_obstacle(const core::Obstacle& obstacle);
  [[nodiscard]] Answer move_obstacle(std::size_t number, const core::Obstacle& obstacle);
  [[nodiscard]] Answer remove_obstacle(std::size_t number);
  /// As they were asked for; one that has radius 0 is not there.
  std::span<const core::Obstacle> obstacles() const noexcept;

  /// Hands over every record since the last call (ready and paused ones too), oldest first. For one thread: the
  /// window's.
  std::size_t drain(const std::function<void(const TickRecord&)>& take);

  /// How well the run kept time, after close(); empty on the virtual clock.
  std::optional<Timing> timing() const;

  /// Rows of the run that its sinks never got, because they were too slow for 20 s; 0 on the virtual clock.
  std::uint64_t dropped_rows() const noexcept;
  /// Records that `drain` never handed over, because nobody came for them for 20 s.
  std::uint64_t undrained_rows() const noexcept;

  /// The newest camera picture, if there is a newer one than the last that was handed over. For one thread: the
  /// window's.
  bool picture(Picture& out);
  bool has_camera() const noexcept;
  /// Why the camera does not see robots' tags, a sentence each: "tag 3 is there, but its edge is 40 mm, 33 % smaller
  /// than [tags] size 60 mm ...". Takes up to some seconds; wall clock only, one caller at a time.
  std::vector<std::string> why_not_seen() const;
  /// Where a point of the plane of the robots' tags stands in the camera's picture, (0, 0) the centre of its top-left
  /// pixel.
  std::array<double, 2> pixel(double x, double y) const;

  std::vector<RobotStatus> robots() const;
  /// Any thread.
  vision::SourceStatus camera() const;
  /// Complete after close(). Any thread.
  VideoStatus video() const;
  /// The run's own controller, null: it has none. After close() it says how it has done.
  const OwnController* controller() const noexcept;
  /// Why there is no guard although one was asked for: should this program be killed, nothing stops the robots.
  std::optional<std::string> unguarded() const;
  /// Sentences that the operator must see, each once: about the guard, STOP from outside, a machine that may go to
  /// sleep. One thread.
  std::vector<std::string> alarms();
  /// Why the session failed (camera gone, a link that could not be held, an exception), if it did.
  std::optional<std::string> failure() const;

  /// Virtual clock: runs from start to the end (finished, stopped or failed); `keep_on` is called now and then,
  /// and its false stops the run. Wall clock: starts, and waits for the end.
  Phase run(const std::function<bool()>& keep_on = {});

  /// Stops every robot, waits until each has acknowledged (at most a second), ends all threads. Idempotent. After it,
  /// `robots` says who acknowledged.
  void close();

 private:
  explicit Session(std::unique_ptr<SessionWiring> wiring);
  std::unique_ptr<SessionWiring> wiring_;
};

}  // namespace skein::app
