#pragma once

#include <array>
#include <cstddef>

#include "core/planning/delay.h"
#include "core/planning/lattice.h"
#include "core/planning/route.h"
#include "core/reference/reference.h"

namespace skein::core {

/// How far beside its place a robot drives, over time: it leaves the lane, stays beside it and returns, and stays
/// abreast of its place throughout. It changes with a bounded third derivative, and is measured across a mean heading
/// of the place: otherwise the outside of a corner would require a jump in speed.
class Sidestep {
 public:
  /// To the left of the place [m], and how that changes [m/s, m/s^2].
  struct Aside {
    double by = 0.0, rate = 0.0, bend = 0.0;
  };
  /// To `height` [m] to the left within `rises`, there for `stays`, and back to 0 within `falls`. [s]
  struct Profile {
    double height = 0.0, rises = 0.0, stays = 0.0, falls = 0.0;
  };
  Sidestep() = default;  ///< none
  /// From `from` at time t. `delay`: of the place's clock. `mean`: its heading is a mean over four of them to both
  /// sides [s].
  Sidestep(double t, const Aside& from, const Profile& profile, const Delay& delay = {}, double mean = 0.1) noexcept;

  Aside at(double t) const noexcept;
  double begins() const noexcept { return begins_; }  ///< [s]
  double ends() const noexcept;                       ///< when it is back, and the clock on time [s]
  const Delay& delay() const noexcept { return delay_; }
  /// The place of robot i at time t, shifted: its heading is that of its motion.
  ReferencePoint shift(const Reference& reference, std::size_t i, double t) const noexcept;
  /// The same without its velocities.
  Pose pose(const Reference& reference, std::size_t i, double t) const noexcept;

 private:
  double begins_ = 0.0;
  Profile profile_;
  double mean_step_ = 0.1;
  std::array<double, 6> rise_{};  // a polynomial in the time since `begins_`
  Delay delay_;
};

/// The ways of one robot past obstacles on its place's lane; the first one leaves the lane least. Each keeps (18f, g),
/// and comes near to obstacles and edges no faster than the shield allows; it does not consider other robots. Of fixed
/// size: it never allocates.
class SidestepSearch {
 public:
  struct Query {
    std::size_t robot = 0;
    double t = 0.0;        ///< now [s]
    Sidestep::Aside from;  ///< now
    Delay delay;           ///< of the place's clock
    Pace pace;             ///< v, and omega + k_y v: at most
    double k_y = 11.0;     ///< of (18g) [rad/m]
    double gamma = 4.0;    ///< of the shield [1/s]
    std::size_t most_work = 4000;
  };
  enum class Lane {
    free,     ///< nothing to pass
    later,    ///< there is, and time to begin later
    blocked,  ///< there is: `next` gives the ways past it
  };
  Lane begin(const Query& query, const Reference& reference, const Lattice& lattice) noexcept;
  /// The next way; false: there is no other.
  bool next(Sidestep& way) noexcept;

  /// Whether a way that is being driven stays clear of obstacles and edges from time t on.
  static bool clear(const Sidestep& way, std::size_t robot, double t, const Reference& reference,
                    const Lattice& lattice) noexcept;

  /// Work since `begin`, in nodes: about a microsecond each.
  std::size_t work() const noexcept { return samples_ / 8; }

  static constexpr double looks_ahead = 10.0;  ///< for obstacles [s]

 private:
  struct At {
    Pose pose;
    Twist twist;
    double heading, turning;  // means [rad, rad/s]
    bool blocked;             // by an obstacle
  };
  bool sample(std::size_t from, std::size_t to) noexcept;
  void take_means() noexcept;
  bool find_obstacles() noexcept;
  double needs(double side, std::size_t k) noexcept;
  double leads(double height) const noexcept;
  bool fits(const Sidestep& way) noexcept;
  bool next_shape() noexcept;
  bool begin_again() noexcept;

  static constexpr double step = 0.1;  // [s]
  static constexpr std::size_t samples = 320;
  static constexpr std::size_t shapes = 12;

  Query query_;
  const Reference* reference_ = nullptr;
  const Lattice* lattice_ = nullptr;
  std::array<At, samples> places_{};
  std::size_t first_ = 0, last_ = 0;                   // of the samples whose place is in an obstacle
  std::array<double, 2> needed_{};                     // to the left, to the right [m]
  double height_ = 0.0, least_ = 0.0, highest_ = 0.0;  // [m]
  std::size_t manner_ = 0, side_ = 0, shape_ = 0, together_ = 0;
  std::size_t samples_ = 0;
};

}  // namespace skein::core
