#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/experiment/controller_spec.h"
#include "app/run/event.h"
#include "comms/link_options.h"
#include "core/avoidance/potential_field.h"
#include "core/control/gain_schedule.h"
#include "core/control/gains.h"
#include "core/estimation/pose_filter.h"
#include "core/kinematics/robot_type.h"
#include "core/reference/formation.h"
#include "core/reference/timetable.h"
#include "core/reference/trajectory.h"
#include "core/safety/limits.h"
#include "core/safety/shield.h"
#include "core/simulation/simulated_robot.h"
#include "vision/frames/film.h"

namespace skein::app {

/// The contents of an experiment file (contract of the keys: docs/experiment-file.md). SI units; robots counted from 0
/// here, from 1 in files, logs and windows. Every default is the paper's case study.

struct PathSpec {
  enum class Shape { rounded_rectangle, circle, ellipse, lemniscate, polyline, spline, line };
  Shape shape = Shape::rounded_rectangle;
  double width = 1.3, height = 0.9;  ///< rounded rectangle, ellipse, lemniscate [m]
  double radius = 0.119;             ///< of corners, or of the circle [m]
  core::Point centre;                ///< of all but the following [m]
  std::vector<core::Point> points;   ///< of polyline, spline and line [m]
  bool closed = true;                ///< of polyline and spline
};

/// As files call it (core/words.h).
constexpr std::string_view word(PathSpec::Shape shape) noexcept {
  switch (shape) {
    case PathSpec::Shape::rounded_rectangle:
      return "rounded_rectangle";
    case PathSpec::Shape::circle:
      return "circle";
    case PathSpec::Shape::ellipse:
      return "ellipse";
    case PathSpec::Shape::lemniscate:
      return "lemniscate";
    case PathSpec::Shape::polyline:
      return "polyline";
    case PathSpec::Shape::spline:
      return "spline";
    case PathSpec::Shape::line:
      return "line";
  }
  return {};
}

/// The robots' places in a formation.
struct ShapeSpec {
  core::ShapeName shape = core::ShapeName::line;
  double spacing = 0.12;  ///< between neighbours [m]
  core::Shape offsets;    ///< places of their own; empty: `shape`
};

struct ReferenceChange {
  double t = 0.0, duration = 0.0;  ///< [s]
  ShapeSpec shape;                 ///< of a platoon only its spacing, along the path
};

struct ReferenceSpec {
  enum class Kind {
    platoon,      ///< all robots on one path, each behind the next
    formation,    ///< a shape about a centre that drives along the path
    independent,  ///< every robot on its own trajectory
  };
  Kind kind = Kind::platoon;
  double speed = 0.05;    ///< [m/s]
  double spacing = 0.12;  ///< of a platoon, of arc between robots [m]
  double start = 1.6;     ///< arc length at which robot 1, or the centre, starts [m]
  PathSpec path;
  ShapeSpec shape;                       ///< of a formation
  std::vector<ReferenceChange> changes;  ///< in the order of t
  double acceleration = 0.1;             ///< default for trajectories [m/s^2]
  bool may_meet = false;                 ///< of trajectories: references may meet, the shield keeps the robots apart
  bool interchangeable = false;          ///< of trajectories that are lines: their ends are reassigned to the robots
};

/// As files call it (core/words.h).
constexpr std::string_view word(ReferenceSpec::Kind kind) noexcept {
  switch (kind) {
    case ReferenceSpec::Kind::platoon:
      return "platoon";
    case ReferenceSpec::Kind::formation:
      return "formation";
    case ReferenceSpec::Kind::independent:
      return "independent";
  }
  return {};
}

/// The trajectory of one robot of an independent reference.
struct TrajectorySpec {
  PathSpec path;
  double t = 0.0;                      ///< start of the motion [s]
  double start = 0.0;                  ///< where it starts along the path [m]
  std::optional<double> speed;         ///< empty: that of the reference [m/s]
  std::optional<double> acceleration;  ///< at most; empty: that of the reference [m/s^2]
  std::optional<double> distance;  ///< from rest to rest; empty: to the end of an open path, a closed one for ever [m]
  std::optional<double> duration;  ///< instead of speed: from rest to rest [s]
  double turn_rate = 0.0;          ///< on the spot, after the arrival [rad/s]
  std::vector<core::TimedPoint> samples;  ///< instead of all this: places and their times
  std::vector<double> headings;           ///< of the samples, if the file gives them; only checked [rad]

