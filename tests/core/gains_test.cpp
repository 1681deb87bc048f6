// The conditions (18) and the gains of (36).
#include "core/control/gains.h"

#include <algorithm>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Gains;
using core::Margins;
using core::PairTable;
using core::Twist;

TEST(PairTable, IsOneCellAPairWhicheverWayItIsAsked) {
  for (std::size_t n = 2; n <= 12; ++n) {
    PairTable table(n);
    double number = 1.0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) table.set(j, i, number++);
    number = 1.0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) {
        EXPECT_EQ(table(i, j), number);
        EXPECT_EQ(table(j, i), number++);
      }
    EXPECT_EQ(table.largest(), number - 1.0);
  }
}

TEST(PairTable, OfOneOrNoRobotIsEmpty) {
  for (std::size_t n : {0u, 1u}) {
    const PairTable table(n, 7.0);
    EXPECT_EQ(table.largest(), 0.0);
    if (n == 1) {
      EXPECT_EQ(table.row_sum(0), 0.0);
    }
  }
}

TEST(Gains, OfThePaperLeave18fAnd18gWithEqualityAtStandstill) {
  for (std::size_t n = 1; n <= 12; ++n) {
    const Gains gains = core::paper_gains(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Margins m = core::margins(gains, i, {});
      EXPECT_NEAR(m.f, 0.0, 1e-16);
      EXPECT_NEAR(m.g, 0.0, 1e-15);
      EXPECT_NEAR(gains.k_x[i], 0.1 - static_cast<double>(n - 1) * 0.008, 1e-16);
      EXPECT_NEAR(gains.k_theta[i], 1.7 - static_cast<double>(n - 1) * 0.105, 1e-14);
    }
  }
}

TEST(Gains, OfThePaperLeaveTheReferenceSpeedsThatTheNotesGive) {
  // (18f) asks v_ref < 0.076 m/s; (18g) with a corner radius of 0.119 m asks v_ref < 0.0714 m/s.
  Gains gains = core::paper_gains(4);
  const auto a_at = [&](Twist reference) {
    const std::vector<Twist> all(4, reference);
    core::use_all_authority(gains, all);
    return core::margins(gains, 0, reference).a;
  };
  EXPECT_GT(a_at({0.0759, 0.0}), 0.0);
  EXPECT_LT(a_at({0.0761, 0.0}), 0.0);
  EXPECT_GT(a_at({0.0713, 0.0713 / 0.119}), 0.0);
  EXPECT_LT(a_at({0.0715, 0.0715 / 0.119}), 0.0);
}

TEST(Gains, AllAuthorityMeets18fAnd18gWithEquality) {
  holds("use_all_authority leaves no margin", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    Group group = random_group(draw, static_cast<std::size_t>(n));
    core::use_all_authority(group.gains, group.reference);
    for (std::size_t i = 0; i < group.robots(); ++i) {
      const Margins m = core::margins(group.gains, i, group.reference[i]);
      // One rounding for each of the few numbers that add up to the limit.
      RC_ASSERT(std::abs(m.f) <= 4e-16 * group.gains.v_max[i]);
      RC_ASSERT(std::abs(m.g) <= 1e-15 * group.gains.omega_max[i]);
      RC_ASSERT(m.hold());
    }
  });
}

/// (18) once more, from the sums as they are printed.
Margins printed_margins(const Group& group, std::size_t i) {
  const Gains& g = group.gains;
  double xx = 0.0, tt = 0.0, yy = 0.0, smallest = group.robots() == 1 ? 0.0 : 1e300;
  for (std::size_t j = 0; j < group.robots(); ++j) {
    if (j == i) continue;
    xx += g.k_xx(i, j), tt += g.k_tt(i, j), yy += g.k_yy(i, j);
    for (const PairTable* t : {&g.k_xx, &g.c_xx, &g.l_xx, &g.k_tt, &g.c_tt, &g.l_tt, &g.k_yy, &g.c_yy})
      smallest = std::min(smallest, (*t)(i, j));
  }
  Margins m{};
  for (double positive : {g.k_x[i], g.k_theta[i], g.c_x[i], g.c_theta[i], g.k_y, g.k})
    m.a = m.a == 0.0 ? positive : std::min(m.a, positive);
  m.b = smallest;
  m.f = g.v_max[i] - std::abs(group.reference[i].v) - (g.k_x[i] + xx);
  m.g = g.omega_max[i] - std::abs(group.reference[i].omega) -
        (g.k_theta[i] + g.k_y * std::abs(group.reference[i].v) + tt + yy);
  return m;
}

