#pragma once

#include <QImage>
#include <QPointF>
#include <QString>
#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "ui/base/circumstances.h"
#include "ui/base/modes.h"

namespace skein::ui {

/// Where a robot has been: times of the experiment, so that a pause does not wipe it out.
struct TrailPoint {
  double t, x, y;
  bool jump;  ///< it was carried here by hand: no line from the previous point
};

/// A run that this one is compared with, at the same time: where its robots have been; the last pose is where they are.
struct OtherRun {
  std::size_t number = 0;  ///< among the compared runs; determines its letter and line style
  std::vector<std::vector<core::Pose>> trails;
};

/// What the arena shows: the experiment, the newest record, and what the operator is about to do.
struct ArenaScene {
  static constexpr double trail_seconds = 20.0;

  app::Experiment experiment;
  std::optional<app::TickRecord> record;
  std::vector<std::vector<core::Pose>> lines;  ///< what the reference drives along
  std::vector<std::deque<TrailPoint>> trails;  ///< of every robot, oldest first

  Circumstances circumstances;  ///< with the obstacles
  /// Of robots i < j at i * robots + j: the coupling's strength, the mean of its gains' shares of their limits.
  std::vector<double> couplings;

  /// Whether couplings are drawn: not if the law has none.
  bool draws_couplings() const { return show_couplings && experiment.controller.law.uses_gains(); }

  /// With more than 30 robots, only those of neighbours and of the selected robot: too many lines cannot be told apart.
  bool draws_coupling(std::size_t i, std::size_t j) const;

  std::vector<std::size_t> may_be_driving;  ///< robots that have not acknowledged their stop

  std::vector<OtherRun> compared;
  std::vector<std::vector<core::Pose>> foreseen;  ///< of every robot, the next seconds; empty: not requested

  bool show_picture = false, show_regions = true, show_trails = true, show_couplings = true, show_grid = true;
  QImage picture;
  double pictured_at = app::none;  ///< on the session's clock [s]

  /// What is written over a picture that does not show the floor as it is; empty: it does.
  QString old_picture() const;

  int selected = -1, hovered = -1;  ///< robots from 0
  struct Ghost {
    int robot;
    core::Pose pose;
  };
  std::optional<Ghost> ghost;  ///< where a robot that is being dragged would be put
  struct Kick {
    int robot;
    QPointF way, velocity;  ///< the arrow out of the robot [m], and what it stands for [m/s]
  };
  std::optional<Kick> kick;
  struct GhostObstacle {
    int number;  ///< -1: a new one
    core::Obstacle obstacle;
    bool leaves;  ///< if released here, it is removed
  };
  std::optional<GhostObstacle> ghost_obstacle;
  struct Ruler {
    QPointF from, to;  ///< on the floor [m]
  };
  std::optional<Ruler> ruler;
  int selected_obstacle = -1;
  /// Where the keyboard points: a place on the floor, or the robot (from 0) that it goes with.
  struct Cross {
    QPointF at;  ///< [m]
    int robot = -1;
  };
  std::optional<Cross> cross;
  bool has_keys = false;  ///< the arena has the focus, and came to it by a key
  std::optional<std::array<int, 2>> hovered_coupling;
  QString banner;  ///< across the top: "STOPPED by operator"
  bool banner_alarms = false;
  QString alert;  ///< a warning or an alarm that lasts, below the banner
  QColor alert_colour;
  QString hint;                 ///< at the bottom: what can be done here
  bool hint_gives_way = false;  ///< where it would hide a robot

  void reset(const app::Experiment& of);
  void show_record(const app::TickRecord& record);

  /// Where robot i is: the truth where there is one, else the pose that the law used. Empty: never seen.
  std::optional<core::Pose> pose(std::size_t i) const;
  /// How large robot i's body is [m].
  double radius(std::size_t i) const { return i < experiment.robots.size() ? experiment.robots[i].radius : 0.0; }
  /// Where the keyboard's cross is on the floor [m].
  QPointF cross_at() const;
  /// The robot whose centre is nearest to this point of the floor and within `reach` [m], or, if `bodies`, on whose
  /// body the point lies; -1: none.
  int robot_at(double x, double y, double reach, bool bodies) const;
  /// The obstacle on this point of the floor, or -1.
  int obstacle_at(double x, double y) const;
  /// The line that stands for the coupling of two robots, on the floor: straight for neighbours, else an arc, so that
  /// it does not hide behind those between them; `scale` [px/m] says how fine. Empty: one of them was never seen.
  std::vector<QPointF> coupling_line(std::size_t i, std::size_t j, double scale) const;
  /// Robot i is not coupled to any robot now: it is lost, or it is held while the others drive.
  bool is_out_of_group(std::size_t i) const;
  bool is_held(std::size_t i) const { return circumstances.held.contains(static_cast<int>(i)); }
  /// How robot i looks now.
  ModeStyle style_of(std::size_t i, const Colours& colours) const;
  void forget_gesture() { ghost.reset(), kick.reset(), ghost_obstacle.reset(); }
};

}  // namespace skein::ui
