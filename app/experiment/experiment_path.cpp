#include "app/experiment/experiment_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/longest.h"
#include "core/reference/polyline.h"

namespace skein::app {
namespace {

using PathShape = PathSpec::Shape;

constexpr std::size_t most_points = 1000;

std::optional<core::Point> point_of(const toml::node& node) {
  const auto pair = numbers_of<2>(node);
  if (!pair || std::abs((*pair)[0]) > longest_length || std::abs((*pair)[1]) > longest_length) return {};
  return core::Point{(*pair)[0], (*pair)[1]};
}

/// One point, [x, y].
void read_point(TomlTable& t, const char* key, core::Point& point) {
  const toml::node* const found = t.node(key);
  if (!found) return;
  if (const auto read = point_of(*found))
    point = *read;
  else
    t.refuse(key, *found, fmt::format("a point [x, y] in m, from {} to {}", -longest_length, longest_length));
}

bool through_points(const PathSpec& path) noexcept {
  return path.shape == PathShape::polyline || path.shape == PathShape::spline || path.shape == PathShape::line;
}

/// An open spline needs a third point: two do not say which way it bends.
std::size_t fewest_points(const PathSpec& path) noexcept {
  return path.closed || path.shape == PathShape::spline ? 3 : 2;
}

}  // namespace

void read_points(TomlTable& t, const char* key, std::vector<core::Point>& points, std::size_t least, std::size_t most) {
  const toml::node* const found = t.node(key);
  if (!found) return;
  const std::string allowed = fmt::format(
      "{} points [x, y] in m, from {} to {}",
      least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most), -longest_length, longest_length);
  const toml::array* const array = found->as_array();
  if (!array || array->size() < least || array->size() > most) return t.refuse(key, *found, allowed);
  points.clear();
  for (const toml::node& element : *array) {
    const auto point = point_of(element);
    if (!point) {
      points.clear();
      return t.refuse(key, element, allowed);
    }
    points.push_back(*point);
  }
}

void read_path(TomlTable t, PathSpec& path, bool closed) {
  t.choice("shape", path.shape);
  if (!t.sound(t.full("shape"))) return;  // which keys belong to it is not known
  if (path.shape == PathShape::line) {
    path.closed = false;
    path.points.assign(2, {});
    for (const char* key : {"from", "to"}) t.require(key, "the straight's end, a point [x, y] in m");
    read_point(t, "from", path.points[0]);
    read_point(t, "to", path.points[1]);
  } else if (through_points(path)) {
    path.closed = closed;
    t.flag("closed", path.closed);
    const std::size_t fewest = fewest_points(path);
    t.require("points", fmt::format("at least {} points [[x, y], ...] in m", fewest));
    read_points(t, "points", path.points, fewest, most_points);
  } else {
    read_point(t, "centre", path.centre);
    if (path.shape != PathShape::circle) {
      t.number("width", path.width, between(0.02, longest_length, "m"));
      t.number("height", path.height, between(0.02, longest_length, "m"));
    }
  }
  if (path.shape == PathShape::circle)
    t.require("radius", "the circle's radius in m");  // the default is that of a corner
  if (path.shape == PathShape::rounded_rectangle || path.shape == PathShape::circle ||
      path.shape == PathShape::polyline)
    t.number("radius", path.radius, between(0.01, longest_length, "m"));
  t.finish();
}

bool check_path(const PathSpec& path, const std::string& key, Problems& problems) {
  if (path.shape == PathShape::rounded_rectangle) {
    const double largest = 0.5 * std::min(path.width, path.height);
    if (path.radius <= largest) return true;
    problems.add(key + ".radius",
                 fmt::format("found {}, allowed: up to {:.6g} m, half of the shorter side of {} m x {} m", path.radius,
                             largest, path.width, path.height));
    return false;
  }
  if (!through_points(path)) return true;
  const std::size_t n = path.points.size();
  if (n < fewest_points(path)) return false;  // said where they were read
  for (std::size_t i = 0; i + (path.closed ? 0 : 1) < n; ++i)
    if (path.points[i] == path.points[(i + 1) % n]) {
      problems.add(key + (path.shape == PathShape::line ? ".to" : ".points"),
                   fmt::format("found ({}, {}) twice in a row, allowed: neighbours that differ{}", path.points[i].x,
                               path.points[i].y, path.closed ? "; the path closes itself" : ""));
      return false;
    }
  if (path.shape != PathShape::polyline) return true;
  const double largest = core::Polyline::largest_radius(path.points, path.closed);
  if (largest > 0.0 && path.radius <= largest) return true;
  problems.add(
      key + ".radius",
      largest > 0.0
          ? fmt::format(
                "found {}, allowed: up to {:.6g} m, with which the arcs at both ends of every side have room on it",
                path.radius, largest)
          : fmt::format("found {}, but the line turns back on itself, allowed: corners that an arc can round",
                        path.radius));
  return false;
}

}  // namespace skein::app
