// Which gain makes room for another one under (18g), and how far it has to be lowered.
#include "core/control/gain_room.h"

#include <cmath>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::CouplingGains;
using core::GainName;
using core::Gains;
using core::PairTable;
using core::ReferenceDemand;

constexpr double per_unit = 1e4;  // as the window shows them

/// Gains of which each pair has its own; some pairs may be switched off.
struct Room {
  Gains gains;
  CouplingGains couplings;
  PairTable coupled;
  ReferenceDemand demand;

  explicit Room(Draw& draw) : Room(draw, static_cast<std::size_t>(draw.whole(2, 8))) {}
  Room(Draw& draw, std::size_t n)
      : gains(core::paper_gains(n)),
        couplings{PairTable(n), PairTable(n), PairTable(n)},
        coupled(n, 1.0),
        demand{draw.between(0.0, 0.06), draw.between(0.0, 1.3)} {
    for (std::size_t i = 0; i < n; ++i) gains.omega_max[i] = draw.between(1.4, 4.0);
    const double some_off = draw.chance(0.5) ? 0.3 : 0.0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) {
        if (draw.chance(some_off)) coupled.set(i, j, 0.0);
        for (const GainName name : core::gain_names)
          core::table(couplings, name).set(i, j, coupled(i, j) * draw.between(0.0, 0.2));
      }
  }
  /// What is left to `name` for all pairs, once the pairs of `other` that are coupled have this value.
  double limit(GainName name, GainName other, double value) const {
    CouplingGains set = couplings;
    for (std::size_t i = 0; i < gains.robots(); ++i)
      for (std::size_t j = i + 1; j < gains.robots(); ++j) core::table(set, other).set(i, j, coupled(i, j) * value);
    return core::gain_limit(name, gains, set, demand);
  }
};

TEST(GainRoom, TheNumberThatIsGivenMakesTheWantedValuePossibleAndNoLargerOneDoes) {
  int given = 0, none = 0;
  holds("set as proposed, (18g) allows what was wanted; a ten-thousandth more, and it does not", [&] {
    Draw draw(any_seed());
    const Room room(draw);
    const bool yy = draw.chance(0.5);
    const GainName name = yy ? GainName::k_yy : GainName::k_tt, other = yy ? GainName::k_tt : GainName::k_yy;
    const double limit = core::gain_limit(name, room.gains, room.couplings, room.demand);
    const double wanted = std::ceil((limit + draw.between(0.0, 0.15)) * per_unit) / per_unit;
    RC_PRE(wanted > limit);
    const auto to =
        core::lowered_for(name, wanted, other, {room.gains, room.couplings, room.demand}, room.coupled, per_unit);
    if (!to) {
      ++none;
      RC_ASSERT(room.limit(name, other, 0.0) < wanted);
      return;
    }
    ++given;
    RC_ASSERT(*to >= 0.0);
    RC_ASSERT(room.limit(name, other, *to) >= wanted);
    RC_ASSERT(room.limit(name, other, *to + 1.0 / per_unit) < wanted);
    RC_ASSERT(*to <= core::table(room.couplings, other).largest());
  });
  EXPECT_GT(given, 5);
  EXPECT_GT(none, 5);
}

TEST(GainRoom, OfOnePairTheNumberThatIsGivenMakesTheWantedValuePossibleAndNoLargerOneDoes) {
  int given = 0, none = 0;
  holds("set as proposed, (18g) allows the pair what was wanted; a ten-thousandth more, and it does not", [&] {
    Draw draw(any_seed());
    const Room room(draw);
    const bool yy = draw.chance(0.5);
    const GainName name = yy ? GainName::k_yy : GainName::k_tt, other = yy ? GainName::k_tt : GainName::k_yy;
    const double limit = core::gain_limit(name, 0, 1, room.gains, room.couplings, room.demand);
    const double wanted = std::ceil((limit + draw.between(0.0, 0.15)) * per_unit) / per_unit;
    RC_PRE(wanted > limit);
    const auto limit_with = [&](double value) {
      CouplingGains set = room.couplings;
      core::table(set, other).set(0, 1, value);
      return core::gain_limit(name, 0, 1, room.gains, set, room.demand);
    };
    const auto to = core::lowered_for(name, 0, 1, wanted, other, {room.gains, room.couplings, room.demand}, per_unit);
    if (!to) {
      ++none;
      RC_ASSERT(limit_with(0.0) < wanted);
      return;
    }
    ++given;
    RC_ASSERT(*to >= 0.0);
    RC_ASSERT(limit_with(*to) >= wanted);
    RC_ASSERT(limit_with(*to + 1.0 / per_unit) < wanted);
    RC_ASSERT(*to <= core::table(room.couplings, other)(0, 1));
  });
  EXPECT_GT(given, 5);
  EXPECT_GT(none, 5);
}

TEST(GainRoom, WhatTheOtherPairsOfBothRobotsGiveUpIsWhatOnePairLacks) {
  int made = 0;
  holds("lowered by that much in total, the limit of the pair is what was wanted", [&] {
    Draw draw(any_seed());
    const Room room(draw, static_cast<std::size_t>(draw.whole(3, 8)));
    const GainName name = core::gain_names[static_cast<std::size_t>(draw.whole(0, 2))];
    const double limit = core::gain_limit(name, 0, 1, room.gains, room.couplings, room.demand);
    const double wanted = limit + draw.between(0.001, 0.1);
    CouplingGains lowered = room.couplings;
    core::PairTable& gains = core::table(lowered, name);
    for (const std::size_t robot : {0U, 1U}) {
      const double others = gains.row_sum(robot) - gains(0, 1);
      const double given_up =
          core::given_up_for(name, robot, 1 - robot, wanted, {room.gains, room.couplings, room.demand});
      RC_PRE(given_up <= others);
      for (std::size_t j = 2; j < room.gains.robots() && others > 0.0; ++j)
        gains.set(robot, j, gains(robot, j) * (1.0 - given_up / others));
    }
    ++made;
    RC_ASSERT(std::abs(core::gain_limit(name, 0, 1, room.gains, lowered, room.demand) - wanted) < 1e-12);
  });
  EXPECT_GT(made, 5);
}

TEST(GainRoom, NobodyMakesRoomForTheForwardGainNorItForOthers) {
  const Gains gains = core::paper_gains(4);
  const CouplingGains paper{gains.k_xx, gains.k_tt, gains.k_yy};
  const PairTable all(4, 1.0);
  for (const GainName other : core::gain_names) {
    EXPECT_FALSE(core::lowered_for(GainName::k_xx, 0.05, other, {gains, paper, {}}, all, per_unit));
    EXPECT_FALSE(core::lowered_for(other, 0.5, GainName::k_xx, {gains, paper, {}}, all, per_unit));
    EXPECT_FALSE(core::lowered_for(other, 0.5, other, {gains, paper, {}}, all, per_unit));
  }
}

}  // namespace
}  // namespace skein::test
