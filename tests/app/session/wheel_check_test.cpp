// One robot tested through the link that its session has, while it stands ready.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/eventually.h"

namespace skein::app {
namespace {

class WheelChecks : public testing::Test {
 protected:
  void open(std::vector<comms::Fault> faults = {}) {
    auto experiment = load_experiment(experiments + "platoon-loopback.toml");
    ASSERT_TRUE(experiment);
    SessionOptions options;
    options.faults = std::move(faults);
    auto opened = Session::open(*experiment, Session::Clock::wall, options);
    ASSERT_TRUE(opened) << opened.error();
    session = std::move(*opened);
  }
  tl::expected<WheelCheck, std::string> result() {
    for (int k = 0; k < 6000; ++k) {
      if (auto found = session->wheel_check()) return *found;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return tl::unexpected(std::string("no result within a minute"));
  }
  std::unique_ptr<Session> session;
};

TEST_F(WheelChecks, OneThatDoesAsItIsTold) {
  open();
  ASSERT_TRUE(session->check_wheels(2));
  EXPECT_EQ(session->check_wheels(1).error(), "one test at a time");
  const auto test = result();
  ASSERT_TRUE(test) << test.error();
  EXPECT_EQ(test->robot, 2U);
  EXPECT_THAT(test->faults, testing::IsEmpty());
  EXPECT_THAT(test->version, testing::HasSubstr("GCtronic"));
  EXPECT_GT(test->left_steps, 20);
  EXPECT_FALSE(session->wheel_check()) << "it is told once";
  ASSERT_TRUE(session->check_wheels(0)) << "and another may be tested";
}

TEST_F(WheelChecks, OneThatHasBeenTestedDrivesWithTheOthers) {
  open();
  ASSERT_TRUE(session->check_wheels(2));
  const auto test = result();
  ASSERT_TRUE(test) << test.error();
  ASSERT_TRUE(session->start());
  const auto steps = [this] { return session->robots()[2].count.left; };
  const double before = steps();
  EXPECT_TRUE(skein::test::eventually([&] { return steps() > before + 200.0; })) << steps() - before;
}

TEST_F(WheelChecks, SwappedWheelsAreNamedAndOthersStand) {
  open({{.kind = comms::FaultKind::swapped_wheels, .robot = 1}});
  ASSERT_TRUE(session->check_wheels(1));
  const auto test = result();
  ASSERT_TRUE(test) << test.error();
  ASSERT_EQ(test->faults.size(), 2U);
  EXPECT_THAT(test->faults[0], testing::HasSubstr("swapped"));
}

TEST_F(WheelChecks, AStopEndsItAndAStartRefusesIt) {
  open();
  ASSERT_TRUE(session->check_wheels(0));
  session->stop();
  EXPECT_EQ(result().error(), "robot 1 could not be tested: STOP was pressed");
  EXPECT_THAT(session->check_wheels(0).error(), testing::HasSubstr("before a start"));
  EXPECT_THAT(session->check_wheels(9).error(), testing::HasSubstr("there is no robot 10"));
}

TEST_F(WheelChecks, TheSessionMayBeClosedInTheMiddle) {
  open();
  ASSERT_TRUE(session->check_wheels(3));
  session->close();
  EXPECT_FALSE(result());
}

TEST(WheelCheck, SimulatedOnesHaveNothingToTest) {
  auto session = Session::open(paper_experiment(), Session::Clock::virtual_);
  ASSERT_TRUE(session);
  EXPECT_EQ((*session)->check_wheels(0).error(), "robot 1 is simulated: it has no link and no battery to test");
}

}  // namespace
}  // namespace skein::app
