#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/avoidance/steering.h"
#include "core/planning/delay.h"
#include "core/planning/lattice.h"
#include "core/planning/route.h"
#include "core/planning/traffic.h"
#include "core/reference/reference.h"

namespace skein::core {

/// How a reference that is near its moving place drives on to it: it steers towards a point ahead on the place's line,
/// and speeds up or slows down until it is abreast of the place; within the bounds, forwards only, and with bounded
/// acceleration.
Twist homing(const ReferencePoint& place, const ReferencePoint& from, const ReferenceBounds& bounds,
             double dt) noexcept;

/// Finds a way for one robot back to a place that drives on: turn on the spot or drive an arc, go straight, turn or
/// drive an arc, so as to meet the place with its heading and its speed at the earliest possible moment (Dubins' paths
/// with turns on the spot, against a clock). Each way is simulated against the others' traffic, under the shield's own
/// condition; if there is no other robot near, the first way of each kind is the earliest. The robot passes others by a
/// point to the side, where it may wait, or in a lane beside them until it is abreast of its place. Allocates in its
/// constructor only.
class Merge {
 public:
  static constexpr double never = std::numeric_limits<double>::infinity();

  Merge();

  struct Query {
    std::size_t robot = 0;
    Pose from;                ///< now
    double v = 0.0;           ///< now [m/s]
    double t = 0.0;           ///< of the experiment, at the traffic's beginning [s]
    double k_y = 11.0;        ///< of (18g) [rad/m]
    Pace pace;                ///< v, and omega + k_y v: the most that (18f, g) allow without couplings
    Delay delay;              ///< of the place's clock
    double keep = 0.08;       ///< between two midpoints [m]
    double gamma = 4.0;       ///< how fast the distance beyond `keep` may shrink [1/s]
    double grace = 0.0;       ///< for this long others may come closer than that [s]
    bool crowded = true;      ///< there are others at all
    bool obstacles = true;    ///< there are obstacles and edges at all
    double stays_free = 0.0;  ///< for this long after it has joined, its place meets no obstacle, if possible [s]
    double watched = 0.0;     ///< other robots are checked for this long, even if it is at its place sooner [s]
    double before = never;    ///< no way that joins later than that [s]
    std::size_t most_work = 2000;
    double enough = 0.0;                ///< no detour by a point to the side if a straight way joins before [s]
    std::span<const double> smaller{};  ///< than `keep` is for: each body [m]; empty: none is
  };
  struct Way {
    bool found = false;
    double joins = never;  ///< when it is at its place, on the route's clock [s]
  };
  /// The earliest way, as a route from now on that follows its place for `goes_on`. `route` changes only if one was
  /// found.
  Way find(const Query& query, const Reference& reference, const Lattice& lattice, const Traffic& traffic,
           Route& route) noexcept;

  /// Work of the latest search, in nodes: about a microsecond each.
  std::size_t work() const noexcept { return courses_ / 5 + samples_ / 8; }

  static constexpr double goes_on = 0.4;  ///< for how long a route follows its place at the end [s]

 private:
  static constexpr std::size_t curve_pieces = 3, most_pieces = 13 + curve_pieces;
  struct Piece {
    double curvature, length, limit;  // [1/m], [m], [m/s]
  };
  /// How a way begins: after braking or not; then, if need be, by a point to the side, or by one abreast of the place.
  struct Start {
    bool stands = true;
    double turn = 0.0;  // on the spot, at first [rad]
    std::array<Piece, most_pieces> pieces{};
    std::size_t count = 0;
    Pose at;             // where the curve to the place begins
    double wait = 0.0;   // at first [s]
    double takes = 0.0;  // at least [s]
    bool rests = false;  // at its end, and waits there
  };
  struct Course {
    const Start* start = nullptr;
    double turn = 0.0, last_turn = 0.0;  // on the spot [rad]
    std::array<Piece, most_pieces> pieces;
    std::size_t count = 0;
    bool turns_last = false;
    double share = 1.0;  // of the speeds that could be driven
  };
  struct Trial {
    double joins;
    std::size_t start, kind;
    bool operator<(const Trial& other) const noexcept {
      return joins != other.joins   ? joins < other.joins
             : start != other.start ? start < other.start
                                    : kind < other.kind;
    }
  };
  static constexpr std::size_t bends = 5;  // none, two arcs to each side
  static constexpr std::size_t kinds = bends * bends;
  static constexpr std::size_t ring = 16, lanes = 12, most_starts = 2 + ring + 3 * lanes;
  using Speeds = std::array<double, most_pieces + 1>;

