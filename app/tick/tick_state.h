#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/tick/couplings.h"
#include "app/tick/law_parameters.h"
#include "app/tick/tick_input.h"
#include "core/avoidance/avoidance.h"
#include "core/avoidance/near_robots.h"
#include "core/control/descent_watch.h"
#include "core/controllers/controller_types.h"
#include "core/controllers/kostic.h"
#include "core/estimation/camera_fusion.h"
#include "core/estimation/camera_watch.h"
#include "core/estimation/pose_filter.h"
#include "core/planning/formation_clock.h"
#include "core/planning/planner.h"
#include "core/safety/delay_watch.h"
#include "core/safety/obedience_watch.h"
#include "core/safety/progress_watch.h"

namespace skein::app {

/// What the experiment says.
struct TickSetup {
  explicit TickSetup(const Experiment& e);

  const Experiment experiment;
  core::FormationClock clock;  // part of the setup, because the reference depends on it
  const std::unique_ptr<const core::Reference> reference;
  const core::ReferenceDemand demand;
  const std::vector<std::optional<core::Pose>> ends;  // of places that come to rest
  const core::ShieldParameters shield_parameters;     // with the arena's edge
  const bool has_camera;
  const bool sees_commands;   // the camera, at work: a film shows what robots did then
  const std::size_t cameras;  // whose measurements are fused: 1 without any
  std::vector<core::CommandLimits> limits;
  const std::vector<double> beyond;  // bodies, against standard ones [m]
  const core::Sizes sizes{beyond};
  std::vector<core::AvoidanceParameters> fields;  // (30) of each robot
};

/// A wheel, as it is expected to roll, and the motion still to be made up for because a real motor runs only some
/// rates: of each direction of its own, since which way it is to turn may change from tick to tick.
struct DrivenWheel {
  core::ExpectedWheel expected;
  double owed_forwards = 0.0, owed_backwards = 0.0;  // [steps/s in one tick]

  double& owed(double wanted) noexcept { return wanted < 0.0 ? owed_backwards : owed_forwards; }
};
struct DrivenWheels {
  DrivenWheel left, right;
};

/// What a tick remembers, all of it values: a copy goes on like the original.
struct TickMemory {
  TickMemory(const Experiment& e, const core::Gains& first, const core::ReferenceDemand& demand);

  // What lasts from tick to tick.
  double last_now = none;
  double dt = 0.0;         // of the experiment, since the previous tick; 0 unless running
  double motion_dt = 0.0;  // the same of everything that drives: while staging as well
  Phase after_staging = Phase::ready;
  double staging_time = 0.0;  // time base of planned routes while staging [s]
  double stood_for = 0.0;     // at the starts, while staging [s]
  core::Gains gains;
  Couplings couplings;
  LawParameters law_parameters;
  core::ObstacleField obstacles;
  core::Avoidance avoidance;
  core::Shield shield;
  core::NearRobots near;
  core::KosticController staging_law;  // drives to the starts, whatever the run's law is
  std::vector<double> spare_log;       // of that law where another one's values are recorded
  std::vector<bool> no_number;         // the law's command was not a number at the previous tick
  ControllerState controller_state = ControllerState::answered;  // of the run's own controller
  core::DescentWatch watch;
  core::ProgressWatch progress;
  std::vector<bool> outside;  // over the edge of the arena
  std::vector<bool> had_no_way;
  double explained_until = none;  // until then V may rise: after a jump, a robot lost or found [s, session's clock]
  std::vector<core::PoseFilter> filters;
  std::vector<core::CameraWatch> camera_watch;  // of each camera
  core::CameraFusion fusion;
  std::vector<bool> seen_or_missed;  // seen, or reported lost: from then on losses and finds are reported
  std::vector<bool> held;            // made to stand by the operator, or since its link was lost
  std::vector<bool> link_lost;       // and is not back
  std::vector<bool> off_nominal;     // follows a modified reference
  std::vector<DrivenWheels> wheels;
  std::vector<double> acts_at;  // from when on the newest commands act; none: nobody is driven [s]
  std::vector<core::ObedienceWatch> obedience;
  core::DelayWatch delay_watch;
  std::size_t compared = 0;  // the robot whose motion it has seen last
  bool told_of_delay = false;

