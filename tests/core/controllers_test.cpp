// The laws that are built in beside the paper's, in closed loop: what their authors promise, and what they do not.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "core/control/coordination_law.h"
#include "core/controllers/controller_types.h"
#include "core/controllers/independent.h"
#include "core/controllers/leader_follower.h"
#include "core/controllers/virtual_structure.h"
#include "core/kinematics/unicycle.h"
#include "core/words.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::ControllerKind;
using core::Pose;
using core::ReferencePoint;
using core::TrackingError;
using core::Twist;

/// A group under one law, without limits: its references drive with constant twists from where they stand.
struct Loop {
  std::vector<ReferencePoint> reference;
  std::vector<Pose> poses;
  core::Gains gains;
  std::unique_ptr<core::Controller> law;
  std::vector<double> parameters;
  std::vector<std::uint8_t> out;
  std::vector<Twist> command;
  std::vector<TrackingError> errors;
  std::vector<double> log;

  Loop(ControllerKind kind, std::vector<ReferencePoint> references, std::vector<Pose> at)
      : reference(std::move(references)),
        poses(std::move(at)),
        gains(core::paper_gains(poses.size())),
        law(core::controller_type(kind).make(poses.size())),
        out(poses.size()),
        command(poses.size()),
        errors(poses.size()),
        log(poses.size() * core::controller_type(kind).logs.size()) {
    for (const core::ControllerParameter& p : core::controller_type(kind).parameters) parameters.push_back(p.value);
  }
  void decide() {
    std::vector<Twist> twists;
    for (const ReferencePoint& point : reference) twists.push_back(point.twist);
    core::use_all_authority(gains, twists);
    for (std::size_t i = 0; i < poses.size(); ++i)
      errors[i] = out[i] ? TrackingError{} : core::tracking_error(reference[i].pose, poses[i]);
    core::ControllerInput input;
    input.poses = poses;
    input.reference = input.nominal = reference;
    input.reference_twists = twists;
    input.errors = errors;
    input.out = out;
    input.gains = &gains;
    input.parameters = parameters;
    law->step(input, command, log);
  }
  void drive(double dt) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i] = core::advance(poses[i], out[i] ? Twist{} : command[i], dt);
      reference[i].pose = core::advance(reference[i].pose, reference[i].twist, dt);
    }
  }
  void run(double seconds, double dt) {
    for (double t = 0.0; t < seconds; t += dt) decide(), drive(dt);
    decide();
  }
  double farthest() const {
    double far = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) far = std::fmax(far, core::distance(reference[i].pose, poses[i]));
    return far;
  }
};

/// Places on one circle, so that all have the same omega_ref, and speeds to match.
std::vector<ReferencePoint> on_a_circle(std::size_t robots, double radius, double speed) {
  std::vector<ReferencePoint> points;
  for (std::size_t i = 0; i < robots; ++i) {
    const double at = -0.4 * static_cast<double>(i);
    points.push_back(
        {{radius * std::cos(at), radius * std::sin(at), core::wrap_angle(at + core::pi / 2)}, {speed, speed / radius}});
  }
  return points;
}

std::vector<ReferencePoint> in_a_line(std::size_t robots, double speed) {
  std::vector<ReferencePoint> points;
  for (std::size_t i = 0; i < robots; ++i) points.push_back({{-0.15 * static_cast<double>(i), 0.0, 0.0}, {speed, 0.0}});
  return points;
}

std::vector<Pose> put_off(const std::vector<ReferencePoint>& points, double most, double turned, Draw& draw) {
  std::vector<Pose> poses;
  for (const ReferencePoint& point : points) {
    const double away = draw.between(0.0, most), direction = draw.angle();
    poses.push_back({point.pose.x + away * std::cos(direction), point.pose.y + away * std::sin(direction),
                     core::wrap_angle(point.pose.theta + draw.between(-turned, turned))});
  }
  return poses;
}

TEST(Controllers, HaveOneRowAKindWithDefaultsInTheirRanges) {
  for (const ControllerKind kind : core::all_of<ControllerKind>()) {
    const core::ControllerType& type = core::controller_type(kind);
    EXPECT_EQ(type.kind, kind) << core::word(kind);
    EXPECT_FALSE(type.help.empty());
    EXPECT_NE(type.make(3), nullptr);
    for (const core::ControllerParameter& p : type.parameters) {
      EXPECT_TRUE(p.low <= p.value && p.value <= p.high) << p.name;
      EXPECT_FALSE(p.help.empty()) << p.name;
    }
  }
}

