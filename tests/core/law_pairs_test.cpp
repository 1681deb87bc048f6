// The law for big groups, many pairs at once, against the law pair by pair: the same commands to 1e-12 of the limits.
#include <algorithm>

#include "core/control/coordination_law.h"
#include "draw.h"
#include "literal_law.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Coupling;
using core::Instructions;
using core::LawPairs;
using core::Saturation;
using core::TrackingError;
using core::Twist;

/// Couplings of the same size, slope and weight for all pairs, as an experiment file gives them.
void make_uniform(Group& group, Draw& draw) {
  auto& g = group.gains;
  for (core::PairTable* k : {&g.k_xx, &g.k_tt, &g.k_yy}) k->fill(draw.chance(0.1) ? 0.0 : k->largest());
  for (core::PairTable* c : {&g.c_xx, &g.c_tt, &g.c_yy}) c->fill(draw.chance(0.1) ? 0.0 : draw.decades(-2.0, 1.5));
  for (core::PairTable* l : {&g.l_xx, &g.l_tt}) l->fill(draw.chance(0.1) ? 0.0 : draw.decades(-1.0, 3.0));
}

std::vector<Twist> commands(const Group& group, LawPairs* pairs) {
  std::vector<Twist> command(group.robots());
  if (pairs)
    core::coordination_law(group.gains, group.errors, group.reference, command, *pairs);
  else
    core::coordination_law(group.gains, group.errors, group.reference, command);
  return command;
}

/// What 1e-12 is relative to: the limit, and where (as with the printed coupling) the terms exceed it, these.
Twist sizes(const Group& group, std::size_t i) {
  return {std::max(group.gains.v_max[i], literal_v(group, i).size),
          std::max(group.gains.omega_max[i], literal_omega(group, i).size)};
}

/// The largest difference between the two, as a share of these.
double difference(const Group& group) {
  LawPairs pairs(group.robots());
  const std::vector<Twist> plain = commands(group, nullptr), fast = commands(group, &pairs);
  double largest = 0.0;
  for (std::size_t i = 0; i < group.robots(); ++i) {
    const Twist size = sizes(group, i);
    largest = std::max(
        {largest, std::abs(fast[i].v - plain[i].v) / size.v, std::abs(fast[i].omega - plain[i].omega) / size.omega});
  }
  return largest;
}

TEST(LawPairs, AreTheLawPairByPair) {
  holds("uniform and general tables, errors of every size, both saturations, both couplings", [] {
    const int n = any_of(1, 60);
    Draw draw(any_seed());
    Group group = random_group(draw, static_cast<std::size_t>(n));
    if (draw.chance(0.5))
      make_uniform(group, draw);
    else if (draw.chance(0.7))  // slopes alike, the rest each pair's own
      for (core::PairTable* c : {&group.gains.c_xx, &group.gains.c_tt, &group.gains.c_yy})
        c->fill(draw.decades(-2.0, 1.5));
    RC_ASSERT(difference(group) <= 1e-12);
  });
}

TEST(LawPairs, AreTheLawInGroupsOfTwoHundred) {
  Draw draw(15);
  for (int k = 0; k < 24; ++k) {
    Group group =
        random_group(draw, static_cast<std::size_t>(draw.whole(100, 200)), k % 2 ? Coupling::paper : Coupling::bounded);
    group.gains.saturation = k % 4 < 2 ? Saturation::tanh : Saturation::algebraic;
    make_uniform(group, draw);
    EXPECT_LE(difference(group), 1e-12) << k;
  }
}

TEST(LawPairs, KeepTheDigitsWhereBothSaturateAndWhereErrorsAreTiny) {
  // Both far on one side: tanh a and tanh b are 1 to the last digit, and what counts is their arguments' difference.
  holds("near each other, far out or near zero", [] {
    Draw draw(any_seed());
    Group group = random_group(draw, 20);
    make_uniform(group, draw);
    group.gains.saturation = Saturation::tanh;
    const double c = 1.0;
    for (core::PairTable* table : {&group.gains.c_xx, &group.gains.c_tt, &group.gains.c_yy}) table->fill(c);
    const double centre = draw.chance(0.3) ? 0.0 : draw.sign() * draw.between(0.0, 149.0);
    const double spread = draw.decades(-12.0, 0.0);
    for (TrackingError& e : group.errors)
      e = {centre + draw.between(-spread, spread), centre + draw.between(-spread, spread),
           draw.between(-spread, spread)};
    LawPairs pairs(20);
    RC_ASSERT(pairs.suit(group.gains, group.errors));
    RC_ASSERT(difference(group) <= 1e-12);
  });
}

TEST(LawPairs, LeaveToThePlainLawWhatTheyCannotDo) {
  Draw draw(3);
  Group group = random_group(draw, 20);
  make_uniform(group, draw);
  group.gains.saturation = Saturation::tanh;
  group.gains.c_xx.fill(1.0);
  LawPairs pairs(20);
  ASSERT_TRUE(pairs.suit(group.gains, group.errors));
  group.errors[7].x = 200.0;  // exp(2 c x) and its like would run out of range
  EXPECT_FALSE(pairs.suit(group.gains, group.errors));
  EXPECT_EQ(commands(group, &pairs), commands(group, nullptr));
  group.errors[7].x = 0.1;
  group.gains.c_xx.set(2, 3, 5.0);  // every pair its own slope
  EXPECT_FALSE(pairs.suit(group.gains, group.errors));
  EXPECT_EQ(commands(group, &pairs), commands(group, nullptr));
}

TEST(LawPairs, AreTheSameBitsOnEveryProcessor) {
  if (core::best_instructions() == Instructions::baseline) GTEST_SKIP() << "this machine has no wider ones";
  holds("baseline and AVX2 give the same bits", [] {
    const int n = any_of(16, 90);
    Draw draw(any_seed());
    Group group = random_group(draw, static_cast<std::size_t>(n));
    if (draw.chance(0.7)) make_uniform(group, draw);
    LawPairs narrow(group.robots(), Instructions::baseline), wide(group.robots(), Instructions::avx2);
    RC_ASSERT(commands(group, &narrow) == commands(group, &wide));
  });
}

TEST(LawPairs, AreBitForBitTheLawInASmallGroup) {
  Draw draw(4);
  const Group group = random_group(draw, 4);
  LawPairs pairs(4);
  EXPECT_EQ(commands(group, &pairs), commands(group, nullptr));
}

TEST(PairTable, KnowsWhetherAllPairsAreAlike) {
  core::PairTable table(5, 1.0);
  EXPECT_TRUE(table.uniform());
  table.set(1, 3, 2.0);
  EXPECT_FALSE(table.uniform());
  EXPECT_EQ(table.row(1)[1], 2.0);
  table.fill(2.0);
  EXPECT_TRUE(table.uniform());
}

}  // namespace
}  // namespace skein::test
