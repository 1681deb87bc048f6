#include "app/experiment/experiment_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/experiment/experiment_keys.h"
#include "app/experiment/experiment_path.h"
#include "app/experiment/experiment_robots.h"
#include "app/experiment/experiment_trajectory.h"
#include "app/experiment/longest.h"
#include "app/experiment/ways.h"
#include "app/run/number_text.h"
#include "core/math/elementary.h"
#include "core/planning/assignment.h"

namespace skein::app {
namespace {

using Kind = ReferenceSpec::Kind;
using PathShape = PathSpec::Shape;

/// A shape by name, or the robots' own places.
void read_shape(TomlTable& t, ShapeSpec& shape, std::size_t robots) {
  t.choice("shape", shape.shape);
  t.number("spacing", shape.spacing, above(0.0, longest_length, "m"));
  shape.offsets.clear();
  const bool counted = t.sound("robot");
  read_points(t, "offsets", shape.offsets, counted ? robots : 1, counted ? robots : most_robots);
  if (!t.has("offsets")) t.require("shape", "the formation's shape, or offsets = [[x, y], ...] for every robot");
  if (t.has("offsets") && t.has("shape"))
    t.refuse("offsets", *t.node("offsets"), "only one of shape and offsets, since both place the robots");
}

void read_changes(TomlTable& t, Experiment& e, Problems& problems) {
  std::size_t k = 0;
  double free_from = 0.0;
  for (TomlTable& c : t.tables("change")) {
    ReferenceChange change;
    change.shape.spacing = e.reference.shape.spacing;
    c.require("t", "the time in s at which the shape begins to change");
    c.number("t", change.t, between(0.0, longest_run, "s"));
    c.require("duration", "how long the change takes in s");
    c.number("duration", change.duration, above(0.0, longest_run, "s"));
    if (e.reference.kind == Kind::platoon) {
      c.require("spacing", "the new spacing in m, along the path");
      c.number("spacing", change.shape.spacing, above(0.0, longest_length, "m"));
    } else {
      read_shape(c, change.shape, e.robots.size());
    }
    c.finish();
    const auto sound = [&](std::size_t i, const char* key) {
      return problems.sound({fmt::format("reference.change.{}.{}", i, key)});
    };
    if (++k > 1 && change.t < free_from && sound(k, "t") && sound(k - 1, "t") && sound(k - 1, "duration"))
      problems.add(
          fmt::format("reference.change.{}.t", k),
          fmt::format("found {}, allowed: {:.6g} and later, when the previous change is over", change.t, free_from));
    free_from = change.t + change.duration;
    e.reference.changes.push_back(std::move(change));
  }
}

/// Calls `visit` with the moments at which anything can be different: of a formation every change, and a lap with every
/// shape, as far as it lasts; of trajectories the whole run, or until all are at rest.
template <typename Visit>
void for_each_moment(const Experiment& e, const core::Reference& reference, Visit&& visit) {
  if (e.reference.kind == Kind::independent) {
    constexpr double way = 0.002;  // [m]: as finely as a platoon's path is looked at
    constexpr double most_moments = 20000;
    const double end = std::min(e.duration, last_arrival(e));
    const double moments = std::clamp(std::ceil(end * reference.demand(0.0).v / way), 1.0, most_moments);
    for (int k = 0; k <= static_cast<int>(moments); ++k) visit(end * k / moments);
    return;
  }
  constexpr int samples = 1000;
  const double lap = e.reference.speed > 0.0 ? make_path(e.reference.path)->length() / e.reference.speed : 0.0;
  const auto between_times = [&](double from, double to) {
    for (int k = 0; k <= samples; ++k) visit(from + (to - from) * k / samples);
  };
  double from = 0.0;
  for (const ReferenceChange& change : e.reference.changes) {
    between_times(from, std::min(from + lap, change.t));
    from = change.t + change.duration;
    between_times(change.t, from);
  }
  between_times(from, from + lap);
}

/// Two references at one moment.
struct Offset {
  double dx, dy;  ///< [m]
  std::size_t i, j;
  double t;              ///< of a platoon, which is looked at along its path, 0 [s]
  double spacing = 0.0;  ///< of a platoon [m]
};

/// Calls `visit` with the offset between two references: every pair, all along the path.
template <typename Visit>
void for_each_offset(const Experiment& e, const core::Reference& reference, Visit&& visit) {
  if (e.reference.kind == Kind::platoon) {
    constexpr int samples = 2000;  // 2 mm on the paper's path
    const auto path = make_path(e.reference.path);
    std::vector<double> spacings{e.reference.spacing};
    constexpr int between = 8;  // the spacings on the way to another one
    for (const ReferenceChange& change : e.reference.changes)
      for (int k = 1; k <= between; ++k)
        spacings.push_back(spacings.back() + (change.shape.spacing - spacings.back()) / (between + 1 - k));
    for (const double spacing : spacings)
      for (int k = 0; k < samples; ++k) {
        const double s = path->length() * k / samples;
        const core::Pose ahead = path->at(s).pose;
        for (std::size_t j = 1; j < e.robots.size(); ++j) {
          const core::Pose behind = path->at(s - static_cast<double>(j) * spacing).pose;
          visit(Offset{ahead.x - behind.x, ahead.y - behind.y, 0, j, 0.0, spacing});
        }
      }
    return;
  }
  std::vector<core::ReferencePoint> points(e.robots.size());
  const auto all_pairs = [&](double t) {
    reference.at(t, points);
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = i + 1; j < points.size(); ++j)
        visit(Offset{points[i].pose.x - points[j].pose.x, points[i].pose.y - points[j].pose.y, i, j, t});
  };
  if (!e.reference.may_meet) return for_each_moment(e, reference, all_pairs);
  all_pairs(0.0);  // between their start and their rest the shield keeps robots apart
  if (const double end = last_arrival(e); end < e.duration) all_pairs(end);
}

double largest_radius(const Experiment& e) {
  double largest = 0.0;
  for (const RobotSpec& robot : e.robots) largest = std::max(largest, robot.radius);
  return largest;
}

void check_arena(const Experiment& e, const core::Reference& reference, Problems& problems) {
  const PathSpec& path = e.reference.path;
  double room = 2.0 * largest_radius(e);
  const bool circle = path.shape == PathShape::circle;
  if (e.reference.kind == Kind::platoon && path.centre == core::Point{} && path.shape != PathShape::polyline &&
      path.shape != PathShape::spline) {
    const double width = circle ? 2.0 * path.radius : path.width, height = circle ? 2.0 * path.radius : path.height;
    if (width + room > e.arena_width || height + room > e.arena_height)
      problems.add("reference.path",
                   fmt::format("found a path of {:.6g} m x {:.6g} m, allowed: up to {:.6g} m x {:.6g} m, "
                               "the arena less a robot's width of {} m",
                               width, height, e.arena_width - room, e.arena_height - room, room));
    return;
  }
  core::Pose farthest;
  double outside = 0.0;
  std::size_t who = 0;
  const bool of_all = e.reference.kind == Kind::platoon;
  const auto see = [&](const core::Pose& pose, std::size_t robot) {
    const double wide = of_all ? room : 2.0 * e.robots[robot].radius;
    const double by =
        std::max(std::abs(pose.x) - 0.5 * (e.arena_width - wide), std::abs(pose.y) - 0.5 * (e.arena_height - wide));
    if (by > outside) outside = by, farthest = pose, who = robot;
  };
  if (e.reference.kind == Kind::platoon) {
    for (const core::Pose& pose : core::sampled(*make_path(path), 2000)) see(pose, 0);
  } else {
    for_each_moment(e, reference, [&](double t) {
      for (std::size_t i = 0; i < e.robots.size(); ++i) see(reference.at(i, t).pose, i);
    });
  }
  const bool own = e.reference.kind == Kind::independent;
  if (e.reference.kind != Kind::platoon) room = 2.0 * e.robots[who].radius;
  const double x_most = 0.5 * (e.arena_width - room), y_most = 0.5 * (e.arena_height - room);
  if (outside > 0.0)
    problems.add(
        own ? fmt::format("robot.{}.trajectory", who + 1) : "reference.path",
        fmt::format("found a place ({}, {}) m that a robot reaches, allowed: from -{:.6g} to {:.6g} m "
                    "along x, -{:.6g} to {:.6g} m along y, the arena less a robot's width of {} m",
                    significant(farthest.x, 4), significant(farthest.y, 4), x_most, x_most, y_most, y_most, room));
}

constexpr double leaves_at = 1.1;  // a detection region once entered is left only at this times its size

/// The conditions of a robot's body and its detection region on an offset. Computed once: there are hundreds of
/// thousands of offsets.
class Rooms {
 public:
  explicit Rooms(const Experiment& e) : platoon_(e.reference.kind == Kind::platoon) {
    const std::size_t n = e.robots.size();
    for (const RobotSpec& robot : e.robots) beyond_.push_back(robot.radius - core::standard_radius);
    for (std::size_t apart = 0; apart < n; ++apart) {
      most_beyond_.push_back(-std::numeric_limits<double>::infinity());
      for (std::size_t i = 0; i + apart < n; ++i)
        most_beyond_.back() = std::max(most_beyond_.back(), beyond_[i] + beyond_[i + apart]);
    }
    for (std::size_t i = 0; i < n; ++i) {
      regions_.push_back(make_avoidance(e, i));
      const auto same = [&](const core::AvoidanceParameters& other) {
        return other.alpha == regions_.back().alpha && other.beta == regions_.back().beta;
      };
      if (std::none_of(different_.begin(), different_.end(), same)) different_.push_back(regions_.back());
    }
  }

