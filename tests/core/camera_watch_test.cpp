// A bumped camera is told from carried robots, and from everything else that happens to tags.
#include "core/estimation/camera_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/kinematics/unicycle.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::CameraWatch;
using core::CommonMotion;
using core::Measurement;
using core::Pose;
using core::PoseFilter;
using core::Twist;

constexpr double period = 0.04, v_max = 0.13;

/// How a camera that hangs elsewhere misplaces a robot.
using Camera = std::function<Pose(const Pose&)>;
Pose as_it_is(const Pose& pose) {
  return pose;
}
/// It was turned about a point of the floor, and shifted.
Camera shifted(double dx, double dy, double turn, double about_x = 0.0, double about_y = 0.0) {
  return [=](const Pose& p) {
    const double x = p.x - about_x, y = p.y - about_y, c = std::cos(turn), s = std::sin(turn);
    return Pose{about_x + c * x - s * y + dx, about_y + s * x + c * y + dy, core::wrap_angle(p.theta + turn)};
  };
}

/// Robots with what the camera and the filters make of them. They drive as told but for slip.
struct WatchedScene {
  explicit WatchedScene(std::size_t robots, std::uint64_t seed = 1)
      : draw(seed),
        truth(robots),
        told(robots),
        driven(robots),
        filters(robots),
        before(robots),
        seen_until(robots, 1e9),
        hidden_until(robots, -1.0),
        watch(robots) {}

  std::optional<CommonMotion> tick(const Camera& camera = as_it_is, std::size_t least = 2) {
    now += period;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double slipped = 1.0 + 0.03 * draw.between(-1.0, 1.0);
      truth[i] = core::advance(truth[i], {slipped * driven[i].v, driven[i].omega}, period);
      if (now < hidden_until[i] || now > seen_until[i] || draw.chance(dropout)) continue;
      Pose pose = camera(truth[i]);
      const auto noise = [&](double sigma) { return sigma * (draw.between(-1, 1) + draw.between(-1, 1)) * 1.2; };
      pose = {pose.x + noise(sigma_xy), pose.y + noise(sigma_xy), core::wrap_angle(pose.theta + noise(sigma_theta))};
      const Measurement m{pose, now, claimed * sigma_xy, claimed * sigma_theta, core::How::tracked};
      watch.see(i, filters[i], {}, before[i], m);
      before[i] = m;
      filters[i].see({}, m);
    }
    const auto motion = watch.moved(least);
    for (std::size_t i = 0; i < truth.size(); ++i) filters[i].command(now, told[i]);
    driven = told;
    return motion;
  }
  /// True: it was said that the camera moved.
  bool ticks(int count, const Camera& camera = as_it_is) {
    bool moved = false;
    for (int k = 0; k < count; ++k) moved = tick(camera).has_value() || moved;
    return moved;
  }

  Draw draw;
  std::vector<Pose> truth;
  std::vector<Twist> told, driven;  // what the filters believe, and what the wheels do
  std::vector<PoseFilter> filters;
  std::vector<Measurement> before;  // the newest of each
  std::vector<double> seen_until, hidden_until;
  double now = 0.0, dropout = 0.0, sigma_xy = 0.0001, sigma_theta = 0.001, claimed = 1.0;
  CameraWatch watch;
};

/// Four robots in a square that drive ahead side by side.
WatchedScene square(double v = 0.0) {
  WatchedScene scene(4);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t column = i % 2, row = i / 2;
    scene.truth[i] = {0.3 * static_cast<double>(column), 0.3 * static_cast<double>(row), 0.4};
    scene.told[i] = scene.driven[i] = {v, 0.0};
  }
  return scene;
}

TEST(CameraWatch, KnowsABumpFromTheSecondFrameOn) {
  for (const double v : {0.0, v_max}) {
    WatchedScene scene = square(v);
    const Camera bumped = shifted(0.03, -0.02, 0.01);
    ASSERT_FALSE(scene.ticks(50));
    ASSERT_FALSE(scene.tick(bumped)) << "one frame may be torn";
    const auto motion = scene.tick(bumped);
    ASSERT_TRUE(motion) << v;
    EXPECT_EQ(motion->tags, 4U);
    EXPECT_NEAR(motion->distance, std::hypot(0.03, 0.02), 0.008);
    EXPECT_NEAR(motion->turn, 0.01, 0.003);
    EXPECT_FALSE(scene.ticks(50, bumped)) << "it is said once";
  }
}

TEST(CameraWatch, KnowsATurnAboutOneOfTheTags) {
  WatchedScene scene = square();
  ASSERT_FALSE(scene.ticks(10));
  EXPECT_TRUE(scene.ticks(2, shifted(0.0, 0.0, 2.0 * core::pi / 180.0, 0.0, 0.0)));
}

TEST(CameraWatch, WaitsForTagsThatABumpHasHidden) {
  WatchedScene scene = square(0.05);
  ASSERT_FALSE(scene.ticks(10));
  for (std::size_t i = 0; i < 4; ++i) {
    scene.hidden_until[i] = scene.now + 0.3 * static_cast<double>(i + 1);
    scene.told[i] = {};  // who is lost stands
  }
  const Camera bumped = shifted(0.03, 0.02, 0.0);
  EXPECT_FALSE(scene.ticks(10, bumped)) << "one tag alone says nothing";
  EXPECT_TRUE(scene.ticks(10, bumped)) << "two do";
}

