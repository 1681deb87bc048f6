// Collision avoidance by changed references (29)-(34): when it acts, what it may ask for, and how it comes back.
#include "core/avoidance/avoidance.h"

#include <algorithm>

#include "core/control/coordination_law.h"
#include "core/kinematics/unicycle.h"
#include "core/reference/platoon.h"
#include "draw.h"
#include "encounter.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Avoidance;
using core::AvoidanceParameters;
using core::Pose;
using core::ReferencePoint;
using core::Twist;
using State = core::Avoidance::State;

TEST(Avoidance, IsTheNominalReferenceBitForBitWhileNobodyIsNear) {
  holds("nominal in, nominal out", [] {
    const int n = any_of(1, 8);
    Draw draw(any_seed());
    Encounter e(static_cast<std::size_t>(n));
    for (int k = 0; k < 20; ++k) {
      for (std::size_t i = 0; i < e.n; ++i) {
        // A place of its own for each, 0.3 m from the next; the references anywhere.
        e.poses[i] = {0.5 * static_cast<double>(i) + draw.between(-0.1, 0.1), draw.between(-0.1, 0.1), draw.angle()};
        e.nominal[i] = {draw.pose(2.0), {draw.between(0.0, 0.07), draw.between(-0.5, 0.5)}};
      }
      e.step();
      RC_ASSERT(e.reference == e.nominal);
      for (std::size_t i = 0; i < e.n; ++i) RC_ASSERT(e.avoidance.state(i) == State::nominal);
    }
  });
}

TEST(Avoidance, DoesNothingWhenItIsOff) {
  Encounter e(2);
  e.parameters.enabled = false;
  e.poses = {{0.0, 0.0, 0.0}, {0.05, 0.0, 0.0}};
  for (int k = 0; k < 10; ++k) {
    e.step();
    EXPECT_EQ(e.reference, e.nominal);
  }
}

TEST(Avoidance, KeepsTheGainsPositiveAlongRandomEncounters) {
  holds("(18a) and (18f, g) hold for the gains of (36) with the modified references", [] {
    const int n = any_of(2, 7);  // with eight, the couplings of (36) leave less than the nominal reference itself asks
    Draw draw(any_seed());
    Encounter e(static_cast<std::size_t>(n));
    e.parameters.p = draw.whole(1, 4) * 2;
    e.parameters.K_o = draw.decades(-3.0, 0.0);
    e.parameters.K_a = draw.decades(-2.0, 0.5);
    e.obstacles = {{draw.between(-0.2, 0.2), draw.between(-0.2, 0.2), draw.between(0.01, 0.08)}};
    const double v_ref = draw.between(0.0, 0.05), omega_ref = draw.between(-0.3, 0.3);
    for (std::size_t i = 0; i < e.n; ++i) {
      e.poses[i] = draw.pose(0.2);
      e.nominal[i] = {draw.pose(0.2), {v_ref, omega_ref}};
    }
    for (int k = 0; k < 60; ++k) {
      for (std::size_t i = 0; i < e.n; ++i) {
        // A hand moves one of them now and then; else they drive about.
        const Twist drive{draw.between(-0.1, 0.1), draw.between(-1.7, 1.7)};
        e.poses[i] = draw.chance(0.02) ? draw.pose(0.2) : core::advance(e.poses[i], drive, e.dt);
        e.nominal[i].pose = core::advance(e.nominal[i].pose, e.nominal[i].twist, e.dt);
      }
      e.step();
      core::use_all_authority(e.gains, e.twists());
      for (std::size_t i = 0; i < e.n; ++i) {
        const core::Margins m = core::margins(e.gains, i, e.reference[i].twist);
        RC_ASSERT(m.hold());
        if (e.avoidance.state(i) == State::nominal) continue;
        // Not merely positive: the share that always stays with tracking.
        RC_ASSERT(e.gains.k_x[i] >= core::tracking_share * e.gains.v_max[i] - 1e-12);
        RC_ASSERT(e.gains.k_theta[i] >= core::tracking_share * e.gains.omega_max[i] - 1e-12);
        RC_ASSERT(e.reference[i].twist.v >= 0.0);
      }
    }
  });
}