  ReferencePoint place(double t) const noexcept;
  double stands_until() noexcept;
  void find_ways_into_obstacles() noexcept;
  /// On the spot; only from rest.
  static bool turns_at_its_end(const Start& start) noexcept { return start.count == 0 || start.rests; }
  bool plan(const Start& start, std::size_t kind, const ReferencePoint& place, double latest, Course& course) noexcept;
  double duration(const Course& course, const ReferencePoint& place) const noexcept;
  bool speeds(const Course& course, double v_1, Speeds& u) const noexcept;
  bool lay(const Course& course, const ReferencePoint& place, double wait, Route& route) const noexcept;
  bool clear(const Route& route, double joins, double until) noexcept;
  bool begins_clear(const Start& start) noexcept;
  bool come_beside(const Start& from, double back, double aside, double after, Start& start) noexcept;
  bool clear(std::size_t k, const Route::Position& before, const Route::Position& here) const noexcept;
  Route::Position place_at_sample(std::size_t k) noexcept;
  bool search(std::size_t first, std::size_t last, bool few, std::size_t most, Way& best, Route& route) noexcept;
  bool try_at(const Trial& trial, Way& best, Route& route) noexcept;
  void go_aside() noexcept;
  void go_abreast(std::size_t direct, std::size_t most) noexcept;
  void overtake(std::size_t direct, std::size_t most) noexcept;
  double was_nearest() const noexcept;
  Pose beside(double t, double aside, double back) const noexcept;
  bool come_to(const Start& from, const Pose& to, double before, Start& start) noexcept;
  void follow_lane(double t, double aside, Start start) noexcept;
  void go_past_obstacle(std::size_t direct, std::size_t most) noexcept;
  void begin_beside(std::size_t direct, std::size_t end, std::size_t most, double back, double aside,
                    double after) noexcept;

  Query query_;
  const Reference* reference_ = nullptr;
  const Lattice* lattice_ = nullptr;
  const Traffic* traffic_ = nullptr;
  Pose stop_;
  double stops_ = 0.0, stands_until_ = never;          // [s]
  double shrinks_ = 1.0;                               // what is left over what is to be kept, in a step of the traffic
  std::array<Route::Position, Traffic::steps> place_;  // at the traffic's samples
  std::array<std::uint8_t, Traffic::steps> knows_place_{};
  std::array<double, bends> curvatures_{};
  std::array<Start, most_starts> starts_;
  std::size_t start_count_ = 0;
  std::array<double, most_starts * kinds> next_{};  // when each kind is tried again [s]
  std::array<std::size_t, most_starts * kinds> tries_{};
  std::vector<Trial> trials_;
  Route laid_;
  std::size_t courses_ = 0, samples_ = 0;

  static constexpr double look_ahead = 40.0;  // [s]
  static constexpr double time_step = 0.25;   // [s]
  static constexpr auto times = static_cast<std::size_t>(look_ahead / time_step) + 1;
  std::array<std::uint8_t, 2 * times> free_at_{};          // of obstacles, the place after that many time steps
  std::array<std::uint8_t, times> leads_into_obstacle_{};  // at that many time steps, or soon after
  bool lane_blocked_ = false;                              // at any of them
  double lane_free_from_ = 0.0;                            // behind the first obstacle [s]
};

}  // namespace skein::core