TEST(CameraWatch, AFrameThatIsTornOnceIsNone) {
  WatchedScene scene = square(0.05);
  ASSERT_FALSE(scene.ticks(10));
  EXPECT_FALSE(scene.tick(shifted(0.05, 0.0, 0.0)));
  EXPECT_FALSE(scene.ticks(50));
}

TEST(CameraWatch, OfOneTagAloneNobodyKnows) {
  WatchedScene scene(1);
  ASSERT_FALSE(scene.ticks(10));
  EXPECT_FALSE(scene.ticks(50, shifted(0.1, 0.0, 0.0)));
}

TEST(CameraWatch, TwoRobotsCarriedOneAfterTheOtherAreNone) {
  WatchedScene scene(2);
  scene.truth[1].x = 0.5;
  ASSERT_FALSE(scene.ticks(10));
  for (Pose& pose : scene.truth) {
    pose.y += 0.1;
    EXPECT_FALSE(scene.ticks(5));
  }
}

TEST(CameraWatch, WithThreeAskedForTwoHandsAreNone) {
  WatchedScene scene = square();
  for (std::size_t i = 2; i < 4; ++i) scene.seen_until[i] = 0.1;
  for (int k = 0; k < 10; ++k) ASSERT_FALSE(scene.tick(as_it_is, 3));
  for (int k = 0; k < 60; ++k) ASSERT_FALSE(scene.tick(shifted(0.1, 0.0, 0.0), 3));
}

TEST(CameraWatch, ARobotThatAHandIsKnownToBeAtIsNoWitness) {
  WatchedScene scene(2);
  scene.truth[1].x = 0.5;
  ASSERT_FALSE(scene.ticks(10));
  for (std::size_t i = 0; i < 2; ++i) {
    scene.truth[i].y += 0.1;
    scene.watch.excuse(i, scene.now + 1.0);
  }
  EXPECT_FALSE(scene.ticks(50));
}

TEST(CameraWatch, NothingThatHappensToRobotsIsABumpAndABumpIsKnownAllTheSame) {
  holds("no false alarm, and then a true one", [] {
    Draw draw(any_seed());
    WatchedScene scene(static_cast<std::size_t>(draw.whole(2, 8)), static_cast<std::uint64_t>(draw.whole(1, 1 << 30)));
    const std::size_t robots = scene.truth.size();
    // In formation at v_max, or each as it likes.
    const bool as_one = draw.chance(0.5);
    const double heading = draw.angle();
    for (std::size_t i = 0; i < robots; ++i) {
      scene.truth[i] = draw.pose(1.0);
      if (as_one) scene.truth[i].theta = heading;
      scene.told[i] = as_one ? Twist{v_max, 0.0} : Twist{draw.between(0.0, v_max), draw.between(-2.0, 2.0)};
    }
    const std::vector<Twist> all_told = scene.told;
    scene.driven = scene.told;
    scene.sigma_xy = draw.decades(-5.0, -3.6);
    scene.sigma_theta = scene.sigma_xy / 0.04;
    scene.claimed = draw.between(0.25, 1.0);  // flicker and shadow: sigmas four times too small
    scene.dropout = draw.chance(0.5) ? draw.between(0.0, 0.3) : 0.0;
    double no_kick_before = 0.0;
    int stuck = 0;
    for (int k = 0; k < 250; ++k) {
      const auto one = static_cast<std::size_t>(draw.whole(0, static_cast<int>(robots) - 1));
      if (draw.chance(0.05) && scene.now > no_kick_before) scene.hidden_until[one] = scene.now + draw.between(0.0, 1.0);
      // A kick or a hand: one robot is elsewhere from one frame to the next.
      const bool other_hidden = std::any_of(scene.hidden_until.begin(), scene.hidden_until.end(), [&](const double& t) {
        return &t != &scene.hidden_until[one] && t > scene.now;
      });
      if (draw.chance(0.1) && scene.now > no_kick_before && !other_hidden) {
        scene.truth[one].x += draw.between(-0.2, 0.2), scene.truth[one].y += draw.between(-0.2, 0.2);
        if (draw.chance(0.5)) scene.truth[one].theta = draw.angle();
        no_kick_before = std::max(scene.now, scene.hidden_until[one]) + 0.2;
      }
      // A pause for everybody; wheels that all obey late, or not at all for a while.
      if (draw.chance(0.02))
        for (Twist& twist : scene.told) twist = {};
      if (draw.chance(0.05)) scene.told = all_told;
      if (stuck == 0 && draw.chance(0.02)) stuck = draw.whole(1, 20);
      if (stuck > 0 && --stuck > 0)
        for (Twist& twist : scene.driven) twist = {};
      RC_ASSERT(!scene.tick());
    }
    // Everybody is seen again, and the camera is bumped by a degree or more.
    scene.dropout = 0.0;
    scene.hidden_until.assign(robots, -1.0);
    RC_ASSERT(!scene.ticks(60));
    const double by = draw.between(0.04, 0.1), where = draw.angle();
    RC_ASSERT(scene.ticks(3, shifted(by * std::cos(where), by * std::sin(where), draw.between(-0.005, 0.005),
                                     scene.truth[0].x, scene.truth[0].y)));
  });
}

}  // namespace
}  // namespace skein::test
