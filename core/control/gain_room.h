#pragma once

#include <optional>

#include "core/control/gain_schedule.h"

namespace skein::core {

/// The gain with which `name` shares a bound of (18f, g), which limits their sum. Nothing: `name` has a bound of its
/// own.
std::optional<GainName> shares_limit_with(GainName name) noexcept;

/// The gains for which the functions below find room in (18f, g): those of the robots, with `couplings` instead of
/// their own.
struct GainRoom {
  const Gains& gains;
  const CouplingGains& couplings;
  const ReferenceDemand& demand;
};

/// The value to which `other` must be lowered, in all coupled pairs, so that (18f, g) allow `name` the value `wanted`
/// in all pairs: the largest multiple of 1 / `per_unit` at which `gain_limit` is at least `wanted`. Nothing: the two
/// gains share no bound, or even 0 would be too high. `coupled(i, j)` is 0 where a pair is switched off.
std::optional<double> lowered_for(GainName name, double wanted, GainName other, const GainRoom& room,
                                  const PairTable& coupled, double per_unit);

/// The same for one pair: the value to which its gain `other` must be lowered so that (18f, g) allow its gain `name`
/// the value `wanted`. Nothing: the two gains share no bound, or even 0 would be too high.
std::optional<double> lowered_for(GainName name, std::size_t i, std::size_t j, double wanted, GainName other,
                                  const GainRoom& room, double per_unit);

/// By how much the gains `name` of robot i's other pairs must be lowered, in total, so that (18f, g) allow the pair
/// (i, j) the value `wanted`; 0: no change is needed. A result above the sum of those gains: no change is enough.
double given_up_for(GainName name, std::size_t i, std::size_t j, double wanted, const GainRoom& room) noexcept;

}  // namespace skein::core
