#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "app/run/event.h"
#include "core/control/gains.h"
#include "core/control/tracking_error.h"
#include "core/estimation/measurement.h"
#include "core/kinematics/differential_drive.h"
#include "core/math/elementary.h"
#include "core/words.h"

namespace skein::app {

/// No value: an empty cell of the CSV.
inline constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// The modes of a robot at a tick (bits).
enum Mode : std::uint8_t {
  staging = 1,
  tracking = 2,
  avoiding = 4,  ///< follows a modified reference
  shielded = 8,  ///< the shield changed its forward speed
  limited = 16,  ///< box or wheels changed the law's command
  stopped = 32,  ///< commanded to stop: not running, paused, STOP, lost
  lost = 64,     ///< no pose within the bridge time
  late = 128,    ///< slowed or held because its link has not confirmed its commands
};

/// The tick's inputs from a robot's link. Wall clock only.
struct LinkInput {
  bool linked = false;                 ///< it has one
  core::WheelSpeeds sent{none, none};  ///< the speeds last written to the system; a stop is 0 [steps/s]
  double sent_at = none;               ///< when [s, session's clock]
  /// How far it may have driven since its newest confirmed command; links.blind_distance or more: its link has stopped
  /// it. [m]
  double blind_way = none;
};

/// As the CSV calls it (core/words.h); of one bit.
constexpr std::string_view word(Mode bit) noexcept {
  switch (bit) {
    case staging:
      return "staging";
    case tracking:
      return "tracking";
    case avoiding:
      return "avoiding";
    case shielded:
      return "shielded";
    case limited:
      return "limited";
    case stopped:
      return "stopped";
    case lost:
      return "lost";
    case late:
      return "late";
  }
  return {};
}

/// The state of a robot's link at a tick; empty without a link.
struct LinkRecord {
  LinkInput input;
  std::optional<LinkState> state;
  double round_trip = none;                      ///< median of the last 256; wall clock only [s]
  double battery = none;                         ///< wall clock only [V]
  double left_steps = none, right_steps = none;  ///< that the robot has counted since the link's first reading [steps]
  double round_trip_p99 = none;                  ///< of the last 256; this and the next: wall clock only [s]
  double bytes = none;                           ///< to and from the robot
  double losses = none, reconnects = none;       ///< answers that did not come in time; times that it was reopened
};

/// The limits that reduced the law's command (bits).
enum Limit : std::uint8_t {
  limit_v = 1,       ///< |v| <= v_max (14)
  limit_omega = 2,   ///< |omega| <= omega_max (14)
  limit_wheels = 4,  ///< a wheel's largest speed
  limit_link = 8,    ///< the speed at which links.blind_distance lasts for links.reply_timeout
};

/// As the CSV calls it (core/words.h); of one bit.
constexpr std::string_view word(Limit bit) noexcept {
  switch (bit) {
    case limit_v:
      return "v";
    case limit_omega:
      return "omega";
    case limit_wheels:
      return "wheels";
    case limit_link:
      return "link";
  }
  return {};
}

/// One robot at one tick. Poses in the world frame.
struct RobotRecord {
  core::Measurement measurement;       ///< the newest one at hand, of any camera that the others do not contradict
  double pose_age = none;              ///< now - captured_at [s]
  core::Pose pose;                     ///< the pose the law used
  double sigma_xy = none;              ///< its standard deviation in the worst direction, when measured [m]
  double actuation_delay = 0.0;        ///< from the tick to the moment the wheels obey, at which `pose` holds [s]
  core::Pose truth{none, none, none};  ///< simulated robots only
  core::ReferencePoint nominal;        ///< of the formation
  core::ReferencePoint reference;      ///< after avoidance
  core::TrackingError error{none, none, none};  ///< (4), from pose and reference; none while lost
  core::Twist law;                              ///< the law's output, before any limit; none if it was not a number
  core::Twist command;                          ///< after limits and shield
  core::WheelSpeeds wheels;                     ///< the tick's command; see LinkInput::sent [steps/s]
  double k_x = 0.0, k_theta = 0.0;              ///< tracking gains in use
  core::Margins margins{};                      ///< of (18), now
  std::uint8_t mode = stopped;
  LinkRecord link;          ///< at its last check: within 20 ms, on the virtual clock after the previous tick
  std::uint8_t limits = 0;  ///< of `Limit`

