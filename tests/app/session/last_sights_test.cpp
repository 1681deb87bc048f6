#include "app/session/last_sights.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skein::app {
namespace {

core::Measurement at(double t, core::Pose pose) {
  core::Measurement m;
  m.pose = pose;
  m.captured_at = t;
  return m;
}

TEST(LastSights, CarryARobotToTheTimeOfAnotherCamerasFrame) {
  LastSights sights(2, 3);
  EXPECT_FALSE(sights.elsewhere(1, 2, 0.0));
  sights.saw(0, 2, at(1.00, {0.100, 0.200, 3.1}));
  ASSERT_TRUE(sights.elsewhere(1, 2, 1.02));
  EXPECT_EQ(*sights.elsewhere(1, 2, 1.02), (core::Pose{0.100, 0.200, 3.1})) << "one sight tells no velocity";
  sights.saw(0, 2, at(1.04, {0.104, 0.198, 3.14}));
  const core::Pose later = sights.elsewhere(1, 2, 1.06).value();
  EXPECT_NEAR(later.x, 0.106, 1e-12);
  EXPECT_NEAR(later.y, 0.197, 1e-12);
  EXPECT_NEAR(later.theta, 3.16 - 2.0 * core::pi, 1e-12) << "round the angle's end";
  EXPECT_NEAR(sights.elsewhere(1, 2, 1.02)->x, 0.102, 1e-12) << "and back";
  EXPECT_EQ(sights.newest(2), 1.04);
}

TEST(LastSights, AreNoneOfTheCamerasOwnNorOfOtherRobotsNorOld) {
  LastSights sights(2, 3);
  sights.saw(1, 2, at(1.0, {0.1, 0.2, 0.3}));
  EXPECT_FALSE(sights.elsewhere(1, 2, 1.0)) << "it is its own";
  EXPECT_FALSE(sights.elsewhere(0, 1, 1.0)) << "of another robot";
  EXPECT_TRUE(sights.elsewhere(0, 2, 1.0 + 0.99 * LastSights::carried_for));
  EXPECT_FALSE(sights.elsewhere(0, 2, 1.0 + 1.01 * LastSights::carried_for));
  sights.saw(1, 2, at(0.9, {0.5, 0.5, 0.5}));
  EXPECT_EQ(sights.elsewhere(0, 2, 1.0)->x, 0.1) << "a sight that is late counts for nothing";
}

TEST(LastSights, OfSeveralCamerasTheNewestCounts) {
  LastSights sights(3, 1);
  sights.saw(0, 0, at(1.00, {0.1, 0.0, 0.0}));
  sights.saw(1, 0, at(1.02, {0.2, 0.0, 0.0}));
  EXPECT_EQ(sights.elsewhere(2, 0, 1.03)->x, 0.2);
  EXPECT_EQ(sights.elsewhere(1, 0, 1.03)->x, 0.1);
  EXPECT_EQ(sights.newest(0), 1.02);
}

}  // namespace
}  // namespace skein::app
