#include "app/experiment_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/reference/polyline.h"

namespace skein::app {
namespace {

using Kind = ReferenceSpec::Kind;
using PathShape = PathSpec::Shape;

// Limits that only a slip of the keyboard exceeds.
constexpr double longest = 100.0;      // [m]
constexpr double longest_run = 86400;  // a day [s]
constexpr std::size_t most_points = 1000;

/// [[x, y], ...], from `least` to `most` of them.
void read_points(TomlTable& t, const char* key, std::vector<core::Point>& points, std::size_t least, std::size_t most) {
  const toml::node* const found = t.node(key);
  if (!found) return;
  const std::string allowed =
      fmt::format("{} points [x, y] in m, from {} to {}",
                  least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most), -longest, longest);
  const toml::array* const array = found->as_array();
  if (!array || array->size() < least || array->size() > most) return t.refuse(key, *found, allowed);
  points.clear();
  for (const toml::node& element : *array) {
    const toml::array* const pair = element.as_array();
    const auto number = [&](std::size_t k) {
      const bool there = pair && pair->size() == 2 && (*pair)[k].is_number();
      const auto value = there ? (*pair)[k].value<double>() : std::nullopt;
      return value && std::abs(*value) <= longest ? value : std::nullopt;
    };
    const auto x = number(0), y = number(1);
    if (!x || !y) {
      points.clear();
      return t.refuse(key, element, allowed);
    }
    points.push_back({*x, *y});
  }
}

void read_path(TomlTable t, PathSpec& path) {
  t.choice("shape", path.shape,
           {{"rounded_rectangle", PathShape::rounded_rectangle},
            {"circle", PathShape::circle},
            {"ellipse", PathShape::ellipse},
            {"lemniscate", PathShape::lemniscate},
            {"polyline", PathShape::polyline},
            {"spline", PathShape::spline}});
  const bool points = path.shape == PathShape::polyline || path.shape == PathShape::spline;
  if (points) {
    t.require("points", "at least 3 points [[x, y], ...] in m");
    read_points(t, "points", path.points, 3, most_points);
  } else if (path.shape != PathShape::circle) {
    t.number("width", path.width, between(0.02, longest, "m"));
    t.number("height", path.height, between(0.02, longest, "m"));
  }
  if (path.shape == PathShape::circle)
    t.require("radius", "the circle's radius in m");  // the default is that of a corner
  if (path.shape == PathShape::rounded_rectangle || path.shape == PathShape::circle ||
      path.shape == PathShape::polyline)
    t.number("radius", path.radius, between(0.01, longest, "m"));
  t.finish();
}

/// A shape by name, or the robots' own places.
void read_shape(TomlTable& t, ShapeSpec& shape, std::size_t robots) {
  t.choice("shape", shape.shape,
           {{"line", core::ShapeName::line},
            {"column", core::ShapeName::column},
            {"diamond", core::ShapeName::diamond},
            {"v", core::ShapeName::v},
            {"circle", core::ShapeName::circle}});
  t.number("spacing", shape.spacing, above(0.0, longest, "m"));
  shape.offsets.clear();
  read_points(t, "offsets", shape.offsets, robots, robots);
  if (!t.has("offsets")) t.require("shape", "the formation's shape, or offsets = [[x, y], ...] for every robot");
  if (t.has("offsets") && t.has("shape"))
    t.refuse("offsets", *t.node("offsets"), "one of shape and offsets, since both say where the robots are");
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
    read_shape(c, change.shape, e.robots.size());
    c.finish();
    if (++k > 1 && change.t < free_from)
      problems.add(
          fmt::format("reference.change.{}.t", k),
          fmt::format("found {}, allowed: {:.6g} and later, when the change before is over", change.t, free_from));
    free_from = change.t + change.duration;
    e.reference.changes.push_back(std::move(change));
  }
}

