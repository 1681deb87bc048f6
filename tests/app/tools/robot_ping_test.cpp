#include "app/tools/robot_ping.h"

#include <gtest/gtest.h>

#include "app/tools/robot_test.h"

namespace skein::app {
namespace {

TEST(RobotPing, TheProposalHoldsTwoSlowRoundTripsAndATickTwiceOver) {
  const LinksSpec links = proposed_links(0.25, 0.1, 0.04);
  EXPECT_NEAR(links.blind_distance, 0.11, 1e-9);  // 2 * 0.1 * (2 * 0.25 + 0.04) = 0.108, in steps of 5 mm
  EXPECT_NEAR(links.reply_timeout, 0.75, 1e-9);
  EXPECT_NEAR(proposed_links(0.004, 0.1, 0.04).blind_distance, 0.02, 1e-9) << "not below";
  EXPECT_NEAR(proposed_links(0.004, 0.1, 0.04).reply_timeout, 0.2, 1e-9);
}

TEST(RobotPing, TheHistogramHasEveryExchangeAndNoEmptyEnds) {
  comms::RoundTrips times;
  for (int i = 0; i < 90; ++i) times.add(0.004);
  for (int i = 0; i < 9; ++i) times.add(0.03);
  times.add(0.3);
  const std::vector<std::string> lines = histogram(times);
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_NE(lines.front().find("2 .. 5 ms"), std::string::npos) << lines.front();
  EXPECT_NE(lines.front().find("90.00 %"), std::string::npos) << lines.front();
  EXPECT_NE(lines.back().find("200 .. 500 ms"), std::string::npos) << lines.back();
  EXPECT_NE(lines.back().find("1.00 %"), std::string::npos) << lines.back();
  EXPECT_TRUE(histogram(comms::RoundTrips{}).empty());
}

TEST(RobotTest, ARobotThatDrivesOnForTheWholeSecondHasNoDeadMansSwitch) {
  EXPECT_EQ(watchdog_of(155.0, 150.0, 1.0), 0.0);
  EXPECT_EQ(watchdog_of(-148.0, -150.0, 1.0), 0.0);
  EXPECT_NEAR(watchdog_of(60.0, 150.0, 1.0), 0.4, 1e-9) << "it stopped after 0.4 s";
}

}  // namespace
}  // namespace skein::app
