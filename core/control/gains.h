#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/control/pair_table.h"
#include "core/control/saturation.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// The form of the xx and theta-theta couplings.
enum class Coupling {
  /// As printed in (15). NOT bounded by k_xx, k_tt: with x_e,i = 0 and |x_e,j| = 1 m it shifts v by 0.72 m/s, so
  /// (18f, g) do not imply (14) and commands must be limited after the law.
  paper,
  /// sqrt(l) b_j phi(c(b_i - b_j)) / sqrt((1 + l b_i^2)(1 + l b_j^2)): keeps (21), hence (20), and is bounded by k, so
  /// that (18f, g) do imply (14).
  bounded,
};

/// As files call it (core/words.h).
constexpr std::string_view word(Coupling form) noexcept {
  switch (form) {
    case Coupling::paper:
      return "paper";
    case Coupling::bounded:
      return "bounded";
  }
  return {};
}

/// How the tracking gains k_x, k_theta are determined.
enum class GainPolicy {
  authority,  ///< all that (18f, g) leaves, as in (36): see `use_all_authority`
  fixed,      ///< given numbers, whatever the reference: constant, or moved by a TrackingSchedule
};

/// As files call it (core/words.h).
constexpr std::string_view word(GainPolicy policy) noexcept {
  switch (policy) {
    case GainPolicy::authority:
      return "authority";
    case GainPolicy::fixed:
      return "fixed";
  }
  return {};
}

/// The design parameters of the law (15) at one time. Robots counted from 0.
struct Gains {
  Saturation saturation = Saturation::tanh;
  Coupling coupling = Coupling::paper;
  GainPolicy policy = GainPolicy::authority;
  double k_y = 11.0;  ///< [rad/m]
  double k = 200.0;   ///< [1/m]

  std::vector<double> v_max;      ///< (14) [m/s]
  std::vector<double> omega_max;  ///< (14) [rad/s]
  std::vector<double> k_x;        ///< bound of the x tracking term [m/s]
  std::vector<double> c_x;        ///< its slope [1/m]
  std::vector<double> k_theta;    ///< bound of the heading tracking term [rad/s]
  std::vector<double> c_theta;    ///< its slope [1/rad]
  /// GainPolicy::fixed: the largest k_x and k_theta of the whole run, which neither couplings that an operator changes
  /// nor modified references may use.
  std::vector<double> k_x_reserved, k_theta_reserved;

  PairTable k_xx, c_xx, l_xx;  ///< coupling of x errors: bound [m/s], slope [1/m], weight [1/m^2]
  PairTable k_tt, c_tt, l_tt;  ///< coupling of heading errors: bound [rad/s], slope [1/rad], weight [1/rad^2]
  PairTable k_yy, c_yy;        ///< coupling of y errors: bound [rad/s], slope [1/m]

  std::size_t robots() const noexcept { return v_max.size(); }
};

/// The share of v_max and omega_max that is reserved for tracking: neither the couplings nor a modified reference may
/// use it, so that (18a) holds for the gains of (36). 5 % still corrects 1 cm in 2 s, and leaves nearly everything to
/// the experiment.
inline constexpr double tracking_share = 0.05;

/// The values of (36) for n robots. k_x and k_theta are those of `use_all_authority` at standstill.
Gains paper_gains(std::size_t robots);

/// (18f, g) met with equality, as (36) does: all authority that the reference and the couplings leave goes to tracking,
///   k_x,i = v_max,i - |v_ref,i| - sum_j k_xx,i,j
///   k_theta,i = omega_max,i - |omega_ref,i| - k_y |v_ref,i| - sum_j (k_tt,i,j + k_yy,i,j).
/// Can be negative; then (18a) fails: see `margins`.
void use_all_authority(Gains& gains, std::span<const Twist> reference) noexcept;

/// The tracking gains of the policy with these references: `use_all_authority`, or unchanged.
void use_policy(Gains& gains, std::span<const Twist> reference) noexcept;

/// The parts of robot i's v_max [m/s] and omega_max [rad/s] that reference and couplings may use together: those not
/// reserved for tracking, by `tracking_share` or by fixed gains.
double free_v(const Gains& gains, std::size_t i) noexcept;
double free_omega(const Gains& gains, std::size_t i) noexcept;

/// The margin of one robot in each inequality of (18); negative: violated. (a) must be above 0, the others at least
/// 0.
struct Margins {
  double a;  ///< smallest of k_x, k_theta, c_x, c_theta, k_y, k
  double b;  ///< smallest of its coupling parameters
  double c;  ///< minus the largest asymmetry of its k_xx, k_tt, k_yy: 0, since a PairTable cannot be asymmetric
  double d;  ///< the same of c_xx, c_tt, c_yy
  double e;  ///< the same of l_xx, l_tt
  double f;  ///< v_max - |v_ref| - k_x - sum k_xx [m/s]
  double g;  ///< omega_max - |omega_ref| - k_theta - k_y |v_ref| - sum (k_tt + k_yy) [rad/s]

  bool hold(double rounding = 1e-12) const noexcept {
    return a > 0.0 && b >= 0.0 && c >= 0.0 && d >= 0.0 && e >= 0.0 && f >= -rounding && g >= -rounding;
  }
};

/// The margins of (18) for robot i with its present reference velocities.
Margins margins(const Gains& gains, std::size_t i, const Twist& reference) noexcept;

}  // namespace skein::core
