#include "core/planning/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double finest_cell = 0.04;  // [m]: about half a robot
constexpr double from_edge = 0.01;    // routes keep so much more from the arena's edge than must be: the shield lets a
                                      // robot that heads for the edge drive ever more slowly [m]
constexpr double beside = 0.03;       // less room than this to spare: the place moves to where there is most [m]

HalfSize inner(const HalfSize& outer, double by) noexcept {
  return {std::max(0.0, outer.width - by), std::max(0.0, outer.height - by)};
}

/// The square of the distance of an obstacle's middle from the line between two points.
double distance2_of(const Obstacle& o, const Lattice::Place& from, const Lattice::Place& to) noexcept {
  const double dx = to.x - from.x, dy = to.y - from.y, squared = dx * dx + dy * dy;
  const double along = squared > 0.0 ? ((o.x - from.x) * dx + (o.y - from.y) * dy) / squared : 0.0;
  const double share = std::clamp(along, 0.0, 1.0);
  const double d_x = from.x + share * dx - o.x, d_y = from.y + share * dy - o.y;
  return d_x * d_x + d_y * d_y;
}

}  // namespace

Lattice::Lattice(const HalfSize& arena, double keep, std::size_t obstacles)
    : arena_(arena), least_keep_(keep), keep_(keep), most_(inner(arena, keep)), routes_(inner(most_, from_edge)) {
  const double area = 4.0 * most_.width * most_.height;
  cell_ = std::max(finest_cell, std::sqrt(1.1 * area / static_cast<double>(most_cells)));
  columns_ = static_cast<std::size_t>(std::ceil(2.0 * most_.width / cell_ + 1e-9)) + 1;
  rows_ = static_cast<std::size_t>(std::ceil(2.0 * most_.height / cell_ + 1e-9)) + 1;
  left_ = -0.5 * cell_ * static_cast<double>(columns_);
  bottom_ = -0.5 * cell_ * static_cast<double>(rows_);
  places_.resize(columns_ * rows_);
  free_.resize(places_.size());
  open_.resize(places_.size());
  part_.resize(places_.size());
  moved_.resize(places_.size(), 1);
  edges_.resize(places_.size() * directions);
  obstacles_.reserve(obstacles);
  close_.reserve(obstacles);
  build({});
}

double Lattice::clearance(double x, double y, std::span<const Obstacle> obstacles) const noexcept {
  double least = std::min(most_.width - std::abs(x), most_.height - std::abs(y));
  for (const Obstacle& o : obstacles) {
    const double within = least + o.radius + keep_, dx = x - o.x, dy = y - o.y, squared = dx * dx + dy * dy;
    if (within > 0.0 && squared >= within * within) continue;
    least = std::min(least, std::sqrt(squared) - o.radius - keep_);
  }
  return least;
}

bool Lattice::free(const Place& from, const Place& to) const noexcept {
  return free(from, to, obstacles_);
}

bool Lattice::free(const Place& from, const Place& to, std::span<const Obstacle> obstacles) const noexcept {
  // A robot that is too near to something already may leave it, and come no nearer.
  if (std::abs(to.x) > std::max(most_.width, std::abs(from.x)) + 1e-9 ||
      std::abs(to.y) > std::max(most_.height, std::abs(from.y)) + 1e-9)
    return false;
  return std::all_of(obstacles.begin(), obstacles.end(), [&](const Obstacle& o) {
    const double least = std::min(o.radius + keep_, math::hypot(from.x - o.x, from.y - o.y) - 1e-9);
    return distance2_of(o, from, to) >= least * least - 1e-12;
  });
}

Lattice::Place Lattice::inside(double x, double y) const noexcept {
  return {std::clamp(x, -most_.width, most_.width), std::clamp(y, -most_.height, most_.height)};
}

/// The vertex in direction d, whether or not the line there is free; size(): there is none.
std::size_t Lattice::beyond(std::size_t vertex, std::size_t d) const noexcept {
  const std::size_t i = vertex % columns_ + static_cast<std::size_t>(step_x[d]),
                    j = vertex / columns_ + static_cast<std::size_t>(step_y[d]);
  // Left of the first column wraps round to more than there are.
  return i < columns_ && j < rows_ ? j * columns_ + i : size();
}

/// Lengths and headings of the edges of which an end has moved.
void Lattice::measure_edges() noexcept {
  for (std::size_t v = 0; v < size(); ++v)
    for (std::size_t d = 0; d < directions; ++d) {
      const std::size_t to = beyond(v, d);
      if (to == size() || (!moved_[v] && !moved_[to])) continue;
      const double dx = places_[to].x - places_[v].x, dy = places_[to].y - places_[v].y;
      edges_[v * directions + d] = {math::hypot(dx, dy), math::atan2(dy, dx)};
    }
  std::fill(moved_.begin(), moved_.end(), std::uint8_t{0});
}

Lattice::Place Lattice::centre(std::size_t vertex) const noexcept {
  const std::size_t column = vertex % columns_, row = vertex / columns_;
  return {left_ + cell_ * (static_cast<double>(column) + 0.5), bottom_ + cell_ * (static_cast<double>(row) + 0.5)};
}