  // What lasts for one tick.
  std::vector<Eigen::Matrix3d> covariance;
  std::vector<core::Pose> poses, midway, stands;
  std::vector<core::ReferencePoint> nominal, followed;
  std::vector<core::Twist> followed_twists, law, commands;
  std::vector<core::TrackingError> errors;
  std::vector<double> v_limits;
  std::vector<double> trust;             // in a link: usually 1, less while commands are unconfirmed, 0: it has stopped
  std::vector<core::Twist> driving;      // what each does: as commanded, or where its link has stopped it as measured
  std::vector<std::uint8_t> out;         // is_out of each, for the planner and the law
  std::vector<std::uint8_t> unseen;      // lost, and out for no other reason, for the planner
  std::vector<std::uint8_t> stuck;       // stands though commanded to drive, for the planner
  std::vector<core::Obstacle> standing;  // what the shield keeps clear of: obstacles, and robots that are stuck
  std::vector<double> doubt;             // how far off each pose may be [m]
  TickRecord record;
};

/// What a tick works on: the experiment's parts, and what it remembers.
struct TickState : TickSetup, TickMemory {
  explicit TickState(const Experiment& e);

  // The stages of a tick, in their order.
  void begin(const TickInput& input) noexcept;
  void obey(const OperatorCommand& command, bool recorded) noexcept;
  void note_changes_before_start() noexcept;
  void start() noexcept;
  void pause() noexcept;
  void resume() noexcept;
  void stage() noexcept;
  /// Discards what was seen and done while nothing was recorded: otherwise a run could not be repeated from its record.
  void forget_history() noexcept {
    for (core::PoseFilter& filter : filters) filter.forget();
    for (core::CameraWatch& of_camera : camera_watch) of_camera.forget();
    for (core::ObedienceWatch& of_robot : obedience) of_robot.forget();
    for (DrivenWheels& of_robot : wheels) of_robot.left.expected.forget(), of_robot.right.expected.forget();
    fusion.forget();
    delay_watch.forget();
    told_of_delay = false;
    std::fill_n(shield_touched.get(), robots(), false);
  }
  void accept_measurements(std::size_t i, const TickInput& input) noexcept;
  void watch_cameras(const TickInput& input) noexcept;
  void watch_delay(const TickInput& input) noexcept;
  void stop_for_camera() noexcept;
  void estimate(const TickInput& input) noexcept;
  void schedule_gains() noexcept;
  void follow_reference() noexcept;
  void follow_field() noexcept;
  void follow_plan() noexcept;
  void ask_law() noexcept;
  void apply_law(const TickInput& input) noexcept;
  void limit_and_shield() noexcept;
  double blind_share(std::size_t i) const noexcept;
  void drive_wheels() noexcept;
  void account(const TickInput& input) noexcept;

  void watch_staging() noexcept;
  void watch_descent() noexcept;
  void watch_progress() noexcept;
  Hindrance hindrance(std::size_t i) const noexcept;

  bool running() const noexcept { return record.phase == Phase::running; }
  bool moving() const noexcept { return running() || (record.phase == Phase::staging && !record.paused()); }
  /// A robot that is lost or held, or whose link has stopped it, is not in the group: it is commanded to stand, and its
  /// errors do not affect the others.
  bool is_out(std::size_t i) const noexcept { return record.robots[i].is(lost) || made_to_stand(i); }
  bool made_to_stand(std::size_t i) const noexcept { return held[i] || obedience[i].disobeys() || trust[i] == 0.0; }
  void hear_links(const TickInput& input) noexcept;
  void watch_obedience(std::size_t i) noexcept;
  bool on_nominal(std::size_t i) const noexcept {
    return planner ? planner->state(i) == core::Planner::State::nominal
                   : avoidance.state(i) == core::Avoidance::State::nominal;
  }
  /// Forget what was planned or avoided.
  void forget_ways() noexcept {
    for (std::size_t i = 0; i < robots(); ++i) avoidance.reset(i);
    if (planner) planner->reset();
  }
  std::size_t robots() const noexcept { return record.robots.size(); }
  void note(const Event& event) noexcept { record.events.add(event); }

  const std::unique_ptr<core::Planner> planner;        // where the file asks for planned routes
  const std::unique_ptr<core::Controller> controller;  // the law that is built in
  bool asked = false;                                  // ask_law is done
  core::ControllerInput question;                      // its spans point into TickMemory
  std::unique_ptr<bool[]> adrift;                      // it is out, has a link or disobeys, and rolls
  std::unique_ptr<bool[]> shield_touched;
};

}  // namespace skein::app
