#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/record/tick_record.h"
#include "comms/emulator/radio_faults.h"

namespace skein::app {

/// What the camera saw last, for the window.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> grey;  ///< row by row, 0 black
};

/// One robot's link as the window and the summary show it.
struct RobotStatus {
  std::string link;                                 ///< "simulated", "up", "stale", "failed" ...
  std::string reason;                               ///< the newest thing that went wrong
  double round_trip = none, round_trip_p99 = none;  ///< median and 99th percentile of the last 256 [s]
  std::uint64_t exchanges = 0, timeouts = 0, resynchronisations = 0, reconnects = 0;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  double battery = none;           ///< [V]; none: not known, or an old e-puck1, which says only whether it is low
  bool battery_low = false;        ///< charge it
  std::string battery_text{};      ///< the same in words: "3.90 V", "good", "unknown"
  std::string version{};           ///< of its firmware, as it says it; empty: it did not
  bool stop_acknowledged = false;  ///< after close()
};

/// What a check of one robot's wheels has found.
struct WheelCheck {
  std::size_t robot = 0;
  std::string version{};  ///< of its firmware; empty: it did not say
  double battery = none;  ///< [V]; none: not known
  bool battery_low = false;
  int left_steps = 0, right_steps = 0;  ///< that each wheel's counter said when it alone was told to turn
  std::vector<std::string> faults{};    ///< a sentence each; empty: the robot does as it is told
};

/// How a real camera has been doing.
struct CameraStatus {
  bool up = true;                    ///< false: it does not deliver, and is opened again and again
  std::int64_t outages = 0;          ///< times that it stopped delivering
  std::int64_t damaged = 0;          ///< frames that could not be used
  std::int64_t passed_over = 0;      ///< whole frames that a newer one had overtaken
  std::string reason;                ///< of the last outage
  std::vector<std::string> notices;  ///< what could not be set as it was asked for
};

/// The film that a session keeps of its camera's frames.
struct VideoStatus {
  std::int64_t frames = 0;   ///< kept
  std::int64_t dropped = 0;  ///< not kept, since the disk or the encoder was too slow, or after the problem
  std::string problem;       ///< why the film ends early; the run goes on all the same
};

struct SessionOptions {
  bool pictures = false;           ///< keep the newest camera picture at hand
  std::vector<RecordSink*> sinks;  ///< told every row of the run, on a thread of their own in a real-time session
  std::string video{};             ///< keep the camera's frames in this film (Matroska); empty: none
  /// Real robots get a guard, a process of its own that stops them should this one be killed (safety_net.h).
  bool guard = false;
  std::vector<comms::Fault> faults{};  ///< of the robots with link "loopback", counted among themselves, for practice
  bool every_tag = false;              ///< look for all tags that there are, see CameraRig::newest
};

/// An experiment with everything that runs it: plant, camera, links, control thread, recorder. The facade that the
/// window and the command line both use: commands in, records and status out.
///
/// Life: open -> (ready: robots stand, poses flow) -> start -> running <-> paused -> finished or stopped -> close.
/// Everything may be called from one controlling thread; stop() from any thread, at any time.
class Session {
 public:
  /// In which time a session lives.
  enum class Clock {
    wall,     ///< real time: absolute deadlines, camera and links on threads of their own
    virtual_  ///< as fast as the machine goes, everything in step; `run` is then the way to run it
  };

  /// Opens camera and links and puts the simulated robots at their starts. The error says what failed and what to do.
  static tl::expected<std::unique_ptr<Session>, std::string> open(const Experiment& experiment, Clock clock,
                                                                  SessionOptions options = {});
  ~Session();  ///< closes

  const Experiment& experiment() const noexcept;

  void start();
  /// Every robot drives to its start without touching anybody, and stands there; then the session is ready again, or
  /// finished if the run is over. Does nothing while it runs.
  void stage();
  void pause();
  void resume();
  /// One tick from ready or paused on, and paused again. Refused where anything lives in real time, with the reason.
  tl::expected<void, std::string> step();
  /// How much faster than real time the simulation runs, 0.1 to 50. Other than 1, every tick runs at exactly its time
  /// and none is skipped: what cannot keep up makes the run slower, never different. Refused where anything lives in
  /// real time, with the reason.
  tl::expected<void, std::string> set_speed(double speed);
  double speed() const noexcept;
  /// Why this experiment can neither be stepped nor go at another speed, if it cannot: a link or a camera has its own
  /// time.
  static std::optional<std::string> real_time_reason(const Experiment& experiment);
  /// STOP: latched, straight to every link and every simulated wheel, without waiting for the tick; the run is over.
  void stop() noexcept;

