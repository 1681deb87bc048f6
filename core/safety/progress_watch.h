#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/geometry/pose.h"

namespace skein::core {

/// Detects robots that make no progress towards their places, whatever the cause. Progress means to come nearer to the
/// place, or to where the place will finally rest, or to move along a planned route: the place itself may drive away
/// meanwhile. A route on which the reference drives and the robot does not is no progress, however often it begins
/// anew. Nor is a route to a place that drives on, if the robot should long have been there by the first of its routes:
/// it drives along beside a place that it never reaches. Part of the tick: allocates in its constructor only.
class ProgressWatch {
 public:
  explicit ProgressWatch(std::size_t robots) : robots_(robots) {}

  struct Away {
    double from_place;        ///< where the robot is to be now [m]
    double from_end;          ///< where its place will finally rest [m]; NaN: it drives on
    double along_a_route;     ///< time that its planned route still takes [s]; NaN: it has none
    Pose at{};                ///< where the robot is
    double from_wait = none;  ///< where its route has it stand for now, until others have passed [m]; NaN: it drives
    bool drives_on = false;   ///< its place never rests
  };

  /// One tick: robot i is so far away and has been driven for `dt` [s]. True once when it has made no progress for
  /// `patience`, or has gone to and fro for `long_patience`; true again only after it has been nearer than ever, or at
  /// its place. True once also when it is `long_patience` late for a place that drives on.
  bool stuck(std::size_t i, const Away& away, double dt) noexcept {
    Robot& robot = robots_[i];
    if (away.from_place < at_its_place) {
      robot = {};
      return false;
    }
    robot.follow_route(away, dt);
    robot.remember(away, dt);
    const bool runs = robot.lately([&](const Moment& then) { return robot.ran - then.ran > progress_on_route; });
    const bool waits = runs && away.from_wait < at_its_place;
    const bool gets_on =
        waits || (runs && robot.lately([&](const Moment& then) { return far(then.on_route, robot.on_route); }));
    const bool nears = robot.lately([&](const Moment& then) {
      return then.place - away.from_place > progress || then.end - away.from_end > progress;
    });
    // Each of them keeps account of its distance: none may be left out because another one says yes.
    const bool beats_place = robot.place.beats(away.from_place);
    const bool beats = robot.end.beats(away.from_end) || beats_place;
    const bool falls_behind = robot.place.falls_behind(away.from_place);
    robot.watched = waits ? 0.0 : robot.watched + dt;
    robot.unbeaten = gets_on || beats || falls_behind ? 0.0 : robot.unbeaten + dt;
    if (gets_on || beats) robot.told = false;
    if (away.drives_on && robot.is_overdue(away.along_a_route, dt)) return robot.told = true;
    // A nanosecond: dt is a quotient, and the patience a whole number of ticks.
    const bool stands = !gets_on && !nears && robot.watched >= patience - 1e-9;
    if (robot.told || (!stands && robot.unbeaten < long_patience - 1e-9)) return false;
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
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  static constexpr double never = std::numeric_limits<double>::infinity();
  static constexpr double fell_behind = 0.05;  // so much farther than ever: its record counts from here [m]

  /// The nearest that a robot has been. NaN is no progress.
  struct Record {
    double nearest = never, worst = 0.0;

    bool beats(double distance) noexcept {
      if (!(distance < nearest - progress)) return false;
      nearest = distance;
      worst = std::fmax(worst, distance);
      return true;
    }
    bool falls_behind(double distance) noexcept {
      if (!(distance > worst + fell_behind)) return false;
      nearest = worst = distance;
      return true;
    }
  };
  /// A part of the last `patience`.
  struct Moment {
    double place = none, end = none;  // the farthest in it [m]
    double ran = none;                // at its beginning, see Robot
    Pose on_route{none, none, none};  // at its beginning, see Robot
  };
  struct Robot {
    static constexpr std::size_t moments = 30;
    std::array<Moment, moments> past{};  // from past[newest + 1], the oldest, to past[newest]
    std::size_t newest = 0;
    double in_newest = 0.0;        // [s]
    double ran = 0.0;              // how long its planned routes have run, all of them together [s]
    double along_a_route = none;   // at the last tick [s]
    Pose at{none, none, none};     // at the last tick
    Pose on_route{0.0, 0.0, 0.0};  // the sum of its motions along routes; motion without a route does not count
    Record place, end;
    double watched = 0.0, unbeaten = 0.0;  // [s]
    double due_in = none;                  // when its first route would have had it at its place [s]
    bool told = false, told_late = false;

    bool is_overdue(double route, double dt) noexcept {
      due_in = std::isnan(due_in) ? route : due_in - dt;
      if (told_late || !(due_in < -long_patience)) return false;
      return told_late = true;
    }
    void follow_route(const Away& away, double dt) noexcept {
      // NaN where there is no route, or was none at the last tick. A shorter route that is new has not run.
      const double less = along_a_route - away.along_a_route;
      if (!std::isnan(less) && !std::isnan(at.x)) {
        ran += std::clamp(less, 0.0, dt);
        on_route.x += away.at.x - at.x;
        on_route.y += away.at.y - at.y;
        on_route.theta += wrap_angle(away.at.theta - at.theta);
      }
      along_a_route = away.along_a_route;
      at = away.at;
    }
    void remember(const Away& away, double dt) noexcept {
      constexpr double length = patience / moments;
      if (std::isnan(past[newest].ran)) past[newest] = {none, none, ran, on_route};
      for (in_newest = std::min(in_newest + dt, patience); in_newest >= length; in_newest -= length) {
        newest = (newest + 1) % moments;
        past[newest] = {none, none, ran, on_route};
      }
      past[newest].place = std::fmax(past[newest].place, away.from_place);
      past[newest].end = std::fmax(past[newest].end, away.from_end);
    }
    /// Whether it holds at one of the moments, oldest first.
    template <typename Holds>
    bool lately(Holds&& holds) const noexcept {
      for (std::size_t k = 1; k <= moments; ++k)
        if (holds(past[(newest + k) % moments])) return true;
      return false;
    }
  };
  static bool far(const Pose& from, const Pose& to) noexcept {
    return distance(from, to) >= progress || std::abs(to.theta - from.theta) >= turn;
  }
  std::vector<Robot> robots_;
};

}  // namespace skein::core