TEST(Controllers, KosticIsTheLawOfThePaperBitForBit) {
  Draw draw(11);
  for (int k = 0; k < 200; ++k) {
    const auto points = on_a_circle(4, 0.5, 0.05);
    Loop loop(ControllerKind::kostic, points, put_off(points, 0.4, core::pi, draw));
    loop.decide();
    std::vector<Twist> twists, expected(4);
    for (const ReferencePoint& point : points) twists.push_back(point.twist);
    core::coordination_law(loop.gains, loop.errors, twists, expected);
    EXPECT_EQ(loop.command, expected);
  }
}

TEST(Independent, BringsEveryRobotHomeFromAnywhere) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Draw draw(seed);
    const auto points = seed % 2 ? on_a_circle(3, draw.between(0.3, 0.8), 0.05) : in_a_line(3, 0.05);
    Loop loop(ControllerKind::independent, points, put_off(points, 0.6, core::pi, draw));
    loop.run(80.0, 0.01);
    EXPECT_LT(loop.farthest(), 1e-3) << "seed " << seed;
  }
}

TEST(Independent, IsTheLawOfThePaperForARobotAlone) {
  Draw draw(3);
  for (int k = 0; k < 200; ++k) {
    const auto points = on_a_circle(1, 0.5, 0.05);
    Loop loop(ControllerKind::independent, points, put_off(points, 0.5, core::pi, draw));
    loop.decide();
    std::vector<Twist> expected(1);
    const std::vector<Twist> twists{points[0].twist};
    core::coordination_law(loop.gains, loop.errors, twists, expected);
    EXPECT_NEAR(loop.command[0].v, expected[0].v, 1e-12);
    EXPECT_NEAR(loop.command[0].omega, expected[0].omega, 1e-12);
  }
}

TEST(Independent, NobodyMindsTheOthersAndWithThePapersLawEverybodyDoes) {
  Draw draw(4);
  const auto points = on_a_circle(3, 0.5, 0.05);
  for (int k = 0; k < 50; ++k) {
    std::vector<Pose> poses = put_off(points, 0.2, 1.0, draw);
    Loop alone(ControllerKind::independent, points, poses), coupled(ControllerKind::kostic, points, poses);
    alone.decide(), coupled.decide();
    poses[2].x += 0.1;
    Loop alone_again(ControllerKind::independent, points, poses), coupled_again(ControllerKind::kostic, points, poses);
    alone_again.decide(), coupled_again.decide();
    EXPECT_EQ(alone.command[0], alone_again.command[0]);
    EXPECT_NE(coupled.command[0], coupled_again.command[0]);
  }
}

TEST(VirtualStructure, BringsEverybodyHomeWhereTheReferenceTurns) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Draw draw(seed);
    const auto points = on_a_circle(4, draw.between(0.2, 0.4), 0.08);
    Loop loop(ControllerKind::virtual_structure, points, put_off(points, 0.3, 0.8, draw));
    loop.run(120.0, 0.01);
    EXPECT_LT(loop.farthest(), 2e-3) << "seed " << seed;
  }
}

TEST(VirtualStructure, LeavesErrorsToTheSideAlongAStraightLineAsItsProofNeedsOmega) {
  const auto points = in_a_line(3, 0.05);
  std::vector<Pose> poses;
  for (const ReferencePoint& point : points) poses.push_back(point.pose);
  poses[1].y += 0.1;
  Loop linear(ControllerKind::virtual_structure, points, poses), saturated(ControllerKind::independent, points, poses);
  linear.run(60.0, 0.01);
  saturated.run(60.0, 0.01);
  EXPECT_NEAR(linear.errors[1].y, -0.1, 1e-3);
  EXPECT_NEAR(saturated.errors[1].y, 0.0, 1e-3);
}

TEST(VirtualStructure, CouplesEverybodyInTheGroupAndNobodyWhoIsOut) {
  const auto points = on_a_circle(4, 0.5, 0.05);
  std::vector<Pose> poses;
  for (const ReferencePoint& point : points) poses.push_back(point.pose);
  Loop at_home(ControllerKind::virtual_structure, points, poses);
  at_home.decide();
  poses[3].x += 0.1;
  Loop one_off(ControllerKind::virtual_structure, points, poses),
      one_out(ControllerKind::virtual_structure, points, poses);
  one_out.out[3] = 1;
  one_off.decide(), one_out.decide();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NE(one_off.command[i], at_home.command[i]) << i;
    EXPECT_EQ(one_out.command[i], at_home.command[i]) << i;
  }
  EXPECT_EQ(one_out.command[3], Twist{});
}

