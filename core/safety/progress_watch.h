#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/geometry/pose.h"

namespace skein::core {

/// Detects robots that make no progress towards their places, whatever the cause. Progress means to come nearer to the
/// place, or to where the place will finally rest, or to move along a planned route: the place itself may drive away
/// meanwhile. A route on which the reference drives and the robot does not is no progress, however often it begins
/// anew. Part of the tick: allocates in its constructor only.
class ProgressWatch {
 public:
  explicit ProgressWatch(std::size_t robots) : robots_(robots) {}

  struct Away {
    double from_place;     ///< where the robot is to be now [m]
    double from_end;       ///< where its place will finally rest [m]; NaN: it drives on
    double along_a_route;  ///< time that its planned route still takes [s]; NaN: it has none
    Pose at{};             ///< where the robot is
    bool waits = false;    ///< its route has it stand for now, until others have passed
  };

  /// One tick: robot i is so far away and has been driven for `dt` [s]. True once when it has made no progress for
  /// `patience`, or has gone to and fro for `long_patience`; true again only after it has been nearer than ever, or at
  /// its place.
  bool stuck(std::size_t i, const Away& away, double dt) noexcept {
    Robot& robot = robots_[i];
    if (away.from_place < at_its_place) {
      robot = {};
      return false;
    }
    // What it moved before a route is no progress along it.
    if (std::isnan(away.along_a_route)) robot.route = {}, robot.at = away.at;
    const bool runs = robot.route.nears(away.along_a_route, progress_on_route);
    const bool gets_on = runs && (away.waits || has_moved(robot, away.at));
    // Each of them keeps account of its distance: none may be left out because another one says yes.
    const bool nears_place = robot.place.nears(away.from_place, progress);
    const bool nears_end = robot.end.nears(away.from_end, progress);
    const bool beats_place = robot.place.beats(away.from_place);
    const bool beats = robot.end.beats(away.from_end) || beats_place;
    const bool nears = nears_place || nears_end;
    if (gets_on || nears) robot.at = away.at;
    const bool falls_behind = robot.place.falls_behind(away.from_place);
    robot.waited = gets_on || nears ? 0.0 : robot.waited + dt;
    robot.unbeaten = gets_on || beats || falls_behind ? 0.0 : robot.unbeaten + dt;
    if (gets_on || beats) robot.told = false;
    // A nanosecond: dt is a quotient, and the patience a whole number of ticks.
    if (robot.told || (robot.waited < patience - 1e-9 && robot.unbeaten < long_patience - 1e-9)) return false;
    return robot.told = true;
  }
  /// Robot i was moved by hand: restarts its time without progress.
  void restart(std::size_t i) noexcept { robots_[i] = {}; }

  static constexpr double patience = 3.0;           ///< [s]
  static constexpr double long_patience = 10.0;     ///< with a robot that comes nearer again and again [s]
  static constexpr double progress = 0.01;          ///< that counts [m]
  static constexpr double progress_on_route = 0.3;  ///< that counts, if the robot has also moved by `progress`, [s]
  static constexpr double turn = 0.2;               ///< or turned by so much [rad]
  static constexpr double at_its_place = 0.02;      ///< a robot this near to its place is not stuck [m]

 private:
  static constexpr double never = std::numeric_limits<double>::infinity();
  static constexpr double fell_behind = 0.05;  // so much farther than ever: its record counts from here [m]

  /// How one distance develops. NaN is no progress.
  struct Approach {
    double farthest = 0.0;  // since it was last nearer by as much as counts
    double record = never, worst = 0.0;

    bool nears(double distance, double enough) noexcept {
      farthest = std::fmax(farthest, distance);
      if (!(distance < farthest - enough)) return false;
      farthest = distance;
      return true;
    }
    bool beats(double distance) noexcept {
      if (!(distance < record - progress)) return false;
      record = distance;
      worst = std::fmax(worst, distance);
      return true;
    }
    bool falls_behind(double distance) noexcept {
      if (!(distance > worst + fell_behind)) return false;
      record = worst = distance;
      return true;
    }
  };
  struct Robot {
    Approach place, end, route;
    Pose at{never, 0.0, 0.0};             // when it last made progress along a route
    double waited = 0.0, unbeaten = 0.0;  // [s]
    bool told = false;
  };
  static bool has_moved(const Robot& robot, const Pose& to) noexcept {
    return !(distance(robot.at, to) < progress && std::abs(wrap_angle(to.theta - robot.at.theta)) < turn);
  }
  std::vector<Robot> robots_;
};

}  // namespace skein::core
