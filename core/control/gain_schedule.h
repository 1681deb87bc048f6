#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/control/gains.h"

namespace skein::core {

/// The parameters of the couplings of all pairs: their bounds, slopes and weights, as in `Gains`.
struct CouplingGains {
  PairTable k_xx, k_tt, k_yy;
  PairTable c_xx{}, c_tt{}, c_yy{}, l_xx{}, l_tt{};
  friend bool operator==(const CouplingGains&, const CouplingGains&) = default;
};

enum class GainName { k_xx, k_tt, k_yy, c_xx, c_tt, c_yy, l_xx, l_tt };

/// As files, logs and the CSV call it (core/words.h).
constexpr std::string_view word(GainName name) noexcept {
  switch (name) {
    case GainName::k_xx:
      return "k_xx";
    case GainName::k_tt:
      return "k_tt";
    case GainName::k_yy:
      return "k_yy";
    case GainName::c_xx:
      return "c_xx";
    case GainName::c_tt:
      return "c_tt";
    case GainName::c_yy:
      return "c_yy";
    case GainName::l_xx:
      return "l_xx";
    case GainName::l_tt:
      return "l_tt";
  }
  return {};
}

/// The strengths of the couplings, which (18f, g) bound and the operator may change.
inline constexpr std::array gain_names{GainName::k_xx, GainName::k_tt, GainName::k_yy};
/// All parameters of a pair.
inline constexpr std::array pair_names{GainName::k_xx, GainName::k_tt, GainName::k_yy, GainName::c_xx,
                                       GainName::c_tt, GainName::c_yy, GainName::l_xx, GainName::l_tt};

/// The largest velocities of a reference over its whole course; couplings may use the remainder.
struct ReferenceDemand {
  double v = 0.0;        ///< largest |v_ref| [m/s]
  double turning = 0.0;  ///< largest |omega_ref| + k_y |v_ref| [rad/s]
};

/// The largest sum that robot i's gains of one name may have: what (18f) or (18g) leaves after the gain that shares the
/// bound and `tracking_share`. May be negative; infinite for slopes and weights, which have no bound.
double row_limit(GainName name, std::size_t i, const Gains& gains, const CouplingGains& couplings,
                 const ReferenceDemand& demand) noexcept;

/// The largest value that one gain may have for all pairs at once: (18f, g) hold, and `tracking_share` of v_max and
/// omega_max is left to tracking at every point of the reference. Never negative. `others` holds the gains that share
/// the bound (18g).
double gain_limit(GainName name, const Gains& gains, const CouplingGains& others,
                  const ReferenceDemand& demand) noexcept;

/// The same for one pair; all other pairs keep their values in `others`.
double gain_limit(GainName name, std::size_t i, std::size_t j, const Gains& gains, const CouplingGains& others,
                  const ReferenceDemand& demand) noexcept;

/// The share of one gain's table that (18f, g) allow with the others unchanged; 1: all of it.
double held_share(GainName name, const Gains& gains, const CouplingGains& couplings,
                  const ReferenceDemand& demand) noexcept;

/// Coupling gains that change with time, without jumps: Theorem 1 requires continuous gains.
class GainSchedule {
 public:
  explicit GainSchedule(CouplingGains start) : now_(start), target_(start), rate_(std::move(start)) {}

  const CouplingGains& now() const noexcept { return now_; }
  const CouplingGains& target() const noexcept { return target_; }

  /// Every pair moves to its value in `target` within `seconds`, each at its own constant rate.
  void ramp(GainName name, const PairTable& target, double seconds) noexcept;
  /// All pairs move to `value` at most `rate` per second.
  void move(GainName name, double value, double rate) noexcept;
  /// The same for one pair.
  void move(GainName name, std::size_t i, std::size_t j, double value, double rate) noexcept;
  void step(double dt) noexcept;

 private:
  CouplingGains now_, target_, rate_;
};

enum class TrackingGain { k_x, k_theta };

/// As files, logs and the CSV call it (core/words.h).
constexpr std::string_view word(TrackingGain name) noexcept {
  switch (name) {
    case TrackingGain::k_x:
      return "k_x";
    case TrackingGain::k_theta:
      return "k_theta";
  }
  return {};
}

inline constexpr std::array tracking_names{TrackingGain::k_x, TrackingGain::k_theta};

/// One value for each robot, of each tracking gain: `gains[TrackingGain::k_x][i]`. [m/s; rad/s]
template <typename Value>
struct TrackingTable {
  std::array<std::vector<Value>, tracking_names.size()> values;

  std::vector<Value>& operator[](TrackingGain name) { return values[static_cast<std::size_t>(name)]; }
  const std::vector<Value>& operator[](TrackingGain name) const { return values[static_cast<std::size_t>(name)]; }
  friend bool operator==(const TrackingTable&, const TrackingTable&) = default;
};
using TrackingGains = TrackingTable<double>;
using TrackingChange = TrackingTable<std::optional<double>>;  ///< nullopt, or no values at all: unchanged

/// k_x,i(t) and k_theta,i(t) of GainPolicy::fixed, piecewise linear in time: Theorem 1 requires continuous gains.
class TrackingSchedule {
 public:
  explicit TrackingSchedule(TrackingGains start) : now_(start), target_(start), rate_(std::move(start)) {}

  const TrackingGains& now() const noexcept { return now_; }
  const TrackingGains& target() const noexcept { return target_; }

  /// Every robot with a value in `change` moves to it within `seconds`, each at its own constant rate.
  void ramp(const TrackingChange& change, double seconds) noexcept;
  void step(double dt) noexcept;

 private:
  TrackingGains now_, target_, rate_;
};

PairTable& table(CouplingGains& gains, GainName name) noexcept;
const PairTable& table(const CouplingGains& gains, GainName name) noexcept;

}  // namespace skein::core
