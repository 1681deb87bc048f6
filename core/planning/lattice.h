#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/avoidance/obstacle.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// Half the arena's size, centred on the origin. [m]
struct HalfSize {
  double width = 1.0, height = 0.75;
};

/// The vertices of routes: one in each cell of a square grid, at its centre or, near obstacles, where the cell has most
/// room, so that a gap narrower than a cell is found. The 8 neighbours are joined if the straight line between them is
/// free. Allocates in its constructor only.
class Lattice {
 public:
  static constexpr std::size_t directions = 8;
  static constexpr std::size_t most_cells = 8192;

  /// `keep`: from a midpoint to an edge of the arena or of an obstacle [m].
  Lattice(const HalfSize& arena, double keep, std::size_t obstacles);
  /// `more`: added to `keep` [m].
  void build(std::span<const Obstacle> obstacles, double more = 0.0) noexcept;

  std::size_t size() const noexcept { return places_.size(); }
  double cell() const noexcept { return cell_; }
  bool free(std::size_t vertex) const noexcept { return free_[vertex]; }
  struct Place {
    double x, y;
  };
  const Place& place(std::size_t vertex) const noexcept { return places_[vertex]; }
  /// The neighbour in direction d (0: +x, counter-clockwise), if the line there is free; otherwise size().
  std::size_t neighbour(std::size_t vertex, std::size_t d) const noexcept {
    if ((open_[vertex] >> d & 1) == 0) return size();
    return vertex + static_cast<std::size_t>(step_x[d]) + static_cast<std::size_t>(step_y[d]) * columns_;
  }
  /// The line to a neighbour that there is.
  struct Edge {
    double way = 0.0, heading = 0.0;  // [m], [rad]
  };
  const Edge& edge(std::size_t vertex, std::size_t d) const noexcept { return edges_[vertex * directions + d]; }

  /// The room beyond the required distance to the nearest obstacle or edge; negative: too little. [m]
  double room(double x, double y) const noexcept { return clearance(x, y, obstacles_); }
  /// Whether a midpoint may stand at a point; whether it may drive straight between two points.
  bool free(double x, double y) const noexcept { return room(x, y) >= 0.0; }
  bool free(const Place& from, const Place& to) const noexcept;
  bool has_obstacles() const noexcept { return !obstacles_.empty(); }
  /// Vertices from which a robot gets to one another have the same part: a vertex that stands for them.
  std::size_t part(std::size_t vertex) noexcept;
  /// The nearest point that keeps its distance from the arena's edges.
  Place inside(double x, double y) const noexcept;

  /// Calls f(vertex) for every free vertex within `reach` of a point [m].
  template <typename F>
  void near(double x, double y, double reach, F&& f) const {
    const auto low = [](double value, double size) { return value < 0.0 ? 0.0 : value > size ? size : value; };
    const double most_x = static_cast<double>(columns_ - 1), most_y = static_cast<double>(rows_ - 1);
    const double r = reach + 0.5 * cell_;  // a place may be half a cell from its centre
    const auto i0 = static_cast<std::size_t>(low((x - r - left_) / cell_, most_x));
    const auto i1 = static_cast<std::size_t>(low((x + r - left_) / cell_, most_x));
    const auto j0 = static_cast<std::size_t>(low((y - r - bottom_) / cell_, most_y));
    const auto j1 = static_cast<std::size_t>(low((y + r - bottom_) / cell_, most_y));
    for (std::size_t j = j0; j <= j1; ++j)
      for (std::size_t i = i0; i <= i1; ++i) {
        const std::size_t v = j * columns_ + i;
        const double dx = places_[v].x - x, dy = places_[v].y - y;
        if (free_[v] && dx * dx + dy * dy < reach * reach) f(v);
      }
  }

 private:
  bool free(const Place& from, const Place& to, std::span<const Obstacle> obstacles) const noexcept;
  double clearance(double x, double y, std::span<const Obstacle> obstacles) const noexcept;
  Place centre(std::size_t vertex) const noexcept;
  std::size_t beyond(std::size_t vertex, std::size_t d) const noexcept;
  void know_close(const Place& place, double reach) noexcept;
  template <typename F>
  double climb(std::size_t vertex, Place& best, double good, F&& goodness) const noexcept;
  bool join(std::size_t vertex, std::size_t d) noexcept;
  void move(std::size_t vertex, const Place& to) noexcept;
  void measure_edges() noexcept;

  static constexpr std::array<int, directions> step_x{1, 1, 0, -1, -1, -1, 0, 1};
  static constexpr std::array<int, directions> step_y{0, 1, 1, 1, 0, -1, -1, -1};

  HalfSize arena_;
  double least_keep_, keep_, cell_, left_, bottom_;
  std::size_t columns_, rows_;
  HalfSize most_, routes_;  // bounds on a midpoint's coordinates, and on a route's vertices
  std::vector<Place> places_;
  std::vector<std::uint8_t> free_, open_;  // open_: a bit for each direction
  std::vector<std::size_t> part_;
  std::vector<std::uint8_t> moved_;  // the place is another than when its edges were measured
  std::vector<Edge> edges_;
  std::vector<Obstacle> obstacles_;
  std::vector<Obstacle> close_;  // those near one cell
};

}  // namespace skein::core