/// Calls `visit` with the moments of a formation at which anything can be different: every change, and a lap with every
/// shape, as far as it lasts.
template <typename Visit>
void for_each_moment(const Experiment& e, const core::Reference& reference, Visit&& visit) {
  constexpr int samples = 1000;
  const double lap = e.reference.speed > 0.0 ? reference.path().length() / e.reference.speed : 0.0;
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

/// Calls `visit` with the vector between two references: every pair, all along the path.
template <typename Visit>
void for_each_offset(const Experiment& e, const core::Reference& reference, Visit&& visit) {
  if (e.reference.kind == Kind::platoon) {
    constexpr int samples = 2000;  // 2 mm on the paper's path
    const core::Path& path = reference.path();
    for (int k = 0; k < samples; ++k) {
      const double s = path.length() * k / samples;
      const core::Pose ahead = path.at(s).pose;
      for (std::size_t j = 1; j < e.robots.size(); ++j) {
        const core::Pose behind = path.at(s - static_cast<double>(j) * e.reference.spacing).pose;
        visit(ahead.x - behind.x, ahead.y - behind.y);
      }
    }
    return;
  }
  std::vector<core::ReferencePoint> points(e.robots.size());
  for_each_moment(e, reference, [&](double t) {
    reference.at(t, points);
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = i + 1; j < points.size(); ++j)
        visit(points[i].pose.x - points[j].pose.x, points[i].pose.y - points[j].pose.y);
  });
}

void check_arena(const Experiment& e, const core::Reference& reference, Problems& problems) {
  const PathSpec& path = e.reference.path;
  const double room = 2.0 * core::robot_radius;
  const bool circle = path.shape == PathShape::circle;
  if (e.reference.kind == Kind::platoon && path.shape != PathShape::polyline && path.shape != PathShape::spline) {
    const double width = circle ? 2.0 * path.radius : path.width, height = circle ? 2.0 * path.radius : path.height;
    if (width + room > e.arena_width || height + room > e.arena_height)
      problems.add("reference.path",
                   fmt::format("found a path of {:.6g} m x {:.6g} m, allowed: up to {:.6g} m x {:.6g} m, "
                               "the arena less a robot's width of {} m",
                               width, height, e.arena_width - room, e.arena_height - room, room));
    return;
  }
  const double x_most = 0.5 * (e.arena_width - room), y_most = 0.5 * (e.arena_height - room);
  core::Pose farthest;
  double outside = 0.0;
  const auto see = [&](const core::Pose& pose) {
    const double by = std::max(std::abs(pose.x) - x_most, std::abs(pose.y) - y_most);
    if (by > outside) outside = by, farthest = pose;
  };
  if (e.reference.kind == Kind::platoon)
    for (int k = 0; k < 2000; ++k) see(reference.path().at(reference.path().length() * k / 2000).pose);
  else
    for_each_moment(e, reference, [&](double t) {
      for (std::size_t i = 0; i < e.robots.size(); ++i) see(reference.at(i, t).pose);
    });
  if (outside > 0.0)
    problems.add("reference.path", fmt::format("found a place ({:.4g}, {:.4g}) m that a robot comes to, allowed: from "
                                               "-{:.6g} to {:.6g} m along x, -{:.6g} to {:.6g} m along y, the arena "
                                               "less a robot's width of {} m",
                                               farthest.x, farthest.y, x_most, x_most, y_most, y_most, room));
}

