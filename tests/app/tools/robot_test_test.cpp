// `skein robots test` on emulated robots that a synthetic camera looks at: what is wrong with a robot is found and
// named.
#include "app/tools/robot_test.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/session/wheel_check.h"
#include "comms/emulator/epuck_firmware.h"
#include "core/kinematics/robot_type.h"
#include "tests/app/experiment_texts.h"
#include "tests/seconds.h"
#include "tests/stall.h"

namespace skein::app {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* two_robots =
    "[robot_defaults]\nlink = \"loopback\"\n"
    "[[robot]]\nname = \"anna\"\nstart = [-0.4, 0.2, 0.5]\n[[robot]]\nname = \"bert\"\nstart = [0.3, -0.2, 2.0]\n";

Experiment with_camera() {
  return good(two_robots, {"camera.source=synthetic", "rate=10"});  // fewer frames to draw
}

/// Robot 1 of a lab that is `truth`, tested by somebody who thinks that it is `believed`.
RobotTestResult test(const Experiment& truth, const Experiment& believed, std::vector<comms::Fault> faults = {},
                     std::size_t robot = 0) {
  SessionClock clock(false);
  SessionOptions options;
  options.every_tag = true;
  options.faults = std::move(faults);
  auto plant = Plant::open(truth, clock, options);
  EXPECT_TRUE(plant) << plant.error();
  const auto result = RobotTest(**plant, clock, believed, {}).test(robot);
  EXPECT_TRUE(result) << result.error();
  (*plant)->close();
  for (const RobotStatus& status : (*plant)->robots()) EXPECT_TRUE(status.stop_acknowledged);
  return result.value_or(RobotTestResult{});
}

TEST(RobotTest, FindsNothingWrongWithAGoodRobotAndMeasuresItsWheels) {
  const RobotTestResult robot = test(with_camera(), with_camera());
  EXPECT_THAT(robot.faults, IsEmpty());
  EXPECT_THAT(robot.notes, IsEmpty());
  EXPECT_EQ(robot.status.version, "Version 2.0 January 2018 GCtronic");
  EXPECT_EQ(robot.tag, 1);
  EXPECT_GE(robot.left_steps, 75);
  EXPECT_GE(robot.right_steps, 75);
  ASSERT_TRUE(robot.wheel_diameter && robot.track);
  EXPECT_NEAR(*robot.wheel_diameter / 0.041, 1.0, 0.005);  // an encoder's step is 0.2 % of the way
  EXPECT_NEAR(*robot.track / 0.053, 1.0, 0.005);
}

TEST(RobotTest, OverASlowRadioAGoodRobotIsFoundGoodAndSaysItsVersion) {
  const Experiment lab = good(two_robots, {"links.reply_timeout=4"});
  SessionClock clock(true);
  SessionOptions options;
  options.faults = {{.kind = comms::FaultKind::latency, .median = 0.4, .p99 = 0.6}};
  auto plant = Plant::open(lab, clock, options);
  ASSERT_TRUE(plant) << plant.error();
  const auto robot = RobotTest(**plant, clock, lab, {}).test(0);
  (*plant)->close();
  ASSERT_TRUE(robot) << robot.error();
  EXPECT_THAT(robot->faults, IsEmpty());
  EXPECT_EQ(robot->status.version, "Version 2.0 January 2018 GCtronic");
}

TEST(RobotTest, NamesSwappedWheels) {
  const RobotTestResult robot = test(with_camera(), with_camera(), {{.kind = comms::FaultKind::swapped_wheels}});
  EXPECT_THAT(robot.faults, ElementsAre("the wheels are swapped: the left wheel's command turns the other wheel",
                                        "the wheels are swapped: the right wheel's command turns the other wheel"));
  EXPECT_EQ(robot.tag, 1);
  EXPECT_FALSE(robot.wheel_diameter);
}

TEST(RobotTest, NamesMotorCablesSwappedBehindTheEncoders) {
  Experiment truth = with_camera();
  truth.robots[0].drive.track *= -1.0;  // each wheel on the other side: only the camera can tell
  const RobotTestResult robot = test(truth, with_camera());
  EXPECT_THAT(robot.faults, ElementsAre(AllOf(HasSubstr("the wheels are swapped: the left wheel's"),
                                              HasSubstr("according to the camera")),
                                        HasSubstr("the wheels are swapped: the right wheel's")));
}

TEST(RobotTest, NamesExchangedTags) {
  Experiment truth = with_camera();
  std::swap(truth.robots[0].tag, truth.robots[1].tag);
  const RobotTestResult robot = test(truth, with_camera());
  EXPECT_THAT(robot.faults,
              ElementsAre("the wrong tag: it carries tag 2, which is that of robot 2 (bert), instead of tag 1"));
  EXPECT_EQ(robot.tag, 2);
  EXPECT_TRUE(robot.wheel_diameter) << "of the robot that carries tag 2";
}

TEST(RobotTest, NamesATagThatNobodyKnows) {
  Experiment truth = with_camera();
  truth.robots[0].tag = 311;
  EXPECT_THAT(test(truth, with_camera()).faults, ElementsAre("the wrong tag: it carries tag 311, instead of tag 1"));
  Experiment unknown = with_camera();
  unknown.robots[0].tag = -1;  // a file of robots that does not say
  const RobotTestResult robot = test(truth, unknown);
  EXPECT_THAT(robot.faults, IsEmpty());
  EXPECT_EQ(robot.tag, 311);
}

/// It guessed that the tag was covered or outside the picture.
TEST(RobotTest, SaysWhyItsTagIsNotSeen) {
  const Experiment small = good(two_robots, {"camera.source=synthetic", "rate=10", "tags.size=0.012"});
  EXPECT_THAT(test(small, small).faults,
              ElementsAre(HasSubstr("no visible tag turns with it: tag 1 cannot be read: a tag of 12 mm has")));
  Experiment lab = with_camera();
  lab.robots[0].start = {-3.0, 0.2, 0.5};
  EXPECT_THAT(test(lab, lab).faults, ElementsAre("no visible tag turns with it: no tag 1 is in the picture"));
}

TEST(RobotTest, NamesADiameterThatIsFivePercentOff) {
  Experiment truth = with_camera();
  truth.robots[0].drive.wheel_diameter *= 1.05;
  const RobotTestResult robot = test(truth, with_camera());
  ASSERT_THAT(robot.faults,
              ElementsAre(AllOf(HasSubstr("wheel_diameter is 43."), HasSubstr("off the configured 41.00 mm"))));
  EXPECT_NEAR(*robot.wheel_diameter / (1.05 * 0.041), 1.0, 0.005);
  EXPECT_NEAR(*robot.track / 0.053, 1.0, 0.005);
}

TEST(RobotTest, NamesATrackThatIsFivePercentOff) {
  Experiment truth = with_camera();
  truth.robots[0].drive.track *= 0.95;
  const RobotTestResult robot = test(truth, with_camera());
  ASSERT_THAT(robot.faults, ElementsAre(HasSubstr("track is 50.")));
  EXPECT_NEAR(*robot.wheel_diameter / 0.041, 1.0, 0.005);
}

TEST(RobotTest, DoesNotDriveIntoOthersToMeasureWheels) {
  Experiment e = with_camera();
  e.robots[0].start = {0.0, 0.0, 0.0};
  e.robots[1].start = {0.15, 0.0, 0.0};
  EXPECT_TRUE(test(e, e).wheel_diameter) << "there is room behind it";
  e.robots[0].start = {-0.92, 0.0, 0.0};
  e.robots[1].start = {-0.77, 0.0, 0.0};
  const RobotTestResult robot = test(e, e);
  EXPECT_FALSE(robot.wheel_diameter) << "the arena ends behind it";
  EXPECT_THAT(robot.notes, ElementsAre(HasSubstr("its wheels were not measured: it needs")));
  e.robots[0].start = {0.92, 0.0, 0.0};
  e.robots[1].start = {0.81, 0.0, 0.0};
  EXPECT_FALSE(test(e, e).wheel_diameter) << "the arena ends ahead of it, and the other stands behind";
}

TEST(RobotTest, WithoutACameraItKnowsWhatEncodersSay) {
  const Experiment e = good(two_robots);
  EXPECT_THAT(test(e, e).faults, IsEmpty());
  EXPECT_THAT(test(e, e, {{.kind = comms::FaultKind::swapped_wheels}}).faults,
              ElementsAre(HasSubstr("swapped"), HasSubstr("swapped")));
  EXPECT_THAT(
      test(e, e, {{.kind = comms::FaultKind::silent_encoders}}, 1).faults,
      ElementsAre("the left wheel's encoder is silent: 0 steps", "the right wheel's encoder is silent: 0 steps"));
}

/// A robot on a pseudo-terminal that says everything twice while both its wheels drive, or whose time goes on by as
/// much with each message, and stands in between.
class OddRobot {
 public:
  explicit OddRobot(std::optional<double> seconds_a_message = {}) : seconds_a_message_(seconds_a_message) {
    termios raw{};
    ::cfmakeraw(&raw);
    EXPECT_EQ(::openpty(&robot_, &line_, nullptr, &raw, nullptr), 0);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  ~OddRobot() {
    thread_ = {};
    ::close(line_);
    ::close(robot_);
  }
  std::string address() const { return std::string("serial:") + ::ttyname(line_); }

 private:
  void run(const std::stop_token& stop) {
    comms::EpuckFirmware firmware(core::MotorModel::epuck2);
    for (double then = test::seconds(); !stop.stop_requested();) {
      pollfd said{robot_, POLLIN, 0};
      if (::poll(&said, 1, 1) < 1) continue;
      std::array<std::uint8_t, 256> bytes{};
      const ssize_t count = ::read(robot_, bytes.data(), bytes.size());
      const double now = test::seconds();
      const double passed = now - std::exchange(then, now);
      firmware.advance(seconds_a_message_.value_or(passed));
      if (count <= 0) continue;
      std::vector<std::uint8_t> reply;
      firmware.receive(std::span(bytes).first(static_cast<std::size_t>(count)), reply);
      const core::WheelSpeeds told = firmware.told();
      const int times = !seconds_a_message_ && told.left != 0.0 && told.right != 0.0 ? 2 : 1;
      for (int k = 0; k < times; ++k)
        EXPECT_EQ(::write(robot_, reply.data(), reply.size()), static_cast<ssize_t>(reply.size()));
    }
  }
  std::optional<double> seconds_a_message_;
  int robot_ = -1, line_ = -1;
  std::jthread thread_;
};

/// It is its link that stops such a robot, not its watchdog: what a file said of that would be relied on.
TEST(RobotTest, ARobotThatItsLinkStopsHasShownNoWatchdog) {
  OddRobot anna;
  Experiment experiment;
  RobotSpec& robot = experiment.robots.emplace_back();
  robot.link = RobotSpec::Link::device;
  robot.address = anna.address();
  robot.type = core::find_robot_type("epuck2");
  using Result = tl::expected<RobotTestResult, std::string>;
  const Result result = skein::test::unless_stalled(
      [&]() -> Result {
        SessionClock clock(true);
        auto plant = Plant::open(experiment, clock, {});
        if (!plant) return tl::unexpected(plant.error());
        return RobotTest(**plant, clock, experiment, [] { return true; }).test(0);
      },
      [](const Result& r) { return r ? std::string() : r.error(); });
  ASSERT_TRUE(result) << result.error();
  EXPECT_THAT(result->faults, IsEmpty());
  EXPECT_FALSE(result->watchdog) << *result->watchdog;
  EXPECT_THAT(result->notes, ElementsAre(HasSubstr("whether it has a watchdog is not known")));
}

/// With each command it drives for half a second: the test has ten commands for each wheel, and needs two.
TEST(WheelFaults, AWheelThatRunsAwayIsStoppedBeforeTheEndOfItsTurn) {
  const OddRobot anna(0.5);
  comms::LinkSupervisor links({comms::parse_link_address(anna.address()).value()});
  ASSERT_TRUE(links.start(10.0));
  const auto check = check_wheels(links, 0, *core::find_robot_type("epuck2"), [] { return std::string(); });
  ASSERT_TRUE(check) << check.error();
  EXPECT_THAT(check->faults, ElementsAre(HasSubstr("the left wheel turned at least"), HasSubstr("the right wheel")));
  EXPECT_LT(check->left_steps, 6 * 0.5 * one_wheel_speed);
  EXPECT_LT(check->right_steps, 6 * 0.5 * one_wheel_speed);
}

TEST(WheelFaults, AWheelThatTurnsTooFarIsOneUnlessItWasToldForSoLong) {
  const OneWheelTurn good{.left = 80, .right = 0}, far{.left = 200, .right = 0}, right{.left = 0, .right = 85};
  EXPECT_THAT(encoder_faults(good, right, 200), IsEmpty());
  EXPECT_THAT(encoder_faults(far, right, 200),
              ElementsAre("the left wheel turned at least 2.5 times too far: 200 steps instead of 80"));
  EXPECT_TRUE(far.too_far(200));
  EXPECT_FALSE(good.too_far(200));
  const OneWheelTurn late{.left = 200, .right = 0, .seconds = 0.9};  // on a machine that found no time to stop it
  EXPECT_FALSE(late.too_far(200));
  EXPECT_THAT(encoder_faults(late, right, 200), IsEmpty());
  EXPECT_EQ(speed_fault(0), "");
  EXPECT_EQ(speed_fault(3), "3 times it took speeds other than those sent, and was stopped");
}

}  // namespace
}  // namespace skein::app
