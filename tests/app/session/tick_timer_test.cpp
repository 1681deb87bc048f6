#include "app/session/tick_timer.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <vector>

namespace skein::app {
namespace {

constexpr double period = 0.04;

/// A control thread and a camera on a virtual clock. Frame k is ready at `phase` + k `interval` + its jitter.
struct Loop {
  TickTimer timer{period, period};
  double interval = period, phase = 0.0, jitter = 0.0;
  int drop_every = 0;  // 0: none
  double now = 0.0;
  int frame = 0, newest = -1;
  std::vector<double> begun, age;  // of every tick: when, and how old its newest frame was by then

  double ready(int k) const { return phase + k * interval + jitter * std::sin(7.0 * k); }
  bool exists(int k) const { return drop_every == 0 || k % drop_every != 0; }
  void tick(double work = 0.0005) {
    const TickTimer::Window window = timer.window();
    now = std::max(now, window.earliest);
    // As the camera's thread would: everything that is ready by `now`, then wait for one more.
    const auto take = [&] {
      for (; ready(frame) <= now; ++frame)
        if (exists(frame)) newest = frame;
    };
    take();
    while (now < window.latest && (newest < 0 || ready(newest) < window.since)) {
      now = std::min(window.latest, std::max(now, ready(frame)));
      take();
    }
    begun.push_back(now);
    age.push_back(newest < 0 ? NAN : now - ready(newest));
    if (newest >= 0 && newest != told) timer.frame(ready(newest) - 0.01, ready(newest));
    told = newest;
    now += work;
    elapsed.push_back(timer.ticked(now));
  }
  int told = -1;
  std::vector<int> elapsed;
};

TEST(TickTimer, KeepsAbsoluteDeadlinesWithoutACamera) {
  TickTimer timer(period, 1.0);
  for (int k = 0; k < 100; ++k) {
    EXPECT_NEAR(timer.window().earliest, 1.0 + k * period, 1e-12);
    EXPECT_EQ(timer.window().latest, timer.window().earliest);
    EXPECT_EQ(timer.ticked(timer.window().latest + 0.01), 1);
  }
}

TEST(TickTimer, CountsDeadlinesThatHavePassed) {
  TickTimer timer(period, 1.0);
  EXPECT_EQ(timer.ticked(1.0 + 3.5 * period), 4);
  EXPECT_NEAR(timer.window().earliest, 1.0 + 4 * period, 1e-12);
}

RC_GTEST_PROP(TickTimer, FollowsACameraOfItsOwnRateFromAnyPhase, ()) {
  Loop loop;
  loop.phase = *rc::gen::inRange(0, 4000) * 1e-5;
  loop.interval = period * (1.0 + *rc::gen::inRange(-100, 101) * 1e-5);  // quartz differs by less than 1e-3
  loop.jitter = *rc::gen::inRange(0, 100) * 1e-5;                        // up to 1 ms
  for (int k = 0; k < 400; ++k) loop.tick();
  RC_ASSERT(loop.timer.follows_frames());
  for (std::size_t k = 60; k < loop.age.size(); ++k) {
    RC_ASSERT(loop.age[k] < 0.0005);
    RC_ASSERT(loop.elapsed[k] == 1);
    RC_ASSERT(std::abs(loop.begun[k] - loop.begun[k - 1] - period) < 0.1 * period);
  }
}

TEST(TickTimer, FollowsACameraOfTwiceItsRate) {
  Loop loop;
  loop.interval = period / 2;
  loop.phase = 0.013;
  for (int k = 0; k < 200; ++k) loop.tick();
  for (std::size_t k = 60; k < loop.age.size(); ++k) EXPECT_LT(loop.age[k], 0.0005) << k;
}

TEST(TickTimer, LeavesItsDeadlinesAloneWithACameraOfAnotherRate) {
  Loop loop;
  loop.interval = 1.0 / 30.0;
  loop.phase = 0.01;
  for (int k = 0; k < 300; ++k) loop.tick();
  EXPECT_FALSE(loop.timer.follows_frames());
  for (std::size_t k = 0; k < loop.begun.size(); ++k)
    EXPECT_NEAR(loop.begun[k], static_cast<double>(k + 1) * period, 1e-9);
}

TEST(TickTimer, ATickIsDueWhenItsFrameIsReady) {
  constexpr TickTimer::Window window{.since = 0.996, .earliest = 0.998, .expected = 1.0, .latest = 1.002};
  EXPECT_EQ(window.due(1.001), 1.001);
  EXPECT_EQ(window.due(0.997), window.earliest) << "ready before the tick may begin";
  EXPECT_EQ(window.due(1.003), window.latest) << "came while the tick began";
  EXPECT_EQ(window.due(0.995), window.latest) << "the frame of the tick before, too late for it: another was awaited";
  EXPECT_EQ(window.due(std::nan("")), window.latest) << "no frame yet";
}

TEST(TickTimer, AFrameThatDoesNotComeCostsATwentiethOfAPeriod) {
  Loop loop;
  loop.phase = 0.017;
  loop.drop_every = 10;
  for (int k = 0; k < 300; ++k) loop.tick();
  ASSERT_TRUE(loop.timer.follows_frames());
  int waited = 0;
  for (std::size_t k = 100; k < loop.age.size(); ++k) {
    EXPECT_EQ(loop.elapsed[k], 1);
    EXPECT_NEAR(loop.begun[k] - loop.begun[k - 1], period, 0.051 * period);
    waited += loop.age[k] > 0.01;
  }
  EXPECT_EQ(waited, 20);  // one in ten, and its successors are on time
}

}  // namespace
}  // namespace skein::app