/// The formation itself must neither collide nor set off what keeps robots apart.
void check_spacing(const Experiment& e, const core::Reference& reference, Problems& problems) {
  constexpr double leaves_at = 1.1;  // a detection region once entered is left only at this times its size
  double nearest = std::numeric_limits<double>::infinity(), level = nearest;
  for_each_offset(e, reference, [&](double dx, double dy) {
    nearest = std::min(nearest, std::hypot(dx, dy));
    level = std::min(level, core::region_level(e.avoidance, dx / leaves_at, dy / leaves_at));
  });
  if (nearest <= 2.0 * core::robot_radius) {
    if (e.reference.kind == Kind::platoon)
      problems.add(
          "reference.spacing",
          fmt::format("found {}, with which robots of {} m width come within {:.4g} m of each other, allowed: more "
                      "room on a path of {:.4g} m for {} robots",
                      e.reference.spacing, 2.0 * core::robot_radius, nearest, reference.path().length(),
                      e.robots.size()));
    else
      problems.add(
          e.reference.shape.offsets.empty() ? "reference.shape" : "reference.offsets",
          fmt::format("found places, or a change of them, with which robots of {} m width come within {:.4g} m "
                      "of each other, allowed: more room (spacing, offsets), and changes in which nobody "
                      "crosses another's way",
                      2.0 * core::robot_radius, nearest));
    return;
  }
  if (e.avoidance.enabled && level <= 1.0) {
    const double fits = std::pow(level, 1.0 / e.avoidance.p);
    problems.add(
        e.avoidance.alpha >= e.avoidance.beta ? "avoidance.alpha" : "avoidance.beta",
        fmt::format("found a detection region of {} m x {} m (alpha, beta), allowed: below {:.4g} m x {:.4g} m, or "
                    "the formation, whose robots are {:.4g} m apart where they are nearest, avoids itself for ever "
                    "(a region is left at {} times its size)",
                    e.avoidance.alpha, e.avoidance.beta, fits * e.avoidance.alpha, fits * e.avoidance.beta, nearest,
                    leaves_at));
  }
  if (e.shield.enabled && e.shield.distance >= nearest)
    problems.add("shield.distance",
                 fmt::format("found {}, allowed: below {:.4g} m, the smallest distance between two robots "
                             "of the formation",
                             e.shield.distance, nearest));
}

}  // namespace

void read_reference(TomlTable t, Experiment& e, Problems& problems) {
  ReferenceSpec& r = e.reference;
  t.choice("kind", r.kind, {{"platoon", Kind::platoon}, {"formation", Kind::formation}});
  t.number("speed", r.speed, between(0.0, 10.0, "m/s"));
  t.number("start", r.start, between(-10.0 * longest, 10.0 * longest, "m"));
  if (r.kind == Kind::platoon) {
    t.number("spacing", r.spacing, above(0.0, longest, "m"));
  } else {
    read_shape(t, r.shape, e.robots.size());
    read_changes(t, e, problems);
  }
  read_path(t.table("path"), r.path);
  t.finish();
}

bool check_shape(const Experiment& e, Problems& problems) {
  const PathSpec& path = e.reference.path;
  if (path.shape == PathShape::rounded_rectangle) {
    if (const double largest = 0.5 * std::min(path.width, path.height); path.radius > largest) {
      problems.add("reference.path.radius",
                   fmt::format("found {}, allowed: up to {:.6g} m, half of the shorter side of {} m x {} m",
                               path.radius, largest, path.width, path.height));
      return false;
    }
  }
  const std::size_t n = path.points.size();
  if (path.shape == PathShape::polyline || path.shape == PathShape::spline) {
    if (n < 3) return false;  // said where they were read
    for (std::size_t i = 0; i < n; ++i)
      if (path.points[i] == path.points[(i + 1) % n]) {
        problems.add(
            "reference.path.points",
            fmt::format("found ({}, {}) twice in a row, allowed: neighbours that differ; the path closes itself",
                        path.points[i].x, path.points[i].y));
        return false;
      }
  }
  if (path.shape == PathShape::polyline) {
    const double largest = core::Polyline::largest_radius(path.points);
    if (largest <= 0.0 || path.radius > largest) {
      problems.add("reference.path.radius",
                   largest > 0.0
                       ? fmt::format("found {}, allowed: up to {:.6g} m, with which the arcs at both ends of "
                                     "every side have room on it",
                                     path.radius, largest)
                       : fmt::format("found {}, but the line turns back on itself, allowed: points that an arc "
                                     "can lead round",
                                     path.radius));
      return false;
    }
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

void check_places(const Experiment& e, const core::Reference& reference, Problems& problems) {
  check_arena(e, reference, problems);
  check_spacing(e, reference, problems);
}

}  // namespace skein::app
