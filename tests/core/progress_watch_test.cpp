#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/safety/progress_watch.h"

namespace skein::core {
namespace {

constexpr double dt = 0.04;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

TEST(ProgressWatch, ARobotWhosePlaceDrivesAwayIsStuckUnlessItGetsOnAlongItsRoute) {
  for (const bool on_route : {false, true}) {
    ProgressWatch watch(1);
    int said = 0;
    for (int k = 0; k < 250; ++k)
      said += watch.stuck(0, {0.1 + 0.003 * k, none, on_route ? 20.0 - dt * k : none, {0.002 * k, 0.0, 0.0}}, dt);
    EXPECT_EQ(said, on_route ? 0 : 1);
  }
}

TEST(ProgressWatch, ARobotBehindAPlaceThatDrivesOnIsStuckUnlessItComesNearerToThePlacesEnd) {
  for (const bool drives : {false, true}) {
    ProgressWatch watch(1);
    int said = 0;
    for (int k = 0; k < 250; ++k) said += watch.stuck(0, {0.1 + 0.001 * k, drives ? 2.0 - 0.003 * k : 2.0, none}, dt);
    EXPECT_EQ(said, drives ? 0 : 1);
  }
}

TEST(ProgressWatch, ARouteThatStandsIsStuck) {
  ProgressWatch watch(1);
  int said = 0;
  for (int k = 0; k < 250; ++k)
    said += watch.stuck(0, {0.1, 0.1, k < 100 ? 20.0 - dt * k : 16.0, {0.0, 0.0, 0.02 * std::min(k, 100)}}, dt);
  EXPECT_EQ(said, 1);
}

TEST(ProgressWatch, ARobotThatStandsWhileItsRoutesBeginAnewIsStuck) {
  for (const bool moves : {false, true}) {
    ProgressWatch watch(1);
    int said = 0;
    for (int k = 0; k < 500; ++k)
      said += watch.stuck(0, {0.1 + 0.002 * k, none, 6.0 - dt * (k % 15), {moves ? 0.001 * k : 0.0, 0.0, 0.0}}, dt);
    EXPECT_EQ(said, moves ? 0 : 1);
  }
}

/// What it had moved before counted as progress as soon as the time of a new route ran, also seconds later.
TEST(ProgressWatch, MotionBeforeARouteIsNoProgressAlongIt) {
  constexpr int stands_from = 50, new_route_at = 70;
  ProgressWatch watch(1);
  int said_at = 0;
  for (int k = 0; k < 250 && said_at == 0; ++k) {
    const double left = k < stands_from    ? 20.0 - 0.25 * dt * k
                        : k < new_route_at ? none
                                           : 19.0 - dt * (k - new_route_at);
    const Pose at{0.001 * std::min(k, stands_from), 0.0, 0.0};
    if (watch.stuck(0, {0.1 + 0.002 * k, none, left, at}, dt)) said_at = k;
  }
  EXPECT_GT(said_at, stands_from);
  EXPECT_LE((said_at - stands_from) * dt, ProgressWatch::patience);
}

TEST(ProgressWatch, ARobotThatItsRouteHasWaitIsNotStuckUnlessItStandsBesideTheRoute) {
  for (const double from_wait : {0.0, 0.015, 0.1, none}) {
    ProgressWatch watch(1);
    int said = 0;
    for (int k = 0; k < 250; ++k) said += watch.stuck(0, {0.1 + 0.002 * k, none, 20.0 - dt * k, {}, from_wait}, dt);
    EXPECT_EQ(said, from_wait < ProgressWatch::at_its_place ? 0 : 1) << from_wait;
  }
}

/// A centimetre that is driven at once and completed by a creep seconds later restarted the time.
TEST(ProgressWatch, ACreepDoesNotCompleteWhatWasDrivenLongBefore) {
  for (const bool on_route : {false, true}) {
    constexpr int stands_from = 51, creeps_at = 120;
    ProgressWatch watch(1);
    int said_at = 0;
    for (int k = 0; k < 250 && said_at == 0; ++k) {
      const double driven = 0.0099 * std::min(k, stands_from) + (k < creeps_at ? 0.0 : 0.0009);
      if (watch.stuck(0,
                      on_route ? ProgressWatch::Away{0.1 + 0.002 * k, none, 20.0 - dt * k, {driven, 0.0, 0.0}}
                               : ProgressWatch::Away{1.0 - driven, none, none, {driven, 0.0, 0.0}},
                      dt))
        said_at = k;
    }
    EXPECT_GT(said_at, stands_from) << on_route;
    EXPECT_LE((said_at - stands_from) * dt, ProgressWatch::patience + dt) << on_route;
  }
}

TEST(ProgressWatch, ARobotThatFellBehindAndCatchesUpIsNotStuck) {
  ProgressWatch watch(1);
  for (int k = 0; k < 50; ++k) EXPECT_FALSE(watch.stuck(0, {0.006 * k, none, none}, dt));
  for (int k = 0; k < 600; ++k) EXPECT_FALSE(watch.stuck(0, {std::fmax(0.0, 0.3 - 0.0005 * k), none, none}, dt));
}

TEST(ProgressWatch, ARobotThatGoesToAndFroIsStuck) {
  ProgressWatch watch(1);
  int said = 0;
  for (int k = 0; k < 1000; ++k) said += watch.stuck(0, {0.2 + 0.03 * std::sin(0.08 * k), none, none}, dt);
  EXPECT_EQ(said, 1);
}

/// It drove along beside its place, held back by the shield, on a route that began anew every two seconds: each was
/// progress, so that nothing was said of it for as long as the run went on.
TEST(ProgressWatch, ARobotThatIsNeverAtAPlaceThatDrivesOnIsStuck) {
  for (const bool drives_on : {true, false}) {
    ProgressWatch watch(1);
    std::vector<double> said;
    for (int k = 0; k < 2000; ++k)
      if (watch.stuck(0, {0.1, none, 5.0 - dt * (k % 50), {0.001 * k, 0.0, 0.0}, none, drives_on}, dt))
        said.push_back(dt * k);
    ASSERT_EQ(said.size(), drives_on ? 1u : 0u);
    if (drives_on) {
      EXPECT_NEAR(said[0], 5.0 + ProgressWatch::long_patience, 2.0 * dt);
    }
    watch.restart(0);
    EXPECT_FALSE(watch.stuck(0, {0.1, none, 5.0, {}, none, drives_on}, dt));
  }
}

TEST(ProgressWatch, ANewRouteIsNoProgress) {
  ProgressWatch watch(1);
  int said_at = 0;
  for (int k = 0; k < 100; ++k)
    if (watch.stuck(0, {0.1, 0.1, k % 20 < 10 ? none : 20.0 + k}, dt)) said_at = k;
  EXPECT_EQ(said_at, 74);
}

}  // namespace
}  // namespace skein::core