void Lattice::know_close(const Place& place, double reach) noexcept {
  close_.clear();
  for (const Obstacle& o : obstacles_) {
    const double within = o.radius + keep_ + reach;
    if (std::abs(o.x - place.x) < within && std::abs(o.y - place.y) < within) close_.push_back(o);
  }
}

/// From a place in the vertex's cell to the one nearby that is best, in ever smaller steps. Returns how good it is.
template <typename F>
double Lattice::climb(std::size_t vertex, Place& best, double good, F&& goodness) const noexcept {
  const Place middle = centre(vertex);
  double step = 0.5 * cell_;
  while ((step *= 0.5) > 0.02 * cell_)
    for (bool moved = true; moved;) {
      moved = false;
      const Place from = best;
      for (std::size_t d = 0; d < directions; ++d) {
        const Place there{from.x + step * step_x[d], from.y + step * step_y[d]};
        if (std::abs(there.x - middle.x) > 0.5 * cell_ || std::abs(there.y - middle.y) > 0.5 * cell_) continue;
        const double better = goodness(there);
        if (better > good + 1e-6) best = there, good = better, moved = true;
      }
    }
  return good;
}

void Lattice::build(std::span<const Obstacle> obstacles, double more) noexcept {
  keep_ = least_keep_ + more;
  most_ = inner(arena_, keep_);
  routes_ = inner(most_, from_edge);
  obstacles_.assign(obstacles.begin(),
                    obstacles.begin() + static_cast<std::ptrdiff_t>(std::min(obstacles.size(), obstacles_.capacity())));
  for (std::size_t v = 0; v < size(); ++v) {
    const Place middle = centre(v);
    Place best{std::clamp(middle.x, -routes_.width, routes_.width),
               std::clamp(middle.y, -routes_.height, routes_.height)};
    know_close(best, beside + 2.0 * cell_);
    double room = clearance(best.x, best.y, close_);
    double to_obstacles = std::numeric_limits<double>::infinity();
    for (const Obstacle& o : close_)
      to_obstacles = std::min(to_obstacles, math::hypot(best.x - o.x, best.y - o.y) - o.radius - keep_);
    // The arena's edge alone moves no vertex.
    if (to_obstacles < beside && to_obstacles > -cell_)
      room = climb(v, best, room, [&](const Place& there) { return clearance(there.x, there.y, close_); });
    move(v, best);
    free_[v] = room >= 0.0;
  }
  std::iota(part_.begin(), part_.end(), std::size_t{0});
  for (std::size_t v = 0; v < size(); ++v) {
    open_[v] = 0;
    if (!free_[v]) continue;
    know_close(places_[v], 2.5 * cell_);
    for (std::size_t d = 0; d < directions; ++d) {
      const std::size_t to = beyond(v, d);
      if (to == size() || !free_[to] || !free(places_[v], places_[to], close_)) continue;
      open_[v] |= static_cast<std::uint8_t>(1u << d);
      part_[part(v)] = part(to);
    }
  }
  // Where a narrow passage bends, the vertices with most room on both sides of the bend may not see each other.
  for (std::size_t v = 0; v < size() && has_obstacles(); ++v)
    for (std::size_t d = 0; d < directions / 2; ++d) {
      const std::size_t to = beyond(v, d), back = d + directions / 2;
      if (to == size() || !free_[v] || !free_[to] || part(v) == part(to)) continue;
      if (join(v, d) || join(to, back)) part_[part(v)] = part(to);
    }
  measure_edges();
}

void Lattice::move(std::size_t vertex, const Place& to) noexcept {
  if (places_[vertex].x != to.x || places_[vertex].y != to.y) moved_[vertex] = 1;
  places_[vertex] = to;
}

std::size_t Lattice::part(std::size_t vertex) noexcept {
  while (part_[vertex] != vertex) vertex = part_[vertex] = part_[part_[vertex]];
  return vertex;
}

/// Moves a vertex within its cell so that the line in direction d becomes free, and those that are free remain so.
/// False: there is no such place nearby.
bool Lattice::join(std::size_t vertex, std::size_t d) noexcept {
  know_close(centre(vertex), 1.5 * cell_);
  const auto least_room = [&](const Place& there) {
    double least = clearance(there.x, there.y, close_);
    for (std::size_t e = 0; e < directions; ++e)
      if (e == d || (open_[vertex] >> e & 1) != 0)
        for (const Obstacle& o : close_)
          least = std::min(least, std::sqrt(distance2_of(o, there, places_[beyond(vertex, e)])) - o.radius - keep_);
    return least;
  };
  Place best = places_[vertex];
  if (climb(vertex, best, least_room(best), least_room) < 0.0) return false;
  move(vertex, best);
  open_[vertex] |= static_cast<std::uint8_t>(1u << d);
  open_[beyond(vertex, d)] |= static_cast<std::uint8_t>(1u << (d + directions / 2) % directions);
  return true;
}

}  // namespace skein::core
