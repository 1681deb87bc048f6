#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace skein::core {

/// A round obstacle that stands on the floor.
struct Obstacle {
  double x = 0.0;       ///< [m]
  double y = 0.0;       ///< [m]
  double radius = 0.0;  ///< [m]; 0: not there
  friend bool operator==(const Obstacle&, const Obstacle&) = default;
};

/// The body that distances of parameters are meant for, an e-puck's: what is to be kept between midpoints, or around
/// one, holds for bodies of this radius. [m]
inline constexpr double standard_radius = 0.035;

/// How much larger the bodies of a group are than that; smaller: negative. A pair keeps what two standard bodies would,
/// and both of these on top: so the gap between any two bodies is the same. [m]
class Sizes {
 public:
  Sizes() noexcept = default;
  /// `beyond`: radius less `standard_radius` of each robot; empty: all are standard bodies. Outlives this.
  explicit Sizes(std::span<const double> beyond) noexcept : beyond_(beyond) {
    for (const double b : beyond) most_ = std::max(most_, b);
  }
  double beyond(std::size_t i) const noexcept { return beyond_.empty() ? 0.0 : beyond_[i]; }
  double beyond(std::size_t i, std::size_t j) const noexcept { return beyond(i) + beyond(j); }
  double most() const noexcept { return most_; }  ///< of the largest, at least 0
 private:
  std::span<const double> beyond_;
  double most_ = 0.0;
};

/// The obstacles of a run: those that it began with, and those that are dropped, moved and taken away meanwhile. Each
/// keeps its number. Only the constructor allocates.
class ObstacleField {
 public:
  static constexpr std::size_t room_for_more = 16;

  explicit ObstacleField(const std::vector<Obstacle>& first) : all_(first), standing_(first) {
    all_.resize(first.size() + room_for_more);
    standing_.reserve(all_.size());
  }

  /// All numbers, those that are not there too.
  std::span<const Obstacle> all() const noexcept { return all_; }
  std::span<const Obstacle> standing() const noexcept { return standing_; }
  /// Puts one somewhere, or with radius 0 takes it away. False: there is no such number, or it was so already.
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