  bool from_rest_to_rest() const noexcept { return distance || !path.closed; }
};

struct ControllerSpec {
  core::Saturation saturation = core::Saturation::tanh;
  core::Coupling coupling = core::Coupling::paper;
  double v_max = 0.1, omega_max = 1.7;
  double c_x = 20.0, c_theta = 1.0, k_y = 11.0, k = 200.0;
  core::GainPolicy policy = core::GainPolicy::authority;
  double k_x = 0.0, k_theta = 0.0;  ///< of the policy "fixed", at the start [m/s, rad/s]
  core::CouplingGains gains;        ///< of all pairs; default: those of (36)
  LawSpec law;                      ///< the law; all of the above is for (15), v_max and omega_max for all laws
};

/// From time t on, the given parameters of the couplings and the given tracking gains move to new values at a constant
/// rate within `ramp` seconds.
struct GainChange {
  double t = 0.0;
  double ramp = 1.0;
  std::array<std::optional<core::PairTable>, core::pair_names.size()> tables;  ///< in the order of core::pair_names
  core::TrackingChange tracking;                                               ///< of the policy "fixed"

  std::optional<core::PairTable>& operator[](core::GainName name) { return tables[static_cast<std::size_t>(name)]; }
  const std::optional<core::PairTable>& operator[](core::GainName name) const {
    return tables[static_cast<std::size_t>(name)];
  }
};

struct RobotSpec {
  enum class Link {
    sim,       ///< simulated, poses and wheel speeds passed on directly
    loopback,  ///< simulated behind an emulated robot on a pseudo-terminal
    device,    ///< a real robot: `address` is what comms/link_address.h reads
  };
  std::string name;  ///< as in the file of robots; empty: it has none
  int tag = 0;
  Link link = Link::sim;
  std::string address;  ///< as written in the file
  std::string adapter;  ///< Bluetooth adapter, for example "hci1"; empty: the system's choice
  /// Key `model`; default of a loopback or real robot: by the protocol of its link, usually "epuck2".
  const core::RobotType* type = &core::robot_types.front();
  core::MotorModel motor = core::MotorModel::ideal;  ///< that of the type
  double radius = core::standard_radius;             ///< that of the type unless given [m]
  /// Its own parameters of (14), (15), (18) and (30); empty: those of [controller] and [avoidance].
  std::optional<double> v_max, omega_max, c_x, c_theta, k_x, k_theta, alpha, beta, K_a, K_o;
  std::optional<std::int64_t> p;
  std::optional<TrajectorySpec> trajectory;  ///< of an independent reference
  std::optional<core::Pose> start;           ///< simulated: its initial pose; empty: its place in the formation
  /// How long after the last byte it stops by itself, measured by `robots test`; 0: never; empty: not known. [s]
  std::optional<double> watchdog;
  core::DifferentialDrive drive;  ///< keys wheel_diameter, wheel_ratio, track; the rest follows from the type
  /// From the tick to the moment at which its wheels obey, from `skein identify`; empty: that of [estimation].
  std::optional<double> actuation_delay;

  /// The true parameters of a simulated robot; empty: as assumed, `drive` and no delay.
  struct Truth {
    core::DifferentialDrive drive;
    double actuation_delay = 0.0;  ///< [s]
    /// From `at` [s, session's clock] on it ignores commands: it drives like this, or as it does at that time.
    struct Runaway {
      double at = 0.0;
      std::optional<core::Twist> twist;
    };
    std::optional<Runaway> runaway;
  };
  std::optional<Truth> truth;
  /// Whether it ignores commands at this time [s, session's clock].
  bool runs_away(double now) const noexcept { return truth && truth->runaway && now >= truth->runaway->at; }
  const core::DifferentialDrive& true_drive() const noexcept { return truth ? truth->drive : drive; }