  /// A new value for all pairs, held at `gain_border` where (18) ends. It is approached at a bounded rate, and slower
  /// where `seconds` asks for a ramp that takes longer.
  void set_gain(core::GainName name, double value, double seconds = 0.0);
  /// The same for robots i and j alone, from 0.
  void set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds = 0.0);
  /// Switches the coupling of two robots off or on: their gains go to zero and come back at the same rate, held where
  /// (18f, g) end by then.
  void couple(std::size_t i, std::size_t j, bool on);

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
  tl::expected<void, std::string> move_robot(std::size_t robot, const core::Pose& pose);

  /// Kicks one: it slides with this velocity [m/s, world frame] until friction has stopped it, and drives on meanwhile.
  tl::expected<void, std::string> kick_robot(std::size_t robot, double vx, double vy);

  /// Makes one robot stand, real or not, and takes it out of the group until it is let go again; the others drive on.
  /// This goes through the tick: in danger, stop().
  tl::expected<void, std::string> hold_robot(std::size_t robot, bool hold);

  /// Turns each wheel of a robot with a link about 10 mm forward and compares its counters with that. Only while the
  /// session is ready; it takes some seconds, and STOP, a start and the end of the session end it. Refused with the
  /// reason.
  tl::expected<void, std::string> check_wheels(std::size_t robot);
  /// What it found, once, as soon as that is known. The error names the robot and says why it could not be tested.
  std::optional<tl::expected<WheelCheck, std::string>> wheel_check();

  /// Puts an obstacle onto the floor that avoidance and shield keep clear of from the next tick on; the answer is its
  /// number, from 0. The file's obstacles come first, and can be moved and taken away as well.
  tl::expected<std::size_t, std::string> add_obstacle(const core::Obstacle& obstacle);
  tl::expected<void, std::string> move_obstacle(std::size_t number, const core::Obstacle& obstacle);
  tl::expected<void, std::string> remove_obstacle(std::size_t number);
  /// As they were asked for; one that has radius 0 is not there.
  std::span<const core::Obstacle> obstacles() const noexcept;

  /// Hands over every record since the last call (ready and paused ones too), oldest first. For one thread: the
  /// window's.
  std::size_t drain(const std::function<void(const TickRecord&)>& take);

  /// Rows of the run that its sinks never got, because they were too slow for 20 s; 0 on the virtual clock.
  std::uint64_t dropped_rows() const noexcept;
  /// Records that `drain` never handed over, because nobody came for them for 20 s.
  std::uint64_t undrained_rows() const noexcept;

  /// The newest camera picture, if there is a newer one than the last that was handed over. For one thread: the
  /// window's.
  bool picture(Picture& out);
  bool has_camera() const noexcept;
  /// Where a point of the plane of the robots' tags stands in the camera's picture, (0, 0) the centre of its top-left
  /// pixel.
  std::array<double, 2> pixel(double x, double y) const;

  std::vector<RobotStatus> robots() const;
  /// Any thread.
  CameraStatus camera() const;
  /// Complete after close(). Any thread.
  VideoStatus video() const;
  /// Why there is no guard although one was asked for: should this program be killed, nothing stops the robots.
  std::optional<std::string> unguarded() const;
  /// Why the session failed (camera gone, a link that could not be held, an exception), if it did.
  std::optional<std::string> failure() const;

  /// Virtual clock: runs from start to the end (finished, stopped or failed); `keep_on` is asked now and then and may
  /// say no, which is a stop. Wall clock: starts, and waits for the end.
  Phase run(const std::function<bool()>& keep_on = {});

  /// Stops every robot, waits until each has acknowledged (at most a second), ends all threads. Idempotent. After it,
  /// `robots` says who acknowledged.
  void close();

 private:
  struct Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace skein::app
