#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/geometry/pose.h"
#include "core/reference/travel.h"

namespace skein::core {

/// How fast a robot drives along a route.
struct Pace {
  double v = 0.09;             ///< along straight lines [m/s]
  double omega = 1.3;          ///< turning on the spot [rad/s]
  double acceleration = 0.55;  ///< along straight lines, at most [m/s^2]
  double alpha = 12.0;         ///< of turns, at most [rad/s^2]

  double turn_time(double angle) const noexcept;      ///< from rest to rest [s]
  double drive_time(double distance) const noexcept;  ///< from rest to rest [s]
  double start_time() const noexcept;                 ///< extra time of a start and a stop, compared to driving on [s]
};

/// One leg of a route: turn on the spot towards a point at once, wait for the time to set off, drive there.
struct Leg {
  double x = 0.0, y = 0.0;  ///< where it ends [m]
  double drives_at = 0.0;   ///< [s]
  double arrives_at = 0.0;  ///< [s]
};

/// A route that a unicycle can follow exactly: brake, then turns on the spot, waits and straight lines, each from rest
/// to rest with bounded acceleration; or lines and arcs without a stop between them. A value of fixed size: it never
/// allocates.
class Route {
 public:
  static constexpr std::size_t most_legs = 48;

  /// Stands at a pose.
  void stand(const Pose& pose) noexcept;
  /// Begins by braking from a speed [m/s].
  void brake(const Pose& pose, double v, const Pace& pace) noexcept;
  /// Where braking from there ends, and how long it takes. [s]
  static Pose stop(const Pose& pose, double v, const Pace& pace) noexcept;
  static double stop_time(double v, const Pace& pace) noexcept;
  /// Leaves out what comes after t [s], except what is needed to come to rest: the rest of a turn, or braking on a
  /// line.
  void stop_at(double t, const Pace& pace) noexcept;
  /// Appends legs; their times count from the start of the route. At the end it turns to `heading`.
  /// False if there is no room for them.
  bool append(std::span<const Leg> legs, double heading, const Pace& pace) noexcept;
  /// Turns on the spot by an angle, from rest to rest. False if there is no room for it; likewise below.
  bool turn(double angle, const Pace& pace) noexcept;
  /// Drives on along a line or an arc (counter-clockwise above 0) [m, 1/m], its speed changing evenly from v_0 to v_1,
  /// of which at least one is above 0 [m/s].
  bool roll(double length, double curvature, double v_0, double v_1) noexcept;
  /// Stands for a while. [s]
  bool wait(double seconds) noexcept;

  struct State {
    Pose pose;
    double driven = 0.0;  ///< since the start [m]
    double turned = 0.0;  ///< since the start, counter-clockwise [rad]
  };
  State at(double t) const noexcept;
  /// The position alone. [m]
  struct Position {
    double x, y;
  };
  Position position(double t) const noexcept;
  /// The same for times that never fall: `segment` is 0 at first, then the one in which the previous time was.
  Position position(double t, std::size_t& segment) const noexcept;
  /// The constant twist that leads from the pose at t to the one dt later; exact unless a turn and a drive are in one
  /// step.
  Twist twist(double t, double dt) const noexcept;
  double duration() const noexcept { return size_ == 0 ? 0.0 : segments_[size_ - 1].t + segments_[size_ - 1].duration; }
  Pose end() const noexcept { return at(duration()).pose; }

 private:
  struct Segment {
    enum class Kind { roll, turn, drive };
    Kind kind = Kind::turn;
    double t = 0.0, duration = 0.0;  // [s]
    State from;
    double amount = 0.0;          // [rad], [m]
    double curvature = 0.0;       // of a roll [1/m]
    double v = 0.0;               // that a roll begins with [m/s]
    double cos = 1.0, sin = 0.0;  // of the heading in which a straight one drives
    Travel travel{0.0, 1.0, 1.0};
  };
  void add(const Segment& segment) noexcept;
  static State at(const Segment& segment, double t) noexcept;
  static Position position(const Segment& segment, double t) noexcept;
  static double rolled(const Segment& segment, double t) noexcept;
  std::size_t segment_at(double t) const noexcept;

  std::array<Segment, 2 * most_legs + 2> segments_;
  std::size_t size_ = 0;
  Pose start_;
};

}  // namespace skein::core