/// The formulas of the paper, pair by pair.
TEST(VirtualStructure, IsTheSumOverPairs) {
  Draw draw(8);
  for (int k = 0; k < 100; ++k) {
    const auto points = on_a_circle(5, 0.5, 0.05);
    Loop loop(ControllerKind::virtual_structure, points, put_off(points, 0.4, 1.0, draw));
    for (double& p : loop.parameters) p = draw.between(0.1, 3.0);
    loop.decide();
    const auto& p = loop.parameters;
    for (std::size_t i = 0; i < 5; ++i) {
      const TrackingError& e = loop.errors[i];
      const Twist& r = points[i].twist;
      double v = r.v + p[0] * e.x - p[1] * r.omega * e.y, omega = r.omega + p[2] * e.theta;
      for (std::size_t j = 0; j < 5; ++j) {
        const TrackingError& f = loop.errors[j];
        v += p[3] * (e.x - f.x) - p[4] * r.omega * (e.y - f.y);
        omega += p[5] * (e.theta - f.theta);
      }
      EXPECT_NEAR(loop.command[i].v, v, 1e-12);
      EXPECT_NEAR(loop.command[i].omega, omega, 1e-12);
    }
  }
}

TEST(LeaderFollower, SeparationChangesAsItsRateSays) {
  Draw draw(5);
  for (int k = 0; k < 300; ++k) {
    const Pose leader{draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.angle()};
    const double away = draw.between(0.1, 0.5), where = draw.angle();
    const Pose follower{leader.x + away * std::cos(where), leader.y + away * std::sin(where), draw.angle()};
    const Twist leads{draw.between(-0.1, 0.1), draw.between(-1.0, 1.0)};
    const Twist follows{draw.between(-0.1, 0.1), draw.between(-1.0, 1.0)};
    const double ahead = draw.between(0.01, 0.08), dt = 1e-6;
    const core::Separation before = core::separation(leader, follower, ahead);
    if (before.l < 0.03) continue;
    const core::Separation after =
        core::separation(core::advance(leader, leads, dt), core::advance(follower, follows, dt), ahead);
    const core::Separation rate = core::separation_rate(leader, leads, follower, follows, ahead);
    EXPECT_NEAR((after.l - before.l) / dt, rate.l, 1e-4);
    EXPECT_NEAR(core::wrap_angle(after.phi - before.phi) / dt, rate.phi, 1e-3);
  }
}

TEST(LeaderFollower, DistanceAndBearingComeHomeExponentially) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Draw draw(seed);
    auto points = on_a_circle(2, draw.between(0.4, 0.8), 0.05);
    std::vector<Pose> poses{points[0].pose, points[1].pose};
    poses[1].x += draw.between(-0.05, 0.05), poses[1].y += draw.between(-0.05, 0.05);
    poses[1].theta = draw.angle();
    Loop loop(ControllerKind::leader_follower, points, poses);
    loop.decide();
    const double d = loop.parameters[core::LeaderFollowerController::ahead];
    const auto off = [&] {
      const core::Separation is = core::separation(loop.poses[0], loop.poses[1], d);
      const core::Separation wanted = core::separation(loop.reference[0].pose, loop.reference[1].pose, d);
      return core::Separation{is.l - wanted.l, core::wrap_angle(is.phi - wanted.phi)};
    };
    const core::Separation before = off();
    constexpr double seconds = 2.0, dt = 0.0005;
    for (int k = 0; k < static_cast<int>(seconds / dt); ++k) loop.decide(), loop.drive(dt);
    const core::Separation after = off();
    const double left = std::exp(-0.8 * seconds);
    EXPECT_NEAR(after.l, left * before.l, 2e-4) << "seed " << seed;
    EXPECT_NEAR(after.phi, left * before.phi, 5e-3) << "seed " << seed;
    loop.run(60.0, 0.005);
    EXPECT_LT(loop.farthest(), 2e-3) << "seed " << seed;
    EXPECT_NEAR(loop.log[2], core::separation(loop.poses[0], loop.poses[1], d).l, 1e-12);
    EXPECT_TRUE(std::isnan(loop.log[0]));
  }
}

TEST(LeaderFollower, FollowsTheNextOneBeforeItThatIsThere) {
  const auto points = in_a_line(4, 0.05);
  std::vector<Pose> poses;
  for (const ReferencePoint& point : points) poses.push_back(point.pose);
  Loop all(ControllerKind::leader_follower, points, poses), without(ControllerKind::leader_follower, points, poses);
  without.out[1] = 1;
  without.poses[1] = {std::nan(""), std::nan(""), std::nan("")};
  all.run(5.0, 0.01), without.run(5.0, 0.01);
  for (const std::size_t i : {0u, 2u, 3u}) {
    EXPECT_NEAR(core::distance(all.poses[i], points[i].pose), 0.25, 2e-3);
    EXPECT_NEAR(core::distance(without.poses[i], points[i].pose), 0.25, 2e-3);
  }
  Loop leaderless(ControllerKind::leader_follower, points, poses);
  leaderless.out[0] = 1;
  leaderless.run(5.0, 0.01);
  EXPECT_NEAR(core::distance(leaderless.poses[1], points[1].pose), 0.25, 2e-3);
}

}  // namespace
}  // namespace skein::test
