#pragma once

#include <optional>

#include "core/control/gain_schedule.h"

namespace skein::core {

/// The gain with which `name` shares a bound of (18f, g), which limits their sum. Nothing: it has one of its own.
std::optional<GainName> shares_limit_with(GainName name) noexcept;

/// To what `other` has to be lowered, for all pairs that are coupled, so that (18f, g) allow `name` the value `wanted`
/// for all pairs: the largest multiple of 1 / `per_unit` with which `gain_limit` is no less than `wanted`. Nothing: the
/// two gains share no bound, or not even 0 would be low enough. `coupled(i, j)` is 0 where a pair is switched off.
std::optional<double> lowered_for(GainName name, double wanted, GainName other, const Gains& gains,
                                  const CouplingGains& couplings, const PairTable& coupled,
                                  const ReferenceDemand& demand, double per_unit);

/// The same for one pair: to what its gain `other` has to be lowered for (18f, g) to allow its gain `name` the value
/// `wanted`. Nothing: the two gains share no bound, or not even 0 would be low enough.
std::optional<double> lowered_for(GainName name, std::size_t i, std::size_t j, double wanted, GainName other,
                                  const Gains& gains, const CouplingGains& couplings, const ReferenceDemand& demand,
                                  double per_unit);

/// By how much robot i's gains `name` with robots other than j have to be lowered, in total, for (18f, g) to allow it
/// the value `wanted` for its pair with j; 0: they need not be. More than their sum: not even that would be enough.
double given_up_for(GainName name, std::size_t i, std::size_t j, double wanted, const Gains& gains,
                    const CouplingGains& couplings, const ReferenceDemand& demand) noexcept;

}  // namespace skein::core