  /// How much more room the bodies of the two need than two standard ones [m]. Along a path the offset is that of any
  /// two robots so many places apart.
  double more(const Offset& at) const { return platoon_ ? most_beyond_[at.j] : beyond_[at.i] + beyond_[at.j]; }

  /// Whether two bodies that are so far apart, as if both were standard ones, neither touch nor set off the shield.
  static bool apart(const Experiment& e, double distance) {
    return distance > core::standard_radius + core::standard_radius &&
           (!e.shield.enabled || distance > e.shield.distance);
  }

  /// How far inside the larger of the two robots' detection regions the other one is: at most 1 inside; farther out,
  /// anything above 1.
  double level(const Offset& at) const {
    double least = std::numeric_limits<double>::infinity();
    const double by = more(at), dx = at.dx / leaves_at, dy = at.dy / leaves_at;
    const auto see = [&](const core::AvoidanceParameters& own) {
      const core::AvoidanceParameters region = core::wider(own, by);
      if (std::abs(dx) <= region.alpha && std::abs(dy) <= region.beta)
        least = std::min(least, core::region_level(region, dx, dy));
    };
    if (platoon_) {
      for (const core::AvoidanceParameters& region : different_) see(region);
    } else {
      see(regions_[at.i]);
      see(regions_[at.j]);
    }
    return least;
  }