  const std::optional<double>& own(core::TrackingGain gain) const noexcept {
    switch (gain) {
      case core::TrackingGain::k_x:
        return k_x;
      case core::TrackingGain::k_theta:
        break;
    }
    return k_theta;
  }
  /// Real or emulated: bytes go to it.
  bool has_link() const noexcept {
    switch (link) {
      case Link::sim:
        return false;
      case Link::loopback:
      case Link::device:
        return true;
    }
    return true;
  }
  bool is_real() const noexcept {
    switch (link) {
      case Link::sim:
      case Link::loopback:
        return false;
      case Link::device:
        return true;
    }
    return true;
  }
  bool simulated() const noexcept { return !is_real(); }
};

/// The kind of an experiment's camera.
enum class CameraKind {
  absent,     ///< "none": poses come directly from the simulation
  synthetic,  ///< a camera that renders the simulated robots
  recorded,   ///< a film, or pictures
  live,       ///< a camera
};
/// The kind of an address: "none", "synthetic" or one of vision::source_kinds(); empty: it is none of these.
std::optional<CameraKind> camera_kind(std::string_view source);

inline constexpr std::size_t most_cameras = 16;

struct CameraSpec {
  std::string source = "none";  ///< see `camera_kind`
  std::string calibration;      ///< path, relative to the experiment file; empty: the synthetic camera's own
  /// Settings of a real camera; NaN: unchanged. Exposure 0: automatic [s]; gain and focus in its driver's units.
  double exposure = std::numeric_limits<double>::quiet_NaN(), gain = exposure, focus = exposure;
  vision::FilmCoding film = vision::FilmCoding::lossless;  ///< how --video keeps its frames
  std::string trigger;   ///< what triggers a real camera's frames, see vision::SourceOptions; empty: its own clock
  double latency = 0.0;  ///< a frame was really captured this long before its captured_at, for any source [s]
  /// For practice: this long after the session was opened the synthetic camera is tilted by `bump` degrees, at a
  /// constant rate over `bump_time`, and stays tilted; empty: never. [s]
  std::optional<double> bump_at;
  double bump = 1.0, bump_time = 0.0;
  double raise = 0.0;  ///< and raised by so much, in the same time [m]
  /// Likewise: from then on its lens loses its focus, over `defocus_time`, until it blurs by `defocus` [s; px; s]
  std::optional<double> defocus_at;
  double defocus = 2.5, defocus_time = 0.0;
  /// Likewise: from then on the first mark of its calibration lies 50 mm farther to the right [s]
  std::optional<double> mark_moved_at;
  std::optional<double> lost_at;  ///< likewise: from then on the synthetic camera delivers nothing [s]
  /// Likewise: from then on, for `freeze_for` (empty: for ever), it delivers the picture that it had then [s; s]
  std::optional<double> freeze_at, freeze_for;
  double freeze_part = 1.0;      ///< of its height, from below
  double stamps_late = 0.0;      ///< likewise: the synthetic camera's time stamps are late by this much [s]
  std::vector<CameraSpec> also;  ///< more cameras over the same floor; empty in each of these

  CameraKind kind() const { return camera_kind(source).value_or(CameraKind::absent); }
};

/// Limits of the links to the robots, on the wall clock.
struct LinksSpec {
  /// How far a robot may drive on unconfirmed commands [m].
  double blind_distance = comms::LinkOptions{}.blind_distance;
  double reply_timeout = comms::LinkOptions{}.reply_timeout;  ///< a reply later than this counts as lost [s]
  std::optional<double> command_silence;  ///< without a new command for this long a link stops its robot [s]
};

struct EstimationSpec {
  double bridge = 0.2;                    ///< a robot whose pose is older than this is lost and stops [s]
  std::optional<double> actuation_delay;  ///< from the tick to the moment the wheels obey [s]; empty: as measured
  core::FilterParameters filter;
};

/// How robots get to their starts.
struct StagingSpec {
  bool automatic = true;   ///< before a run without a window, if a robot is farther away than `within`
  double within = 0.03;    ///< [m]
  double timeout = 120.0;  ///< the run fails if a robot has not arrived by then [s]
  bool back = false;       ///< drive to the starts after the run as well
};

/// What the group does when a robot's link is lost.
struct FailureSpec {
  enum class LinkLost {
    all_stop,      ///< STOP for all robots
    others_go_on,  ///< that robot is held, until the operator releases it
  };
  LinkLost link_lost = LinkLost::all_stop;
  enum class CameraMoved {
    all_stop,  ///< STOP for all robots
    go_on,     ///< an event reports it, and the run goes on with wrong poses
  };
  CameraMoved camera_moved = CameraMoved::all_stop;
  enum class Runaway {
    others_go_on,  ///< it is commanded to stand, and the others avoid it by its measured motion
    ignored,       ///< it is assumed to obey
  };
  Runaway runaway = Runaway::others_go_on;
  /// A link that has not been up for longer than this is lost [s]; one whose connection is gone is lost at once. Until
  /// then its robot is stopped and the others keep clear of it. Longer than the second for which an e-puck2's WiFi
  /// program may pause.
  double link_bridge = 1.5;
};

/// As files call it (core/words.h).
constexpr std::string_view word(FailureSpec::LinkLost then) noexcept {
  switch (then) {
    case FailureSpec::LinkLost::all_stop:
      return "all_stop";
    case FailureSpec::LinkLost::others_go_on:
      return "others_go_on";
  }
  return {};
}

constexpr std::string_view word(FailureSpec::CameraMoved then) noexcept {
  switch (then) {
    case FailureSpec::CameraMoved::all_stop:
      return "all_stop";
    case FailureSpec::CameraMoved::go_on:
      return "go_on";
  }
  return {};
}

constexpr std::string_view word(FailureSpec::Runaway then) noexcept {
  switch (then) {
    case FailureSpec::Runaway::others_go_on:
      return "others_go_on";
    case FailureSpec::Runaway::ignored:
      return "ignored";
  }
  return {};
}

struct Perturbation {
  double t = 0.0;
  std::size_t robot = 0;
  double dx = 0.0, dy = 0.0, dtheta = 0.0;  ///< in the world frame [m, rad]
};

/// An operator's action at the window, executed from the file: an [[operator]] table. Before the start if t is 0.
struct OperatorAction {
  double t = 0.0;
  Event event;  ///< one that `is_action`
};

/// Expected results of the run; empty: not checked.
struct Expectations {
  std::optional<double> final_error;  ///< largest position error of the last tick is at most this [m]
  std::optional<double>
      min_distance;  ///< smallest distance between two robots (true poses where known) is at least this [m]
  std::optional<double> arrived;        ///< all references rest and all robots are there by this time [s]
  std::optional<bool> formation_first;  ///< after every perturbation the formation settles (1 cm) before tracking does
  std::optional<std::int64_t> collisions;  ///< number of times two robots come closer than their radii
  std::optional<bool> inside{};            ///< no body is ever over the edge of the arena
};

struct Experiment {
  std::string name = "platoon";
  double duration = 84.0;  ///< [s]
  double rate = 25.0;      ///< ticks per second
  std::uint64_t seed = 1;
  double arena_width = 2.0, arena_height = 1.5;  ///< centred on the origin [m]
  ReferenceSpec reference;
  ControllerSpec controller;
  std::vector<GainChange> gain_changes;  ///< in the order of t
  core::AvoidanceParameters avoidance;
  core::ShieldParameters shield;
  std::vector<core::Obstacle> obstacles;
  std::vector<RobotSpec> robots;  ///< default: four simulated ones, tags 1 to 4
  CameraSpec camera;
  std::optional<double> tag_size;  ///< edge of the robots' tags, in place of the calibrations' [m]
  LinksSpec links;
  EstimationSpec estimation;
  StagingSpec staging;
  FailureSpec failure;
  core::Imperfection simulation;
  std::vector<Perturbation> perturbations;  ///< in the order of t
  std::vector<OperatorAction> actions;      ///< in the order of t
  Expectations expect;