TEST(Margins, AreThoseOf18) {
  holds("margins of random gains, admissible or not", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    Group group = random_group(draw, static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < group.robots(); ++i) {  // some robots ask too much, or have a gain of the wrong sign
      if (draw.chance(0.3)) group.gains.k_x[i] *= draw.between(-1.0, 5.0);
      if (draw.chance(0.3)) group.gains.k_theta[i] *= draw.between(-1.0, 5.0);
      if (draw.chance(0.2)) group.reference[i].v *= 3.0;
    }
    for (std::size_t i = 0; i < group.robots(); ++i) {
      const Margins m = core::margins(group.gains, i, group.reference[i]);
      const Margins printed = printed_margins(group, i);
      RC_ASSERT(m.a == printed.a);
      RC_ASSERT(m.b == printed.b);
      RC_ASSERT(m.c == 0.0 && m.d == 0.0 && m.e == 0.0);
      RC_ASSERT(std::abs(m.f - printed.f) <= 1e-14 * (1.0 + std::abs(printed.f)));
      RC_ASSERT(std::abs(m.g - printed.g) <= 1e-14 * (1.0 + group.gains.omega_max[i] + std::abs(printed.g)));
    }
  });
}

TEST(Margins, TurnNegativeWhereAConditionIsViolated) {
  const Twist reference{0.05, 0.42};
  const auto changed = [&](auto&& change) {
    Gains gains = core::paper_gains(4);
    const std::vector<Twist> all(4, reference);
    core::use_all_authority(gains, all);
    EXPECT_TRUE(core::margins(gains, 1, reference).hold());
    change(gains);
    const Margins m = core::margins(gains, 1, reference);
    EXPECT_FALSE(m.hold());
    return m;
  };
  EXPECT_NEAR(changed([](Gains& g) { g.k_x[1] += 0.001; }).f, -0.001, 1e-15);
  EXPECT_NEAR(changed([](Gains& g) { g.k_theta[1] += 0.01; }).g, -0.01, 1e-14);
  EXPECT_NEAR(changed([](Gains& g) { g.k_xx.set(0, 1, 0.009); }).f, -0.001, 1e-15);
  EXPECT_NEAR(changed([](Gains& g) { g.k_tt.set(1, 3, 0.035); }).g, -0.01, 1e-14);
  EXPECT_NEAR(changed([](Gains& g) { g.k_yy.set(2, 1, 0.09); }).g, -0.01, 1e-14);
  EXPECT_NEAR(changed([](Gains& g) { g.k_y += 0.1; }).g, -0.005, 1e-14);
  EXPECT_NEAR(changed([](Gains& g) { g.v_max[1] -= 0.02; }).f, -0.02, 1e-15);
  EXPECT_NEAR(changed([](Gains& g) { g.omega_max[1] -= 0.2; }).g, -0.2, 1e-14);
  EXPECT_EQ(changed([](Gains& g) { g.k_x[1] = -0.01; }).a, -0.01);
  EXPECT_EQ(changed([](Gains& g) { g.c_theta[1] = 0.0; }).a, 0.0);
  EXPECT_EQ(changed([](Gains& g) { g.k = -1.0; }).a, -1.0);
  EXPECT_EQ(changed([](Gains& g) { g.c_yy.set(1, 2, -0.5); }).b, -0.5);
  EXPECT_EQ(changed([](Gains& g) { g.l_tt.set(0, 1, -3.0); }).b, -3.0);
}

TEST(Margins, OfOneRobotDoNotSeeAnothersViolation) {
  Gains gains = core::paper_gains(4);
  gains.k_x[0] += 1.0;
  gains.k_xx.set(0, 2, -1.0);
  EXPECT_FALSE(core::margins(gains, 0, {}).hold());
  EXPECT_TRUE(core::margins(gains, 1, {}).hold());
  EXPECT_TRUE(core::margins(gains, 3, {}).hold());
}

}  // namespace
}  // namespace skein::test