 private:
  bool platoon_;
  std::vector<double> beyond_, most_beyond_;                    // the latter of any two robots so many places apart
  std::vector<core::AvoidanceParameters> regions_, different_;  // of each robot; each that differs, once
};

/// Says that robots i and j come too close.
void refuse_meeting(const Experiment& e, const Offset& at, double more_room, Problems& problems) {
  const double wide = core::standard_radius + core::standard_radius + more_room,
               nearest = core::math::hypot(at.dx, at.dy);
  if (e.reference.kind == Kind::platoon)
    problems.add(
        at.spacing == e.reference.spacing ? "reference.spacing" : "reference.change",
        fmt::format("found {}, with which robots of {:.4g} m width come within {:.4g} m of each other, allowed: more "
                    "room on a path of {:.4g} m for {} robots",
                    at.spacing, wide, nearest, make_path(e.reference.path)->length(), e.robots.size()));
  else if (e.reference.kind == Kind::formation)
    problems.add(
        e.reference.shape.offsets.empty() ? "reference.shape" : "reference.offsets",
        fmt::format(
            "found places, or a change of them, with which robots of {:.4g} m width come within {:.4g} m of each "
            "other, allowed: more room (spacing, offsets), and changes in which no robot crosses another's path",
            wide, nearest));
  else
    problems.add(
        fmt::format("robot.{}.trajectory", at.j + 1),
        fmt::format("found a reference that comes within {:.4g} m of robot {}'s at t = {:.4g} s, allowed: more than a "
                    "robot's width of {:.4g} m{}",
                    nearest, at.i + 1, at.t, wide,
                    e.reference.may_meet ? " where they start and where they come to rest"
                                         : ", or reference.may_meet = true, so that only the shield keeps them apart"));
}

/// The reference itself must neither collide nor set off what keeps robots apart.
void check_spacing(const Experiment& e, const core::Reference& reference, Problems& problems) {
  // `nearest`: as if the bodies were standard ones.
  double nearest = std::numeric_limits<double>::infinity(), level = nearest;
  Offset closest{};
  const Rooms rooms(e);
  for_each_offset(e, reference, [&](const Offset& offset) {
    if (const double d = core::math::hypot(offset.dx, offset.dy) - rooms.more(offset); d < nearest)
      nearest = d, closest = offset;
    level = std::min(level, rooms.level(offset));
  });
  if (nearest <= core::standard_radius + core::standard_radius)
    return refuse_meeting(e, closest, rooms.more(closest), problems);
  const char* where = e.reference.may_meet ? "where they begin or come to rest" : "of the formation";
  if (e.avoidance.enabled && e.avoidance.kind == core::AvoidanceKind::field && level <= 1.0) {
    const double fits = core::math::pow(level, 1.0 / e.avoidance.p);
    problems.add(
        e.avoidance.alpha >= e.avoidance.beta ? "avoidance.alpha" : "avoidance.beta",
        fmt::format(
            "found a detection region of {} m x {} m (alpha, beta), allowed: below {:.4g} m x {:.4g} m, or {}, whose "
            "robots come within {:.4g} m of each other, avoids itself for ever (a region is left at {} times its size)",
            e.avoidance.alpha, e.avoidance.beta, fits * e.avoidance.alpha, fits * e.avoidance.beta,
            e.reference.may_meet ? "the group at its starts or goals" : "the formation", nearest, leaves_at));
  }
  if (e.shield.enabled && e.shield.distance >= nearest)
    problems.add("shield.distance",
                 fmt::format("found {}, allowed: below {:.4g} m, the smallest distance between two "
                             "robots {}{}",
                             e.shield.distance, nearest, where,
                             rooms.more(closest) == 0.0 ? "" : ", less the excess of their bodies over an e-puck's"));
}

/// Where the file puts a robot at first, its body overlaps nothing: such a run would begin with a collision.
void check_starts(const Experiment& e, const core::Reference& reference, Problems& problems) {
  struct Body {
    core::Pose pose;
    double radius;
    bool own_start;  // given, and not a place of the reference, which has been checked
  };
  std::vector<Body> bodies;
  for (std::size_t i = 0; i < e.robots.size(); ++i) {
    const RobotSpec& robot = e.robots[i];
    const bool own = robot.start && robot.simulated();
    bodies.push_back({own ? *robot.start : reference.at(i, 0.0).pose, robot.radius, own});
  }
  const auto refuse = [&](std::size_t i, const std::string& found_and_allowed) {
    problems.add(fmt::format("robot.{}.start", i + 1),
                 fmt::format("found ({}, {}) m, {}", significant(bodies[i].pose.x, 4), significant(bodies[i].pose.y, 4),
                             found_and_allowed));
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& [pose, radius, own_start] = bodies[i];
    if (own_start &&
        std::max(std::abs(pose.x) - 0.5 * e.arena_width, std::abs(pose.y) - 0.5 * e.arena_height) > -radius)
      refuse(i, fmt::format("allowed: at least its radius, {:.4g} m, from the arena's edge", radius));
    for (std::size_t j = 0; j < i; ++j) {
      if (!own_start && !bodies[j].own_start) continue;
      const double touching = radius + bodies[j].radius, distance = core::distance(pose, bodies[j].pose);
      if (distance < touching)
        refuse(own_start ? i : j, fmt::format("{:.4g} m from where robot {} begins, allowed: at least {:.4g} m",
                                              distance, (own_start ? j : i) + 1, touching));
    }
    for (std::size_t k = 0; k < e.obstacles.size(); ++k) {
      const core::Obstacle& o = e.obstacles[k];
      const double touching = radius + o.radius, distance = core::math::hypot(pose.x - o.x, pose.y - o.y);
      if (distance >= touching) continue;
      if (own_start)
        refuse(i, fmt::format("{:.4g} m from the centre of obstacle {}, allowed: at least {:.4g} m", distance, k + 1,
                              touching));
      else
        problems.add(fmt::format("obstacle.{}", k + 1),
                     fmt::format("found ({}, {}) m, {:.4g} m from where robot {} begins, allowed: at least "
                                 "{:.4g} m",
                                 significant(o.x, 4), significant(o.y, 4), distance, i + 1, touching));
    }
  }
}

/// Whether robot i can drive its line to another end, in the time that the file gives it.
bool can_drive(const Experiment& e, std::size_t i, const core::Point& end) {
  TrajectorySpec t = *e.robots[i].trajectory;
  const core::Point from = t.path.points.front();
  if (t.start == 0.0 && !t.duration) return true;
  const double way = core::math::hypot(end.x - from.x, end.y - from.y) - t.start;
  if (!(way > 0.0)) return false;
  if (!t.duration) return true;
  if (*t.duration < core::Travel::shortest(way, t.acceleration.value_or(e.reference.acceleration))) return false;
  t.path.points.back() = end;
  const core::ReferenceDemand demand = make_trajectory(t, e.reference)->demand(e.controller.k_y);
  const core::CommandLimits limits = make_limits(e, i);
  return demand.v < limits.v_max && demand.turning < limits.omega_max;
}

/// The squares of the ways from each robot's line to each end; infinite where its body is over the arena's edge there,
/// or it cannot drive the line. An end to which obstacles leave it no way is taken only if there is no other.
Eigen::MatrixXd costs_of_places(const Experiment& e, const std::vector<core::Point>& ends) {
  const auto n = static_cast<Eigen::Index>(ends.size());
  Eigen::MatrixXd squared(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const core::Point& from = e.robots[static_cast<std::size_t>(i)].trajectory->path.points.front();
      const core::Point& to = ends[static_cast<std::size_t>(j)];
      squared(i, j) = (from.x - to.x) * (from.x - to.x) + (from.y - to.y) * (from.y - to.y);
    }
  const double dear = 1.0 + static_cast<double>(n) * squared.maxCoeff();
  Ways ways(e);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const RobotSpec& robot = e.robots[i];
    const core::Point& from = robot.trajectory->path.points.front();
    const core::Pose start = robot.start.value_or(core::Pose{from.x, from.y, 0.0});
    for (std::size_t j = 0; j < ends.size(); ++j) {
      double& cost = squared(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      const double over =
          std::max(std::abs(ends[j].x) - 0.5 * e.arena_width, std::abs(ends[j].y) - 0.5 * e.arena_height);
      if (over + robot.radius > 0.0 || !can_drive(e, i, ends[j]))
        cost = std::numeric_limits<double>::infinity();
      else if (!ways.lead(i, {start.x, start.y}, {ends[j].x, ends[j].y}))
        cost += dear;
    }
  }
  return squared;
}

/// Which end each robot takes: the cheapest of those for which all have room, whatever their sizes.
std::vector<std::size_t> places_that_fit(const Experiment& e, const std::vector<core::Point>& ends) {
  const bool field = e.avoidance.enabled && e.avoidance.kind == core::AvoidanceKind::field;
  const Rooms rooms(e);
  std::vector<core::AvoidanceParameters> regions;
  for (std::size_t i = 0; i < ends.size(); ++i) regions.push_back(make_avoidance(e, i));
  core::Fitting fitting;
  fitting.both = [&](std::size_t i, std::size_t a, std::size_t j, std::size_t b) {
    const Offset offset{ends[a].x - ends[b].x, ends[a].y - ends[b].y, i, j, 0.0};
    return Rooms::apart(e, core::math::hypot(offset.dx, offset.dy) - rooms.more(offset)) &&
           (!field || rooms.level(offset) > 1.0);
  };
  fitting.needs_no_less = [&](std::size_t k, std::size_t i) {
    const core::AvoidanceParameters &own = regions[k], &other = regions[i];
    return e.robots[k].radius >= e.robots[i].radius &&
           (!field || (own.alpha >= other.alpha && own.beta >= other.beta && own.p >= other.p));
  };
  constexpr std::size_t most_trials = 500;
  Eigen::MatrixXd costs = costs_of_places(e, ends);
  std::vector<std::size_t> place = core::cheapest_fitting_assignment(costs, fitting, most_trials);
  if (!place.empty()) return place;
  // As the file has it, but for robots that need the same room.
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (std::size_t j = 0; j < ends.size(); ++j)
      if (!fitting.needs_no_less(i, j) || !fitting.needs_no_less(j, i))
        costs(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = std::numeric_limits<double>::infinity();
  return core::cheapest_fitting_assignment(costs, fitting, 1);
}

}  // namespace

void read_reference(TomlTable t, Experiment& e, Problems& problems) {
  ReferenceSpec& r = e.reference;
  read_keys(t, "reference", e);
  if (!t.sound("reference.kind")) return;  // which keys belong to it is not known
  if (r.kind == Kind::independent) {
    t.number("acceleration", r.acceleration, above(0.0, 100.0, "m/s^2"));
    t.flag("may_meet", r.may_meet);
    t.flag("interchangeable", r.interchangeable);
  } else {
    t.number("start", r.start, between(-10.0 * longest_length, 10.0 * longest_length, "m"));
    if (r.kind == Kind::platoon) {
      t.number("spacing", r.spacing, above(0.0, longest_length, "m"));
    } else {
      read_shape(t, r.shape, e.robots.size());
    }
    read_changes(t, e, problems);
    read_path(t.table("path"), r.path, true);
  }
  t.finish();
}

void exchange_places(Experiment& e, Problems& problems) {
  if (e.reference.kind != Kind::independent || !e.reference.interchangeable) return;
  if (!problems.sound({"robot", "robot_defaults"})) return;
  std::vector<core::Point> ends;
  for (std::size_t i = 0; i < e.robots.size(); ++i) {
    const std::optional<TrajectorySpec>& t = e.robots[i].trajectory;
    if (!t || !t->samples.empty() || t->path.shape != PathShape::line || t->path.points.size() != 2 || t->distance) {
      problems.add(
          "reference.interchangeable",
          fmt::format("found true, allowed: if every robot's trajectory is a whole line; robot {}'s is not", i + 1));
      return;
    }
    ends.push_back(t->path.points.back());
  }
  // Ends that do not fit are refused as the file has them.
  if (!problems.sound({"reference", "arena", "controller", "avoidance", "shield", "obstacle"})) return;
  const std::vector<std::size_t> place = places_that_fit(e, ends);
  for (std::size_t i = 0; i < place.size(); ++i) {
    core::Point &from = e.robots[i].trajectory->path.points.front(), &to = e.robots[i].trajectory->path.points.back();
    const double way = core::math::hypot(to.x - from.x, to.y - from.y);
    const core::Point ahead{(to.x - from.x) / way, (to.y - from.y) / way};
    to = ends[place[i]];
    // One that is at its place already stays, with the heading of its own line: no line leads from a point to itself.
    constexpr double shortest = 1e-4;  // [m]
    if (from == to && way > 0.0) from = {to.x - shortest * ahead.x, to.y - shortest * ahead.y};
  }
}

bool check_shape(const Experiment& e, Problems& problems) {
  if (!check_trajectories(e, problems)) return false;
  if (e.reference.kind == Kind::independent) return true;
  const PathSpec& path = e.reference.path;
  if (!check_path(path, "reference.path", problems)) return false;
  if (!path.closed) {
    problems.add(path.shape == PathShape::line ? "reference.path.shape" : "reference.path.closed",
                 "found an open path, allowed: a closed one; open paths are for trajectories (kind = \"independent\")");
    return false;
  }
  if (e.reference.kind == Kind::formation) {
    if (path.shape == PathShape::rounded_rectangle || path.shape == PathShape::polyline) {
      problems.add(
          "reference.path.shape",
          "found straights and arcs, allowed for a formation: \"circle\", \"ellipse\", \"lemniscate\" or "
          "\"spline\"; where the curvature jumps, the velocity of a robot beside the centre would jump as well");
      return false;
    }
    const auto complete = [&](const ShapeSpec& s) { return s.offsets.empty() || s.offsets.size() == e.robots.size(); };
    return complete(e.reference.shape) && std::all_of(e.reference.changes.begin(), e.reference.changes.end(),
                                                      [&](const ReferenceChange& c) { return complete(c.shape); });
  }
  return true;
}

void check_places(const Experiment& e, const core::Reference& reference, const SoundTables& sound, Problems& problems) {
  if (sound.arena) check_arena(e, reference, problems);
  if (sound.avoidance && sound.shield) check_spacing(e, reference, problems);
  if (sound.arena && sound.obstacles) check_starts(e, reference, problems);
}

}  // namespace skein::app
