#include "core/control/gain_room.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein::core {
namespace {

PairTable times(const PairTable& table, double factor) {
  PairTable result(table.robots());
  for (std::size_t i = 0; i < table.robots(); ++i)
    for (std::size_t j = i + 1; j < table.robots(); ++j) result.set(i, j, factor * table(i, j));
  return result;
}

}  // namespace

std::optional<GainName> shares_limit_with(GainName name) noexcept {
  switch (name) {
    case GainName::k_tt:
      return GainName::k_yy;
    case GainName::k_yy:
      return GainName::k_tt;
    case GainName::k_xx:
    case GainName::c_xx:
    case GainName::c_tt:
    case GainName::c_yy:
    case GainName::l_xx:
    case GainName::l_tt:
      break;
  }
  return std::nullopt;
}

std::optional<double> lowered_for(GainName name, double wanted, GainName other, const GainRoom& room,
                                  const PairTable& coupled, double per_unit) {
  const Gains& gains = room.gains;
  if (gains.robots() < 2 || shares_limit_with(name) != other) return std::nullopt;
  const auto partners = static_cast<double>(gains.robots() - 1);
  double most = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < gains.robots(); ++i) {
    const double left = free_omega(gains, i) - room.demand.turning - partners * wanted;
    if (const double sharing = coupled.row_sum(i); sharing > 0.0) most = std::min(most, left / sharing);
  }
  CouplingGains lowered = room.couplings;
  const auto suffices = [&](double steps) {
    table(lowered, other) = times(coupled, steps / per_unit);
    return gain_limit(name, gains, lowered, room.demand) >= wanted;
  };
  // The limit is computed in another order, and may come out an ulp below what is wanted.
  double steps = std::isfinite(most) ? std::floor(most * per_unit) : 0.0;
  if (steps >= 1.0 && !suffices(steps)) steps -= 1.0;
  if (steps < 0.0 || !suffices(steps)) return std::nullopt;
  return steps / per_unit;
}

std::optional<double> lowered_for(GainName name, std::size_t i, std::size_t j, double wanted, GainName other,
                                  const GainRoom& room, double per_unit) {
  if (shares_limit_with(name) != other) return std::nullopt;
  CouplingGains lowered = room.couplings;
  const auto limit_with = [&](double steps) {
    table(lowered, other).set(i, j, steps / per_unit);
    return gain_limit(name, i, j, room.gains, lowered, room.demand);
  };
  double steps = std::floor((limit_with(0.0) - wanted) * per_unit);
  while (steps >= 1.0 && limit_with(steps) < wanted) steps -= 1.0;
  if (steps < 0.0 || limit_with(steps) < wanted) return std::nullopt;
  return steps / per_unit;
}

double given_up_for(GainName name, std::size_t i, std::size_t j, double wanted, const GainRoom& room) noexcept {
  const PairTable& own = table(room.couplings, name);
  const double with_others = own.row_sum(i) - own(i, j);
  return std::max(0.0, with_others + wanted - row_limit(name, i, room.gains, room.couplings, room.demand));
}

}  // namespace skein::core
