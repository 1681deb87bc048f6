#pragma once

#include <array>
#include <cstddef>

namespace skein::core {

/// The delay of a clock behind the experiment's: it slows down, runs slowly or stands for a while, then runs faster
/// until it has caught up. Its rate is continuous. A robot that yields follows its reference on such a clock, and so
/// does a formation that waits for one of its robots: robots that share a clock keep the formation's distances.
class Delay {
 public:
  Delay() = default;  ///< none
  /// Stands for `stands` [s] from `begins` on, and catches up at a rate of 1 + `hurry` (above 0). Its rate changes by
  /// at most `slope` [1/s].
  Delay(double begins, double stands, double hurry, double slope) noexcept
      : Delay({begins, 0.0, 0.0}, 1.0, stands, hurry, slope) {}

  /// The state of a clock at time t: how far it is behind, and by how much it falls behind per second (1 minus its
  /// rate). [s]
  struct Moment {
    double t = 0.0, behind = 0.0, falls = 0.0;
  };
  /// The same from a moment on, at which the clock need not be on time; for `stands` it falls behind by `falls` a
  /// second (1: it stands; as the moment says and `stands` 0: it catches up at once). A clock that is too little
  /// behind to reach `hurry` catches up more slowly.
  Delay(const Moment& begins, double falls, double stands, double hurry, double slope) noexcept;

  double at(double t) const noexcept;    ///< [s], never negative
  double rate(double t) const noexcept;  ///< of the clock: 1 - d(at)/dt
  double begins() const noexcept { return knots_[0].t; }
  double ends() const noexcept { return knots_[most - 1].t; }
  double most_behind() const noexcept { return most_behind_; }  ///< [s]

 private:
  static constexpr std::size_t most = 6;
  struct Knot {
    double t = 0.0, slope = 0.0, at = 0.0;  // the clock falls behind by `slope`, linear between two knots
  };
  std::size_t knot(double t) const noexcept;
  std::array<Knot, most> knots_{};
  double most_behind_ = 0.0;
};

}  // namespace skein::core