TEST(Avoidance, TurnsTheReferenceAtABoundedRate) {
  // (34e) as printed turns it within one tick: 78 rad/s. Here its heading moves by omega_ref dt, whatever happens.
  holds("heading and speed of an avoiding reference are those it reports", [] {
    Draw draw(any_seed());
    Encounter e(2);
    e.poses = {draw.pose(0.03), draw.pose(0.03)};
    e.nominal = {{draw.pose(0.5), {0.05, 0.0}}, {draw.pose(0.5), {0.05, 0.0}}};
    e.step();
    for (int k = 0; k < 30; ++k) {
      const auto before = e.reference;
      const auto poses_before = e.poses;
      for (Pose& pose : e.poses) pose = core::advance(pose, {draw.between(-0.1, 0.1), draw.between(-1.7, 1.7)}, e.dt);
      std::vector<State> was{e.avoidance.state(0), e.avoidance.state(1)};
      e.step();
      for (std::size_t i = 0; i < 2; ++i) {
        if (was[i] != State::avoiding || e.avoidance.state(i) != State::avoiding) continue;
        const Twist& twist = e.reference[i].twist;
        RC_ASSERT(std::abs(twist.omega) <= core::reference_bounds(e.gains, i).omega_limit());
        const double turned = core::wrap_angle(e.reference[i].pose.theta - before[i].pose.theta);
        RC_ASSERT(std::abs(turned - twist.omega * e.dt) <= 1e-12);
        // (34a, b): from the robot's last pose, dt v_ref along the reference's heading.
        const double dx = e.reference[i].pose.x - poses_before[i].x, dy = e.reference[i].pose.y - poses_before[i].y;
        RC_ASSERT(std::abs(dx - e.dt * twist.v * std::cos(e.reference[i].pose.theta)) <= 1e-15);
        RC_ASSERT(std::abs(dy - e.dt * twist.v * std::sin(e.reference[i].pose.theta)) <= 1e-15);
      }
    }
  });
}

TEST(Avoidance, LeadsAwayFromTheOther) {
  // Side by side, both looking ahead: after a second of turning, each reference moves away from the other robot.
  Encounter e(2);
  e.poses = {{0.0, 0.0, 0.5 * core::pi}, {0.07, 0.0, 0.5 * core::pi}};
  e.nominal = {{{0.0, 0.0, 0.5 * core::pi}, {0.0, 0.0}}, {{0.07, 0.0, 0.5 * core::pi}, {0.0, 0.0}}};
  for (int k = 0; k < 100; ++k) e.step();
  EXPECT_LT(e.reference[0].pose.x, 0.0);
  EXPECT_GT(e.reference[1].pose.x, 0.07);
  EXPECT_GT(std::abs(core::wrap_angle(e.reference[0].pose.theta)), 3.0);  // to the left
  EXPECT_NEAR(e.reference[1].pose.theta, 0.0, 0.1);                       // to the right
}

TEST(Avoidance, StaysUntilTheRegionIsLeftByATenth) {
  Encounter e(2);
  const auto state_at = [&](double d) {
    e.poses = {{0.0, 0.0, 0.0}, {d, 0.0, 0.0}};
    e.step();
    return e.avoidance.state(0);
  };
  EXPECT_EQ(state_at(0.101), State::nominal);
  EXPECT_EQ(state_at(0.099), State::avoiding);
  EXPECT_EQ(state_at(0.109), State::avoiding);
  EXPECT_EQ(state_at(0.111), State::returning);
  EXPECT_EQ(state_at(0.101), State::returning) << "a region left is entered at its own size again";
  EXPECT_EQ(state_at(0.099), State::avoiding);
}