  std::string source;     ///< the text that it was read from, with the keys changed by `--set`
  std::string directory;  ///< the file's folder; relative paths in the file start there

  /// links.command_silence, or by default 0.1 s and at least 2.5 ticks: one late tick does not stop the group.
  double command_silence() const noexcept { return links.command_silence.value_or(std::max(0.1, 2.5 * period())); }
  double period() const noexcept { return 1.0 / rate; }
  /// The cameras, from 0, [camera] first: one at least, which may be "none".
  std::size_t cameras() const noexcept { return 1 + camera.also.size(); }
  const CameraSpec& camera_at(std::size_t number) const { return number == 0 ? camera : camera.also.at(number - 1); }
  /// The file of a camera's calibration; empty: it has none (a synthetic camera has its own).
  std::string calibration_file(std::size_t number) const;
  std::int64_t ticks() const noexcept;  ///< rows that a run of the whole duration has
};

/// How messages about one of several cameras begin: "camera 2: "; nothing if it is the only one.
std::string camera_prefix(const Experiment& experiment, std::size_t number);

/// The name of a robot in messages: "robot 2", or "robot 2 (anna)".
std::string robot_name(const Experiment& experiment, std::size_t robot);

/// Why this experiment can neither be stepped nor run at any speed but real time, if so: a link or a camera runs in
/// real time.
std::optional<std::string> real_time_reason(const Experiment& experiment);

/// Make the inputs of the tick's parts.
std::shared_ptr<const core::Path> make_path(const PathSpec& path);
std::unique_ptr<const core::Trajectory> make_trajectory(const TrajectorySpec& trajectory,
                                                        const ReferenceSpec& defaults);
std::unique_ptr<const core::Reference> make_reference(const Experiment& experiment);
/// The gains at the start.
core::Gains make_gains(const Experiment& experiment);
/// The tracking gains of the policy "fixed" at the start.
core::TrackingGains make_tracking(const Experiment& experiment);
core::CommandLimits make_limits(const Experiment& experiment, std::size_t robot);
/// The parameters of (30) for robot i.
core::AvoidanceParameters make_avoidance(const Experiment& experiment, std::size_t robot);
/// The excess of each body over a standard one, for core::Sizes [m].
std::vector<double> sizes_beyond(const Experiment& experiment);

}  // namespace skein::app