  bool is(Mode m) const noexcept { return (mode & m) != 0; }
};

/// Where a robot is: the true place of a simulated one, the measured place of any other.
inline core::Pose place(const RobotRecord& robot) noexcept {
  return std::isfinite(robot.truth.x) ? robot.truth : robot.pose;
}

/// The phase of a run.
enum class Phase : std::uint8_t {
  ready,  ///< waits for Start; robots stand
  running,
  paused,    ///< the reference stands still, robots stand
  stopped,   ///< STOP: latched; the run is over
  finished,  ///< the duration is over
  staging,   ///< robots drive to their starts, or stand where this is paused; then ready again, or finished
};

/// The stages of the way from a camera's frame to a robot's answer.
enum class Stage : std::uint8_t {
  capture,      ///< the frame's capture to its arrival: exposure, read-out, transfer
  dequeue,      ///< to the grey picture
  detect,       ///< to the poses
  hand_over,    ///< to the beginning of the tick
  estimate,     ///< the tick's first part: estimation of the poses
  law,          ///< its second part: reference, law, limits, shield, wheels
  write,        ///< to the last robot's command written to the system
  acknowledge,  ///< to the last robot's answer
};
/// As the CSV and the summary call it (core/words.h).
constexpr std::string_view word(Stage stage) noexcept {
  switch (stage) {
    case Stage::capture:
      return "capture";
    case Stage::dequeue:
      return "dequeue";
    case Stage::detect:
      return "detect";
    case Stage::hand_over:
      return "hand_over";
    case Stage::estimate:
      return "estimate";
    case Stage::law:
      return "law";
    case Stage::write:
      return "write";
    case Stage::acknowledge:
      return "acknowledge";
  }
  return {};
}
inline constexpr std::size_t stages = core::all_of<Stage>().size();

/// Durations of the stages of the PREVIOUS tick, since its robots have answered by now. [s]; none: not known, or no
/// such stage
struct Latency {
  std::array<double, stages> of = [] {
    std::array<double, stages> unknown{};
    unknown.fill(none);
    return unknown;
  }();
  double total = none;  ///< from the frame's arrival to its command written: dequeue ... write

  double& operator[](Stage stage) noexcept { return of[static_cast<std::size_t>(stage)]; }
  double operator[](Stage stage) const noexcept { return of[static_cast<std::size_t>(stage)]; }
};

/// Everything about one tick: the CSV row, the plot sample, the replay's input, what tests compare.
struct TickRecord {
  Phase phase = Phase::ready;
  bool staging_paused = false;                ///< of Phase::staging: the robots stand until it is resumed
  double now = 0.0;                           ///< session's clock [s]
  double t = 0.0;                             ///< time of the experiment [s]
  std::int64_t tick = 0;                      ///< t * rate; jumps where deadlines were missed
  double k_xx = 0.0, k_tt = 0.0, k_yy = 0.0;  ///< the largest of all pairs
  std::array<core::PairTable, 3> pair_gains;  ///< of each pair, in the order of core::gain_names
  double V = 0.0, V_dot = 0.0;                ///< (19), (20)
  std::vector<double> delta;                  ///< (37) for neighbours i, i+1: size n-1 [m]
  double min_distance = none;                 ///< between any two robots, true poses where known [m]
  double period = none;                       ///< since the previous tick [s]
  double lag = 0.0;                           ///< of the formation's clock, which `nominal` follows, behind t [s]
  std::size_t planning = 0;                   ///< search nodes expanded for routes
  double compute_time = none;  ///< duration of the tick [s]; none on the virtual clock, so that runs repeat to the bit
  Latency latency;             ///< wall clock only, as compute_time
  EventList events;
  std::vector<double> logged;  ///< by the law, for each robot the values of log_names(): all of robot 1 first
  std::vector<RobotRecord> robots;
  /// With several cameras the newest of each, as TickInput::measurements; else empty.
  std::vector<core::Measurement> by_camera;

  /// Whether the robots stand until the operator resumes.
  bool paused() const noexcept { return phase == Phase::paused || (phase == Phase::staging && staging_paused); }

  /// The largest of all pairs. `name` is one of core::gain_names.
  double gain(core::GainName name) const noexcept {
    switch (name) {
      case core::GainName::k_xx:
        return k_xx;
      case core::GainName::k_tt:
        return k_tt;
      case core::GainName::k_yy:
        return k_yy;
      case core::GainName::c_xx:
      case core::GainName::c_tt:
      case core::GainName::c_yy:
      case core::GainName::l_xx:
      case core::GainName::l_tt:
        break;
    }
    return none;  // not recorded
  }
  /// Of robots i != j, from 0; the largest of all if the record has no gains of pairs.
  double pair_gain(core::GainName name, std::size_t i, std::size_t j) const noexcept {
    const core::PairTable& table = pair_gains[static_cast<std::size_t>(name)];
    return std::max(i, j) < table.robots() ? table(i, j) : gain(name);
  }

  /// Largest position error of all robots that are not lost, from the references after avoidance. [m]
  double tracking_error() const noexcept {
    double largest = 0.0;
    for (const RobotRecord& r : robots)
      if (!r.is(lost)) largest = std::fmax(largest, core::math::hypot(r.error.x, r.error.y));
    return largest;
  }
  /// Largest |delta|. [m]
  double formation_error() const noexcept {
    double largest = 0.0;
    for (const double d : delta) largest = std::fmax(largest, std::abs(d));
    return largest;
  }
};

/// Receives the records of a run, one after the other.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  virtual void record(const TickRecord& record) = 0;
};

}  // namespace skein::app