TEST(Avoidance, ReturnsWithoutAJump) {
  // Two robots meet, part, and their references drive home to a platoon on the lap, one dt v at a time.
  holds("returning references are continuous and arrive", [] {
    Draw draw(any_seed());
    const core::Platoon platoon(std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119), 2, 0.4, 0.05,
                                draw.between(0.0, 4.0));
    Encounter e(2);
    double t = 0.0;
    platoon.at(t, e.nominal);
    e.poses[0] = e.nominal[0].pose;
    const double direction = draw.angle(), gap = draw.between(0.05, 0.095);
    e.poses[1] = {e.poses[0].x + gap * std::cos(direction), e.poses[0].y + gap * std::sin(direction), draw.angle()};
    const auto next = [&] { t += e.dt, platoon.at(t, e.nominal), e.step(); };
    const int together = draw.whole(1, 50);
    for (int k = 0; k < together; ++k) next();
    RC_ASSERT(e.avoidance.state(0) == State::avoiding);
    e.poses[1].x += 5.0;  // gone
    int k = 0;
    for (; k < 3000 && e.avoidance.state(0) != State::nominal; ++k) {  // two minutes at most
      const ReferencePoint before = e.reference[0];
      next();
      const ReferencePoint& now = e.reference[0];
      const bool home = e.avoidance.state(0) == State::nominal;  // the last step closes what is left: 1 mm, 0.02 rad
      const double v = std::max(before.twist.v, now.twist.v);
      RC_ASSERT(core::distance(before.pose, now.pose) <= v * e.dt + 1e-12 + (home ? 1e-3 : 0.0));
      const double omega = std::max(std::abs(before.twist.omega), std::abs(now.twist.omega));
      RC_ASSERT(std::abs(core::wrap_angle(now.pose.theta - before.pose.theta)) <=
                omega * e.dt + 1e-12 + (home ? 0.02 : 0.0));
      // And it is where its own velocities lead: a reference that a unicycle can follow.
      if (!home) RC_ASSERT(core::distance(core::advance(before.pose, before.twist, e.dt), now.pose) <= 1e-15);
    }
    RC_LOG() << k << " ticks to return\n";
    RC_ASSERT(e.avoidance.state(0) == State::nominal);
    RC_ASSERT(e.reference[0] == e.nominal[0]);
  });
}

TEST(Avoidance, LeavesThePlatoonAloneForAWholeLap) {
  // At nominal spacing, corners included (0.115 m), nobody is in anybody's region.
  const core::Platoon platoon(std::make_shared<core::RoundedRectangle>(1.3, 0.9, 0.119), 4, 0.12, 0.05, 1.6);
  Encounter e(4);
  for (int k = 0; k < 2100; ++k) {
    platoon.at(k * e.dt, e.nominal);
    for (std::size_t i = 0; i < 4; ++i) e.poses[i] = e.nominal[i].pose;
    e.step();
    ASSERT_EQ(e.reference, e.nominal) << "tick " << k;
  }
}

TEST(Avoidance, DoesNotAvoidARobotWhosePoseIsNotKnown) {
  const double nan = std::nan("");
  Encounter e(3);
  e.nominal = {{{0.0, 0.0, 0.0}, {0.05, 0.0}}, {{0.05, 0.0, 0.0}, {0.05, 0.0}}, {{1.0, 0.0, 0.0}, {0.05, 0.0}}};
  e.poses = {{0.0, 0.0, 0.0}, {nan, nan, nan}, {1.0, 0.0, 0.0}};
  e.step();
  EXPECT_EQ(e.reference, e.nominal);
  // It is found again next to robot 1: its own reference starts from where it is now.
  e.poses[1] = {0.05, 0.0, 0.0};
  e.step();
  for (std::size_t i : {0u, 1u}) {
    EXPECT_EQ(e.avoidance.state(i), State::avoiding);
    EXPECT_LT(core::distance(e.reference[i].pose, e.poses[i]), 0.1 * e.dt);
  }
  // And lost again while avoiding: the references stay numbers.
  e.poses[1] = {nan, nan, nan};
  for (int k = 0; k < 50; ++k) {
    e.step();
    for (const ReferencePoint& point : e.reference)
      EXPECT_TRUE(std::isfinite(point.pose.x + point.pose.y + point.pose.theta + point.twist.v + point.twist.omega));
  }
}

TEST(Avoidance, ForgetsOnReset) {
  Encounter e(2);
  e.poses = {{0.0, 0.0, 0.0}, {0.05, 0.0, 0.0}};
  e.step();
  ASSERT_EQ(e.avoidance.state(0), State::avoiding);
  e.avoidance.reset(0);
  EXPECT_EQ(e.avoidance.state(0), State::nominal);
  e.poses[1].x = 1.0;
  e.step();
  EXPECT_EQ(e.reference[0], e.nominal[0]);
}

}  // namespace
}  // namespace skein::test
