// (14): which form of the coupling keeps the commands inside the limits, and by how much the printed one does not.
#include <algorithm>

#include "core/control/coordination_law.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Coupling;
using core::Twist;

/// The largest |v| / v_max and |omega| / omega_max over the group's commands.
Twist largest_share(const Group& group) {
  std::vector<Twist> command(group.robots());
  core::coordination_law(group.gains, group.errors, group.reference, command);
  Twist largest;
  for (std::size_t i = 0; i < group.robots(); ++i) {
    largest.v = std::max(largest.v, std::abs(command[i].v) / group.gains.v_max[i]);
    largest.omega = std::max(largest.omega, std::abs(command[i].omega) / group.gains.omega_max[i]);
  }
  return largest;
}

constexpr double rounding = 1.0 + 1e-12;  // (18f, g) with equality leave nothing for the last digit

TEST(BoundedCoupling, ObeysTheLimits14) {
  holds("(18f, g) imply (14)", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    const Twist share = largest_share(random_group(draw, static_cast<std::size_t>(n), Coupling::bounded));
    RC_ASSERT(share.v <= rounding);
    RC_ASSERT(share.omega <= rounding);
  });
}

TEST(BoundedCoupling, ObeysTheLimits14WhereThePrintedOneIsWorst) {
  holds("(14) with one error near zero and the others big", [] {
    const int n = any_of(2, 12);
    Draw draw(any_seed());
    Group group = random_group(draw, static_cast<std::size_t>(n), Coupling::bounded);
    for (auto& e : group.errors)
      e = {draw.sign() * draw.decades(-1.0, 3.0), draw.sign() * draw.decades(-1.0, 3.0), draw.angle()};
    group.errors[0].x = draw.chance(0.5) ? 0.0 : draw.sign() * draw.decades(-12.0, -1.0);
    group.errors[0].theta = draw.chance(0.5) ? 0.0 : draw.sign() * draw.decades(-12.0, -1.0);
    const Twist share = largest_share(group);
    RC_ASSERT(share.v <= rounding);
    RC_ASSERT(share.omega <= rounding);
  });
}

TEST(PaperCoupling, OneMetreOfOneRobotShiftsAnotherPastItsLimit) {
  // The notes' witness: with x_e,i = 0 the term of (15a) is l x_e,j k tanh(c x_e,j), here 100 * 0.008 * tanh(1.5), and
  // nothing bounds it; yet (18) holds.
  Group group{core::paper_gains(2), {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, {{0.0, 0.0}, {0.0, 0.0}}};
  group.gains.c_x = {1e-9, 1e-9};  // tracking (nearly) off: the shift alone
  for (std::size_t i : {0u, 1u}) ASSERT_TRUE(core::margins(group.gains, i, group.reference[i]).hold());
  std::vector<Twist> command(2);
  core::coordination_law(group.gains, group.errors, group.reference, command);
  EXPECT_NEAR(command[0].v, -100.0 * 0.008 * std::tanh(1.5), 1e-9);
  EXPECT_NEAR(std::abs(command[0].v), 0.72, 0.005);
  EXPECT_GT(std::abs(command[0].v), 7.0 * group.gains.v_max[0]);

  group.gains.coupling = Coupling::bounded;
  core::coordination_law(group.gains, group.errors, group.reference, command);
  EXPECT_LE(std::abs(command[0].v), 0.008);
}

TEST(PaperCoupling, BreaksTheLimits14InManyRandomStates) {
  // Errors of half a metre under the gains of (36). The bounded form over the same states never leaves the limits.
  Draw draw(20101208);
  int broken = 0;
  double fastest = 0.0, fastest_bounded = 0.0, fastest_turn_bounded = 0.0;
  for (int k = 0; k < 20000; ++k) {
    Group group{core::paper_gains(4), {}, {}};
    for (int i = 0; i < 4; ++i) {
      group.errors.push_back({draw.between(-0.5, 0.5), draw.between(-0.5, 0.5), draw.angle()});
      group.reference.push_back({0.05, draw.chance(0.5) ? 0.0 : 0.05 / 0.119});
    }
    core::use_all_authority(group.gains, group.reference);
    const Twist paper = largest_share(group);
    broken += paper.v > rounding || paper.omega > rounding;
    fastest = std::max(fastest, paper.v * 0.1);
    group.gains.coupling = Coupling::bounded;
    const Twist bounded = largest_share(group);
    fastest_bounded = std::max(fastest_bounded, bounded.v);
    fastest_turn_bounded = std::max(fastest_turn_bounded, bounded.omega);
  }
  EXPECT_GT(broken, 0);
  EXPECT_GT(fastest, 0.2) << "m/s, with a limit of 0.1";
  EXPECT_LE(fastest_bounded, rounding);
  EXPECT_LE(fastest_turn_bounded, rounding);
  RecordProperty("broken_of_20000", broken);
}

}  // namespace
}  // namespace skein::test
