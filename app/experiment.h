#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/avoidance/avoidance.h"
#include "core/control/gain_schedule.h"
#include "core/control/gains.h"
#include "core/estimation/pose_filter.h"
#include "core/kinematics/step_rate.h"
#include "core/reference/formation.h"
#include "core/reference/trajectory.h"
#include "core/safety/limits.h"
#include "core/safety/shield.h"
#include "core/simulation/simulated_robot.h"

namespace skein::app {

/// What an experiment file says (docs: `skein check`, CONTRACT of keys in docs/experiment-file.md). SI units; robots
/// counted from 0 here, from 1 in files, logs and windows. Every default is the paper's case study.

struct PathSpec {
  enum class Shape { rounded_rectangle, circle, ellipse, lemniscate, polyline, spline, line };
  Shape shape = Shape::rounded_rectangle;
  double width = 1.3, height = 0.9;  ///< rounded rectangle, ellipse, lemniscate [m]
  double radius = 0.119;             ///< of corners, or of the circle [m]
  core::Point centre;                ///< of all but the following [m]
  std::vector<core::Point> points;   ///< of polyline, spline and line [m]
  bool closed = true;                ///< of polyline and spline
};

/// The robots' places in a formation.
struct ShapeSpec {
  core::ShapeName shape = core::ShapeName::line;
  double spacing = 0.12;  ///< between neighbours [m]
  core::Shape offsets;    ///< places of their own; empty: `shape`
};

struct ReferenceChange {
  double t = 0.0, duration = 0.0;  ///< [s]
  ShapeSpec shape;
};

struct ReferenceSpec {
  enum class Kind {
    platoon,      ///< all robots on one path, each a distance behind the next
    formation,    ///< a shape about a centre that drives along the path
    independent,  ///< every robot on a trajectory of its own
  };
  Kind kind = Kind::platoon;
  double speed = 0.05;    ///< [m/s]
  double spacing = 0.12;  ///< of a platoon, of arc between robots [m]
  double start = 1.6;     ///< arc length at which robot 1, or the centre, begins [m]
  PathSpec path;
  ShapeSpec shape;                       ///< of a formation
  std::vector<ReferenceChange> changes;  ///< of a formation, in the order of t
  double acceleration = 0.1;             ///< of trajectories that say nothing else [m/s^2]
  bool may_meet = false;                 ///< of trajectories: the shield is to keep robots apart whose references meet
};

/// How one robot drives, where every robot has a trajectory of its own.
struct TrajectorySpec {
  PathSpec path;
  double t = 0.0;                      ///< sets off [s]
  double start = 0.0;                  ///< where it begins, along the path [m]
  std::optional<double> speed;         ///< empty: that of the reference [m/s]
  std::optional<double> acceleration;  ///< at most; empty: that of the reference [m/s^2]
  std::optional<double> distance;  ///< from rest to rest; empty: to the end of an open path, a closed one for ever [m]
  std::optional<double> duration;  ///< instead of speed: from rest to rest [s]
  double turn_rate = 0.0;          ///< on the spot, after the arrival [rad/s]

  bool from_rest_to_rest() const noexcept { return distance || !path.closed; }
};

struct ControllerSpec {
  core::Saturation saturation = core::Saturation::tanh;
  core::Coupling coupling = core::Coupling::paper;
  double v_max = 0.1, omega_max = 1.7;
  double c_x = 20.0, c_xx = 1.5, l_xx = 100.0;
  double c_theta = 1.0, c_tt = 0.04, l_tt = 100.0;
  double c_yy = 1.5, k_y = 11.0, k = 200.0;
  core::CouplingGains gains;  ///< (36): 0.008, 0.025, 0.08
};

/// From time t on, the given gains move to new values at a constant rate within `ramp` seconds.
struct GainChange {
  double t = 0.0;
  double ramp = 1.0;
  std::optional<core::PairTable> k_xx, k_tt, k_yy;
};

struct RobotSpec {
  enum class Link {
    sim,       ///< simulated, poses and wheel speeds handed over directly
    loopback,  ///< simulated behind an emulated e-puck on a pseudo-terminal
    device,    ///< a real robot: `address` is "rfcomm:ADDR/CHANNEL", "serial:/dev/..." or "tcp:HOST:PORT"
  };
  int tag = 0;
  Link link = Link::sim;
  std::string address;  ///< as written in the file
  std::string adapter;  ///< Bluetooth adapter, for example "hci1"; empty: the system's choice
  core::MotorModel motor = core::MotorModel::ideal;  ///< key `model`; of a loopback or real robot "epuck2" unless given
  core::DifferentialDrive drive;                     ///< keys wheel_diameter, track; max_step_rate follows from `model`
  std::optional<TrajectorySpec> trajectory;          ///< of an independent reference

  bool simulated() const noexcept { return link != Link::device; }
};

struct CameraSpec {
  std::string source = "none";  ///< "none" | "synthetic" | "v4l2:DEV" | "video:FILE" | "images:DIR"
  std::string calibration;      ///< path, relative to the experiment file; empty: the synthetic camera's own
};

struct EstimationSpec {
  double bridge = 0.2;                    ///< a pose older than this is no pose: the robot is lost and stops [s]
  std::optional<double> actuation_delay;  ///< from the tick to the moment the wheels obey [s]; empty: as measured
  core::FilterParameters filter;
};

struct Perturbation {
  double t = 0.0;
  std::size_t robot = 0;
  double dx = 0.0, dy = 0.0, dtheta = 0.0;  ///< in the world frame [m, rad]
};

/// What the run must show; empty: not asked for.
struct Expectations {
  std::optional<double> final_error;  ///< largest position error of the last tick is at most this [m]
  std::optional<double>
      min_distance;  ///< smallest distance between two robots (true poses where known) is at least this [m]
  std::optional<bool> formation_first;  ///< after every perturbation the formation settles (1 cm) before tracking does
  std::optional<std::int64_t> collisions;  ///< number of times two robots come closer than 70 mm
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
  EstimationSpec estimation;
  core::Imperfection simulation;
  std::vector<Perturbation> perturbations;  ///< in the order of t
  Expectations expect;

  std::string source;     ///< the text it was read from, `--set` included as the keys it changed
  std::string directory;  ///< where the file lies; relative paths inside start there

  double period() const noexcept { return 1.0 / rate; }
  std::int64_t ticks() const noexcept;  ///< rows that a run of the whole duration has
};

/// What the tick's parts are made of.
std::shared_ptr<const core::Path> make_path(const PathSpec& path);
std::unique_ptr<const core::Trajectory> make_trajectory(const TrajectorySpec& trajectory,
                                                        const ReferenceSpec& defaults);
std::unique_ptr<const core::Reference> make_reference(const Experiment& experiment);
core::Gains make_gains(const Experiment& experiment);
core::CommandLimits make_limits(const Experiment& experiment, std::size_t robot);

}  // namespace skein::app
