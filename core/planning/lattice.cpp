#include "core/planning/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein::core {
namespace {

constexpr double finest_cell = 0.04;  // [m]: about half a robot
constexpr double from_edge = 0.01;    // routes keep so much more from the arena's edge than must be: the shield lets a
                                      // robot that heads for the edge drive ever more slowly [m]
constexpr double beside = 0.03;       // less room than this to spare: the place moves to where there is most [m]
constexpr std::array<int, 8> step_x{1, 1, 0, -1, -1, -1, 0, 1};
constexpr std::array<int, 8> step_y{0, 1, 1, 1, 0, -1, -1, -1};

}  // namespace

Lattice::Lattice(const HalfSize& arena, double keep, std::size_t obstacles)
    : keep_(keep),
      most_{std::max(0.0, arena.width - keep), std::max(0.0, arena.height - keep)},
      routes_{std::max(0.0, most_.width - from_edge), std::max(0.0, most_.height - from_edge)} {
  const double area = 4.0 * most_.width * most_.height;
  cell_ = std::max(finest_cell, std::sqrt(1.1 * area / static_cast<double>(most_cells)));
  columns_ = static_cast<std::size_t>(std::ceil(2.0 * most_.width / cell_ + 1e-9)) + 1;
  rows_ = static_cast<std::size_t>(std::ceil(2.0 * most_.height / cell_ + 1e-9)) + 1;
  left_ = -0.5 * cell_ * static_cast<double>(columns_);
  bottom_ = -0.5 * cell_ * static_cast<double>(rows_);
  places_.resize(columns_ * rows_);
  free_.resize(places_.size());
  open_.resize(places_.size());
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
  const double dx = to.x - from.x, dy = to.y - from.y, squared = dx * dx + dy * dy;
  // A robot that is too near to something already may leave it, and come no nearer.
  if (std::abs(to.x) > std::max(most_.width, std::abs(from.x)) + 1e-9 ||
      std::abs(to.y) > std::max(most_.height, std::abs(from.y)) + 1e-9)
    return false;
  return std::all_of(obstacles.begin(), obstacles.end(), [&](const Obstacle& o) {
    const double along = squared > 0.0 ? ((o.x - from.x) * dx + (o.y - from.y) * dy) / squared : 0.0;
    const double share = std::clamp(along, 0.0, 1.0);
    const double least = std::min(o.radius + keep_, std::hypot(from.x - o.x, from.y - o.y) - 1e-9),
                 d_x = from.x + share * dx - o.x, d_y = from.y + share * dy - o.y;
    return d_x * d_x + d_y * d_y >= least * least - 1e-12;
  });
}

Lattice::Place Lattice::inside(double x, double y) const noexcept {
  return {std::clamp(x, -most_.width, most_.width), std::clamp(y, -most_.height, most_.height)};
}

std::size_t Lattice::neighbour(std::size_t vertex, std::size_t d) const noexcept {
  if ((open_[vertex] >> d & 1) == 0) return size();
  return vertex + static_cast<std::size_t>(step_x[d]) + static_cast<std::size_t>(step_y[d]) * columns_;
}

void Lattice::build(std::span<const Obstacle> obstacles) noexcept {
  obstacles_.assign(obstacles.begin(),
                    obstacles.begin() + static_cast<std::ptrdiff_t>(std::min(obstacles.size(), obstacles_.capacity())));
  for (std::size_t j = 0; j < rows_; ++j)
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::size_t v = j * columns_ + i;
      const double x = left_ + cell_ * (static_cast<double>(i) + 0.5);
      const double y = bottom_ + cell_ * (static_cast<double>(j) + 0.5);
      Place best{std::clamp(x, -routes_.width, routes_.width), std::clamp(y, -routes_.height, routes_.height)};
      close_.clear();
      for (const Obstacle& o : obstacles_) {
        const double reach = o.radius + keep_ + beside + 2.0 * cell_;
        if (std::abs(o.x - best.x) < reach && std::abs(o.y - best.y) < reach) close_.push_back(o);
      }
      double room = clearance(best.x, best.y, close_);
      // Towards the most room in the cell, in ever smaller steps; the arena's edge alone moves no vertex.
      double to_obstacles = std::numeric_limits<double>::infinity();
      for (const Obstacle& o : close_)
        to_obstacles = std::min(to_obstacles, std::hypot(best.x - o.x, best.y - o.y) - o.radius - keep_);
      if (to_obstacles < beside && to_obstacles > -cell_) {
        double step = 0.5 * cell_;
        while ((step *= 0.5) > 0.02 * cell_)
          for (bool moved = true; moved;) {
            moved = false;
            const Place from = best;
            for (std::size_t d = 0; d < directions; ++d) {
              const Place there{from.x + step * step_x[d], from.y + step * step_y[d]};
              if (std::abs(there.x - x) > 0.5 * cell_ || std::abs(there.y - y) > 0.5 * cell_) continue;
              const double more = clearance(there.x, there.y, close_);
              if (more > room + 1e-6) best = there, room = more, moved = true;
            }
          }
      }
      places_[v] = best;
      free_[v] = room >= 0.0;
    }
  for (std::size_t j = 0; j < rows_; ++j)
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::size_t v = j * columns_ + i;
      open_[v] = 0;
      if (!free_[v]) continue;
      close_.clear();
      for (const Obstacle& o : obstacles_) {
        const double reach = o.radius + keep_ + 2.5 * cell_;
        if (std::abs(o.x - places_[v].x) < reach && std::abs(o.y - places_[v].y) < reach) close_.push_back(o);
      }
      for (std::size_t d = 0; d < directions; ++d) {
        const std::size_t to_i = i + static_cast<std::size_t>(step_x[d]),
                          to_j = j + static_cast<std::size_t>(step_y[d]);
        if (to_i >= columns_ || to_j >= rows_) continue;  // left of the first column wraps round to more than there are
        const std::size_t to = to_j * columns_ + to_i;
        if (free_[to] && free(places_[v], places_[to], close_)) open_[v] |= static_cast<std::uint8_t>(1u << d);
      }
    }
}

}  // namespace skein::core
