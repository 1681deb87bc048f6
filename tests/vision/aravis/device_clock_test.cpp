#include "vision/aravis/device_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace skein::vision::detail {
namespace {

constexpr double period = 0.04, drift = 50e-6, origin = -1e5;

double device(double host) {
  return (host - origin) * (1.0 + drift);
}

/// A minute of frames stamped when their exposure begins, each sent 12 ms later and 0 to 3 ms on its way.
struct Minute {
  double worst = 0.0, worst_arrival = 0.0;
};
Minute minute(DeviceClock& clock, double began) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> way(0.0, 0.003);
  Minute result;
  for (int k = 0; k < 1500; ++k) {
    const double exposed = began + k * period;
    const double arrived = exposed + 0.012 + way(random);
    result.worst = std::max(result.worst, std::abs(clock.host(device(exposed), arrived) - exposed));
    result.worst_arrival = std::max(result.worst_arrival, std::abs(arrived - exposed));
  }
  return result;
}

TEST(DeviceClock, AClockThatWasReadTellsTheStampThoughItDrifts) {
  constexpr double began = 1000.0;
  DeviceClock clock(began - device(began));
  const Minute result = minute(clock, began);
  EXPECT_LT(result.worst, 0.0008);
  EXPECT_GT(result.worst_arrival, 0.0145) << "what the time of arrival would have been off";
  ASSERT_TRUE(clock.delay());
  EXPECT_NEAR(*clock.delay(), 0.012, 0.0003);
  EXPECT_TRUE(clock.read());
}

TEST(DeviceClock, AClockThatCannotBeReadTellsTheQuickestArrival) {
  DeviceClock clock;
  constexpr double began = 1000.0;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> way(0.0, 0.003);
  for (int k = 0; k < 1500; ++k) {
    const double exposed = began + k * period;
    const double arrived = exposed + 0.012 + way(random);
    const double told = clock.host(device(exposed), arrived);
    EXPECT_LE(told, arrived);
    if (k > 50) {
      EXPECT_NEAR(told, exposed + 0.012, 0.0005) << k;
    }
  }
  EXPECT_FALSE(clock.read());
  EXPECT_TRUE(clock.usable());
}

TEST(DeviceClock, FramesThatABusyMachineTakesLateKeepTheirStamps) {
  constexpr double began = 1000.0;
  for (const bool read : {true, false}) {
    DeviceClock clock = read ? DeviceClock(began - device(began)) : DeviceClock();
    for (int k = 0; k < 500; ++k) {
      const double exposed = began + k * period;
      // Every four seconds the host stalls for 0.2 s, and all the frames of that time arrive at its end.
      const double stalled_until = began + (k - k % 100) * period + 0.212;
      const double arrived = std::max(exposed + 0.012, k > 100 ? stalled_until : 0.0);
      const double told = clock.host(device(exposed), arrived);
      if (k > 50) {
        EXPECT_NEAR(told, exposed + (read ? 0.0 : 0.012), 0.0005) << k;
        EXPECT_TRUE(clock.usable()) << k;
      }
    }
  }
}

TEST(DeviceClock, StampsThatDoNotGoWithTimeAreNotUsed) {
  const struct {
    const char* what;
    double (*stamp)(double host);
  } cases[] = {
      {"it stands still", [](double) { return 5.0; }},
      {"ticks of 8 ns that are taken for 1 ns", [](double host) { return host / 8.0; }},
      {"milliseconds", [](double host) { return 1000.0 * host; }},
  };
  for (const auto& [what, stamp] : cases) {
    DeviceClock clock(0.0);
    for (int k = 0; k < 100; ++k) {
      const double arrived = 10.0 + k * period;
      const double told = clock.host(stamp(arrived), arrived);
      if (k > 5) {
        EXPECT_EQ(told, arrived) << what << " " << k;
      }
    }
    EXPECT_FALSE(clock.usable()) << what;
  }
}

TEST(DeviceClock, AClockThatIsSetBackIsLearntAnew) {
  constexpr double began = 1000.0;
  DeviceClock clock(began - device(began));
  minute(clock, began);
  for (int k = 0; k < 100; ++k) {
    const double exposed = 1060.0 + k * period;
    const double told = clock.host(exposed - 1059.0, exposed + 0.012);
    EXPECT_NEAR(told, exposed + 0.012, 1e-9);
  }
  EXPECT_TRUE(clock.usable());
  EXPECT_FALSE(clock.read());
}

}  // namespace
}  // namespace skein::vision::detail
