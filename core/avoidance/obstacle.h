#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace skein::core {

/// A round obstacle on the floor.
struct Obstacle {
  double x = 0.0;       ///< [m]
  double y = 0.0;       ///< [m]
  double radius = 0.0;  ///< [m]; 0: not there
  friend bool operator==(const Obstacle&, const Obstacle&) = default;
};

/// The radius of the standard body, that of an e-puck: parameters that are distances between midpoints, or from a
/// midpoint, hold for bodies of this radius. [m]
inline constexpr double standard_radius = 0.035;

/// By how much the radius of each body of a group exceeds `standard_radius`; negative: smaller. A pair keeps the
/// distance of two standard bodies plus both of these, so that the gap between any two bodies is the same. [m]
class Sizes {
 public:
  Sizes() noexcept = default;
  /// `beyond`: each robot's radius minus `standard_radius`; empty: all are standard bodies. Must outlive this object.
  explicit Sizes(std::span<const double> beyond) noexcept : beyond_(beyond) {
    for (const double b : beyond) most_ = std::max(most_, b);
  }
  double beyond(std::size_t i) const noexcept { return beyond_.empty() ? 0.0 : beyond_[i]; }
  double beyond(std::size_t i, std::size_t j) const noexcept { return beyond(i) + beyond(j); }
  double most() const noexcept { return most_; }  ///< the value of the largest body, at least 0
 private:
  std::span<const double> beyond_;
  double most_ = 0.0;
};

/// The obstacles of a run: those of the file, and those that are added, moved and removed during the run. Each keeps
/// its number. Only the constructor allocates.
class ObstacleField {
 public:
  static constexpr std::size_t room_for_more = 16;

  explicit ObstacleField(const std::vector<Obstacle>& first) : all_(first), standing_(first) {
    all_.resize(first.size() + room_for_more);
    standing_.reserve(all_.size());
  }

  /// All numbers, including absent obstacles.
  std::span<const Obstacle> all() const noexcept { return all_; }
  std::span<const Obstacle> standing() const noexcept { return standing_; }
  /// Places an obstacle, or removes it with radius 0. False: there is no such number, or nothing changed.
  bool put(std::size_t number, const Obstacle& obstacle) noexcept {
    if (number >= all_.size() || all_[number] == obstacle) return false;
    all_[number] = obstacle;
    standing_.clear();
    for (const Obstacle& o : all_)
      if (o.radius > 0.0) standing_.push_back(o);
    return true;
  }

 private:
  std::vector<Obstacle> all_, standing_;
};

}  // namespace skein::core
