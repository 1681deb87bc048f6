#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/pose.h"
#include "core/planning/delay.h"
#include "core/planning/route.h"
#include "core/planning/sidestep.h"
#include "core/reference/reference.h"

namespace skein::core {

/// The expected position of every robot, at every tenth of a second from now on. Allocates in its constructor only.
class Traffic {
 public:
  static constexpr double step = 0.1;         ///< [s]
  static constexpr std::size_t steps = 1280;  ///< a robot that drives longer is assumed to stand at the end

  explicit Traffic(std::size_t robots)
      : x_(robots * steps), y_(robots * steps), still_from_(robots), present_(robots, false) {}

  std::size_t robots() const noexcept { return present_.size(); }
  bool present(std::size_t j) const noexcept { return present_[j]; }
  double x(std::size_t j, std::size_t k) const noexcept { return x_[j * steps + k]; }
  double y(std::size_t j, std::size_t k) const noexcept { return y_[j * steps + k]; }
  /// From this step on it stands.
  std::size_t still_from(std::size_t j) const noexcept { return still_from_[j]; }

  void remove(std::size_t j) noexcept { present_[j] = false; }
  void stands(std::size_t j, double x, double y) noexcept;
  /// Stands there for a while [s], and is absent afterwards.
  void stands(std::size_t j, double x, double y, double seconds) noexcept;
  /// Is absent from then on. [s]
  void leaves(std::size_t j, double seconds) noexcept;
  /// Drives a route from the route's time `clock` on [s].
  void drives(std::size_t j, const Route& route, double clock) noexcept;
  /// A reference that is at time t now, on a delayed clock; it is followed up to `horizon`. [s]
  struct Timetable {
    const Reference& reference;
    double t, horizon;
    Delay delay = {};
  };
  void follows(std::size_t j, const Timetable& timetable) noexcept;
  /// Follows its reference, beside it for a while.
  void follows(std::size_t j, const Timetable& timetable, const Sidestep& aside) noexcept;
  /// Is beside what was expected, by so much now [m], and back there within `seconds`.
  void shift(std::size_t j, double x, double y, double seconds) noexcept;
  /// Drives a route from the route's time `clock` on, which meets its place at `joins` [s]: then it follows its
  /// reference.
  void joins(std::size_t j, const Route& route, double clock, double joins, const Timetable& timetable) noexcept;
  /// Copies its motion from another traffic.
  void copy(std::size_t j, const Traffic& from) noexcept;
  /// Copies its motion from another traffic, which begins at time t, on a clock that falls behind. [s]
  void copy(std::size_t j, const Traffic& from, double t, const Delay& delay) noexcept;

 private:
  std::vector<double> x_, y_;
  std::vector<std::size_t> still_from_;
  std::vector<bool> present_;
};

}  // namespace skein::core
