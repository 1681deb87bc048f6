#include "core/control/gain_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein::core {
namespace {

template <typename Function>
void for_each_pair(std::size_t robots, Function&& function) {
  for (std::size_t i = 0; i < robots; ++i)
    for (std::size_t j = i + 1; j < robots; ++j) function(i, j);
}

}  // namespace

const PairTable& table(const CouplingGains& gains, GainName name) noexcept {
  return name == GainName::k_xx ? gains.k_xx : name == GainName::k_tt ? gains.k_tt : gains.k_yy;
}

PairTable& table(CouplingGains& gains, GainName name) noexcept {
  return const_cast<PairTable&>(table(static_cast<const CouplingGains&>(gains), name));
}

double gain_border(GainName name, const Gains& gains, const CouplingGains& others,
                   const ReferenceDemand& demand) noexcept {
  if (gains.robots() < 2) return 0.0;
  const auto partners = static_cast<double>(gains.robots() - 1);
  double border = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < gains.robots(); ++i) {
    const double left = name == GainName::k_xx
                            ? (1.0 - tracking_share) * gains.v_max[i] - demand.v
                            : (1.0 - tracking_share) * gains.omega_max[i] - demand.turning -
                                  table(others, name == GainName::k_tt ? GainName::k_yy : GainName::k_tt).row_sum(i);
    border = std::min(border, left / partners);
  }
  return std::max(0.0, border);
}

void GainSchedule::ramp(GainName name, const PairTable& target, double seconds) noexcept {
  const PairTable& from = table(now_, name);
  PairTable& rate = table(rate_, name);
  table(target_, name) = target;
  for_each_pair(target.robots(), [&](std::size_t i, std::size_t j) {
    rate.set(i, j,
             seconds > 0.0 ? std::abs(target(i, j) - from(i, j)) / seconds : std::numeric_limits<double>::infinity());
  });
}

void GainSchedule::move(GainName name, double value, double rate) noexcept {
  table(target_, name).fill(value);
  table(rate_, name).fill(rate);
}

void GainSchedule::step(double dt) noexcept {
  if (!(dt > 0.0)) return;  // an instant rate times no time is not a number
  for (const GainName name : gain_names) {
    PairTable& now = table(now_, name);
    const PairTable& target = table(target_, name);
    const PairTable& rate = table(rate_, name);
    for_each_pair(now.robots(), [&](std::size_t i, std::size_t j) {
      const double change = target(i, j) - now(i, j);
      const double most = rate(i, j) * dt;
      now.set(i, j, std::abs(change) <= most ? target(i, j) : now(i, j) + std::copysign(most, change));
    });
  }
}

}  // namespace skein::core
