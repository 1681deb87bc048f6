#include "comms/link_supervisor.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <thread>

#include "comms/emulator/pty_emulator.h"
#include "comms/transport.h"
#include "tests/comms/other_program.h"
#include "tests/comms/wait_until.h"
#include "tests/property.h"
#include "tests/seconds.h"

namespace skein::comms {
namespace {

using core::MotorModel;
using core::WheelSpeeds;
using test::wait_until;

using test::seconds;

/// No stop by command silence and long patience: for tests of something else, on a machine that may be slow.
constexpr LinkOptions patient{.reply_timeout = 5.0, .command_silence = 0.0, .heartbeat = 0.0};
/// Short time-outs, for tests of what happens after them.
constexpr LinkOptions hasty{.reply_timeout = 0.05,
                            .command_silence = 0.0,
                            .heartbeat = 0.05,
                            .reconnect_first = 0.02,
                            .reconnect_longest = 0.1};

class Supervised : public testing::Test {
 protected:
  void start(std::size_t count, LinkOptions options) {
    robots.emplace(std::vector<MotorModel>(count, MotorModel::epuck2), nullptr, seconds);
    std::vector<LinkAddress> addresses;
    for (std::size_t i = 0; i < count; ++i) addresses.push_back({LinkKind::serial, robots->device(i), 0, ""});
    links.emplace(addresses, options);
    const auto started = links->start(10.0);
    ASSERT_TRUE(started) << started.error();
  }
  bool drives(std::size_t robot, double left, double right) {
    return wait_until([&] { return robots->wheels(robot) == WheelSpeeds{left, right}; });
  }
  bool stands(std::size_t robot) { return drives(robot, 0, 0); }
  LinkStatus status(std::size_t robot) { return links->status().at(robot); }
  bool reaches(std::size_t robot, LinkState state) {
    return wait_until([&] { return status(robot).state == state; });
  }

  std::optional<PtyEmulator> robots;
  std::optional<LinkSupervisor> links;
};

TEST_F(Supervised, StartsWithEveryRobotUpAndStopped) {
  start(3, patient);
  ASSERT_EQ(links->size(), 3u);
  for (const LinkStatus& link : links->status()) {
    EXPECT_EQ(link.state, LinkState::up);
    EXPECT_TRUE(link.stop_acknowledged);
  }
  EXPECT_FALSE(links->start(1.0)) << "once only";
}

TEST_F(Supervised, StartStopsARobotThatSomebodyLeftDriving) {
  robots.emplace(std::vector{MotorModel::epuck2}, nullptr, seconds);
  const LinkAddress address{LinkKind::serial, robots->device(0), 0, ""};
  {
    auto line = Transport::open(address);
    ASSERT_TRUE(line);
    const std::string left_behind = "D,500,500\nD,0";
    ASSERT_TRUE(line->write(std::span(reinterpret_cast<const std::uint8_t*>(left_behind.data()), left_behind.size())));
    ASSERT_TRUE(drives(0, 500, 500));
  }
  links.emplace(std::vector{address}, patient);
  ASSERT_TRUE(links->start(10.0));
  EXPECT_EQ(robots->wheels(0), WheelSpeeds{});
}

TEST_F(Supervised, StartsWithThoseThatAnswerAndSaysOfTheOthersWhyNot) {
  robots.emplace(std::vector{MotorModel::epuck2}, nullptr, seconds);
  const std::vector<LinkAddress> addresses{{LinkKind::serial, robots->device(0), 0, ""},
                                           {LinkKind::serial, "/dev/no-such-robot", 0, ""}};
  EXPECT_FALSE(LinkSupervisor(addresses, patient).start(0.2)) << "the control: a run needs all of them";
  links.emplace(addresses, patient);
  ASSERT_TRUE(links->start_who_answers(2.0));
  EXPECT_EQ(status(0).state, LinkState::up);
  EXPECT_NE(status(1).state, LinkState::up);
  EXPECT_NE(status(1).reason.find("no-such-robot"), std::string::npos) << status(1).reason;
  links->command(0, 200, 200);
  EXPECT_TRUE(drives(0, 200, 200));
  EXPECT_TRUE(links->close(10.0).at(0).stop_acknowledged);
}

/// To search all programs for whoever has the line would hold up the other robots' commands and stops.
TEST_F(Supervised, WhileRobotsMayDriveNobodyIsSearchedForWhoHasTakenALine) {
  robots.emplace(std::vector{MotorModel::epuck2}, nullptr, seconds);
  LinkOptions options = patient;
  options.reconnect_first = 2.0;  // by then the line is another program's
  links.emplace(std::vector{LinkAddress{LinkKind::serial, robots->device(0), 0, ""}}, options);
  ASSERT_TRUE(links->start(10.0));
  robots->hang_up(0);
  const OtherProgram manager(robots->device(0), [](int line) { EXPECT_EQ(::ioctl(line, TIOCEXCL), 0); });
  ASSERT_TRUE(wait_until([&] { return status(0).reason.find("is using the device") != std::string::npos; }))
      << status(0).reason;
  EXPECT_EQ(status(0).reason, "another program is using the device");
}

TEST_F(Supervised, AStartIsEndedByWhoeverNoLongerWantsIt) {
  robots.emplace(std::vector{MotorModel::epuck2}, nullptr, seconds);
  robots->silence(0, true);
  links.emplace(std::vector{LinkAddress{LinkKind::serial, robots->device(0), 0, ""}}, patient);
  int asked = 0;
  const auto started = links->start(1e6, [&] { return ++asked < 3; });
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error(), "stopped");
  EXPECT_EQ(asked, 3);
}

TEST_F(Supervised, CommandsArriveAndAreAcknowledged) {
  start(3, patient);
  for (int i = 1; i <= 50; ++i) {
    for (std::size_t robot = 0; robot < 3; ++robot) links->command(robot, 100 * i % 900, -static_cast<int>(robot));
    ASSERT_TRUE(links->wait_acknowledged(10.0));
    for (std::size_t robot = 0; robot < 3; ++robot)
      ASSERT_EQ(robots->wheels(robot),
                (WheelSpeeds{core::actual_step_rate(MotorModel::epuck2, 100 * i % 900), -static_cast<double>(robot)}));
  }
  EXPECT_GT(status(0).exchanges, 0u);
  EXPECT_GT(status(0).rtt_median, 0.0);
  EXPECT_GE(status(0).rtt_p99, status(0).rtt_median);
  EXPECT_FALSE(status(0).stop_acknowledged);
  links->command(17, 1, 1);  // no such robot: nothing happens
}

TEST_F(Supervised, TheNewestCommandWins) {
  start(2, patient);
  for (int i = 1; i <= 2000; ++i) links->command(0, i % 1000, i % 1000);
  links->command(0, 250, -250);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  EXPECT_EQ(robots->wheels(0), (WheelSpeeds{250, -250}));
  EXPECT_LE(status(0).exchanges, 2001u);
}

TEST_F(Supervised, EncodersAreUnwrapped) {
  start(1, patient);
  links->command(0, 1000, -1000);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  ASSERT_TRUE(wait_until([&] {
    links->command(0, 1000, -1000);
    return links->wait_acknowledged(10.0) && status(0).left_steps > 50;
  }));
  EXPECT_NEAR(static_cast<double>(status(0).left_steps + status(0).right_steps), 0.0, 2.0);
}

TEST_F(Supervised, CommandSilenceStops) {
  LinkOptions options = patient;
  options.command_silence = 0.05;
  start(2, options);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  EXPECT_TRUE(stands(0));
  EXPECT_TRUE(wait_until([&] { return status(0).stop_acknowledged; }));
  EXPECT_EQ(status(0).exchanges, 1u);
}

TEST_F(Supervised, ALostReplyIsResynchronised) {
  start(2, hasty);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  robots->silence(0, true);
  links->command(0, 200, 200);
  EXPECT_TRUE(reaches(0, LinkState::stale));
  EXPECT_EQ(status(1).state, LinkState::up) << "the others are not held up";
  EXPECT_FALSE(links->wait_acknowledged(0.01));
  robots->silence(0, false);
  EXPECT_TRUE(links->wait_acknowledged(10.0)) << "the command is sent again";
  EXPECT_TRUE(drives(0, 200, 200));
  EXPECT_GT(status(0).timeouts, 0u);
  EXPECT_EQ(status(0).reconnects, 0u);
}

TEST_F(Supervised, AHangUpReconnectsAndTheRobotStaysStopped) {
  // The system tells of a hang-up: no time-out is waited for, and none may stop the other robot on a busy machine.
  LinkOptions options = patient;
  options.blind_distance = 0.0;
  options.stop_repeat = options.reply_timeout;
  options.reconnect_first = 0.02;
  start(2, options);
  for (std::size_t robot = 0; robot < 2; ++robot) links->command(robot, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  robots->hang_up(0);
  EXPECT_TRUE(wait_until([&] { return status(0).reconnects == 1; }));
  EXPECT_EQ(robots->wheels(0), WheelSpeeds{});
  EXPECT_EQ(status(0).reason, "the line hung up");
  EXPECT_EQ(robots->wheels(1), (WheelSpeeds{100, 100})) << "the others drive on";
  links->command(0, 250, 250);
  EXPECT_TRUE(links->wait_acknowledged(10.0));
  EXPECT_EQ(robots->wheels(0), (WheelSpeeds{250, 250}));
}

TEST_F(Supervised, ARobotThatWasReachedOnceIsNeverGivenUp) {
  // Its device is gone for a while, as that of an adapter on the USB is: before a first connection that is for good.
  const auto line = std::filesystem::temp_directory_path() / ("skein_line_" + std::to_string(::getpid()));
  robots.emplace(std::vector{MotorModel::epuck2}, nullptr, seconds);
  std::filesystem::create_symlink(robots->device(0), line);
  links.emplace(std::vector{LinkAddress{LinkKind::serial, line, 0, ""}}, hasty);
  const auto started = links->start(10.0);
  ASSERT_TRUE(started) << started.error();
  std::filesystem::remove(line);
  robots->hang_up(0);
  ASSERT_TRUE(wait_until([&] { return status(0).reason.find("there is no device") != std::string::npos; }))
      << status(0).reason;
  std::filesystem::create_symlink(robots->device(0), line);
  EXPECT_TRUE(wait_until([&] { return status(0).reconnects >= 1; })) << status(0).reason;
  EXPECT_TRUE(reaches(0, LinkState::up));
  std::filesystem::remove(line);
}

TEST_F(Supervised, ALineThatSaysNothingForLongIsOpenedAgain) {
  LinkOptions options = hasty;
  options.silence_reconnect = 0.2;
  start(1, options);
  robots->silence(0, true);
  EXPECT_TRUE(wait_until([&] { return status(0).reason.find("sent nothing") != std::string::npos; }));
  robots->silence(0, false);
  EXPECT_TRUE(wait_until([&] { return status(0).reconnects >= 1; }));
}

TEST_F(Supervised, ARestartedRobotIsStoppedAndThenObeys) {
  start(1, hasty);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  robots->reboot(0);
  EXPECT_TRUE(wait_until([&] { return status(0).reason == "the robot restarted"; }));
  EXPECT_TRUE(reaches(0, LinkState::up));
  links->command(0, 200, 200);
  EXPECT_TRUE(links->wait_acknowledged(10.0));
  EXPECT_EQ(robots->wheels(0), (WheelSpeeds{200, 200}));
}

TEST_F(Supervised, GarbageIsResynchronised) {
  start(1, hasty);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  for (const std::string garbage : {"?", "\r\n", "s\r\n", "z,Command not found\r\n", "\x01\x02\x03\x04\x05\x06\x07"}) {
    robots->say(0, garbage);
    links->command(0, 200, 200);
    EXPECT_TRUE(wait_until([&] { return links->wait_acknowledged(0.0) && status(0).state == LinkState::up; }))
        << garbage;
    links->command(0, 250, 250);
    EXPECT_TRUE(links->wait_acknowledged(10.0)) << garbage;
    EXPECT_TRUE(drives(0, 250, 250));
  }
}

TEST_F(Supervised, EmergencyStopHoldsUntilItIsReleased) {
  start(3, patient);
  for (std::size_t robot = 0; robot < 3; ++robot) links->command(robot, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  links->emergency_stop();
  EXPECT_TRUE(links->stopped());
  for (std::size_t robot = 0; robot < 3; ++robot) EXPECT_TRUE(stands(robot));
  EXPECT_TRUE(wait_until([&] { return status(2).stop_acknowledged; }));
  for (std::size_t robot = 0; robot < 3; ++robot) links->command(robot, 200, 200);
  EXPECT_TRUE(links->wait_acknowledged(10.0)) << "nothing to wait for: the commands are void";
  for (std::size_t robot = 0; robot < 3; ++robot) EXPECT_EQ(robots->wheels(robot), WheelSpeeds{});
  links->release_stop();
  EXPECT_FALSE(links->stopped());
  for (std::size_t robot = 0; robot < 3; ++robot) links->command(robot, 200, 200);
  EXPECT_TRUE(links->wait_acknowledged(10.0));
  EXPECT_EQ(robots->wheels(2), (WheelSpeeds{200, 200}));
}

TEST_F(Supervised, EmergencyStopGoesOutWithAReplyOutstanding) {
  start(1, patient);  // 5 s until a reply counts as lost
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  robots->silence(0, true);  // hears nothing: this exchange is never answered
  links->command(0, 200, 200);
  ASSERT_FALSE(links->wait_acknowledged(0.05));
  robots->silence(0, false);
  const double pressed = seconds();
  links->emergency_stop();
  EXPECT_TRUE(stands(0));
  EXPECT_LT(seconds() - pressed, 4.0) << "did not wait for the reply";
  EXPECT_TRUE(wait_until([&] { return status(0).stop_acknowledged; }));
}

TEST_F(Supervised, EmergencyStopIsRepeatedUntilItIsAcknowledged) {
  start(1, hasty);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  robots->silence(0, true);
  links->emergency_stop();
  ASSERT_TRUE(wait_until([&] { return status(0).timeouts >= 3; }));
  EXPECT_FALSE(status(0).stop_acknowledged);
  robots->silence(0, false);
  EXPECT_TRUE(stands(0));
  EXPECT_TRUE(wait_until([&] { return status(0).stop_acknowledged; }));
}

TEST_F(Supervised, AnEmergencyStopReleasedAtOnceStillStops) {
  start(1, patient);
  for (int i = 0; i < 100; ++i) {
    links->command(0, 100, 100);
    links->emergency_stop();
    links->release_stop();
    ASSERT_TRUE(links->wait_acknowledged(10.0)) << "the command was obeyed before the stop, or it is void";
    ASSERT_TRUE(wait_until([&] { return status(0).stop_acknowledged && robots->wheels(0) == WheelSpeeds{}; }));
  }
}

LinkSupervisor* stopped_by_signal = nullptr;

TEST_F(Supervised, EmergencyStopWorksFromASignalHandler) {
  start(1, patient);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  stopped_by_signal = &*links;
  const auto before = std::signal(SIGUSR1, [](int) { stopped_by_signal->emergency_stop(); });
  std::raise(SIGUSR1);
  EXPECT_TRUE(stands(0));
  std::signal(SIGUSR1, before);
}

TEST_F(Supervised, CloseStopsAndReportsIt) {
  start(2, patient);
  links->command(0, 100, 100);
  links->command(1, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  const auto closed = links->close(10.0);
  for (std::size_t robot = 0; robot < 2; ++robot) {
    EXPECT_EQ(closed[robot].state, LinkState::closed);
    EXPECT_TRUE(closed[robot].stop_acknowledged);
    EXPECT_EQ(robots->wheels(robot), WheelSpeeds{});
  }
  EXPECT_TRUE(links->close(0.0)[1].stop_acknowledged) << "the same again";
  links->command(0, 100, 100);  // goes nowhere
  links->emergency_stop();
}

TEST_F(Supervised, CloseSaysWhichRobotDidNotAcknowledge) {
  start(2, hasty);
  for (std::size_t robot = 0; robot < 2; ++robot) links->command(robot, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  robots->silence(0, true);
  const auto closed = links->close(2.0);  // as long as the other one may need on a busy machine
  EXPECT_EQ(closed[0].state, LinkState::failed);
  EXPECT_FALSE(closed[0].stop_acknowledged);
  EXPECT_NE(closed[0].reason, "");
  EXPECT_EQ(closed[1].state, LinkState::closed);
  EXPECT_TRUE(closed[1].stop_acknowledged);
}

TEST_F(Supervised, CloseReconnectsToStopARobotWhoseLinkIsLost) {
  start(1, hasty);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  robots->hang_up(0);
  EXPECT_TRUE(links->close(10.0)[0].stop_acknowledged);
  EXPECT_EQ(robots->wheels(0), WheelSpeeds{});
}

TEST_F(Supervised, TheDestructorStopsTheRobots) {
  start(1, patient);
  links->command(0, 100, 100);
  ASSERT_TRUE(links->wait_acknowledged(10.0));
  links.reset();
  EXPECT_EQ(robots->wheels(0), WheelSpeeds{});
}

TEST_F(Supervised, StartNamesTheRobotThatIsMissing) {
  robots.emplace(std::vector{MotorModel::epuck2}, nullptr, seconds);
  links.emplace(
      std::vector<LinkAddress>{{LinkKind::serial, robots->device(0), 0, ""}, {LinkKind::serial, "/nowhere", 0, ""}},
      patient);
  const double begun = seconds();
  const auto started = links->start(60.0);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error(), "robot 2 (serial:/nowhere): there is no device /nowhere");
  EXPECT_LT(seconds() - begun, 30.0) << "no use in waiting";
  EXPECT_EQ(status(1).state, LinkState::failed);
}

TEST_F(Supervised, StartNamesTheRobotThatDoesNotAnswer) {
  robots.emplace(std::vector{MotorModel::epuck2, MotorModel::epuck2}, nullptr, seconds);
  robots->silence(1, true);
  LinkOptions options = patient;
  options.reply_timeout = 0.5;  // the other one answers within it, also on a busy machine
  options.close_timeout = 0.2;
  links.emplace(std::vector<LinkAddress>{{LinkKind::serial, robots->device(0), 0, ""},
                                         {LinkKind::serial, robots->device(1), 0, ""}},
                options);
  const auto started = links->start(3.0);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().find("robot 2 (serial:"), 0u) << started.error();
  EXPECT_NE(started.error().find("no answer to the stop"), std::string::npos) << started.error();
}

TEST(LinkSupervisor, NoRobotsIsNoTrouble) {
  LinkSupervisor links({});
  EXPECT_TRUE(links.start(1.0));
  EXPECT_TRUE(links.wait_acknowledged(0.0));
  EXPECT_TRUE(links.close(1.0).empty());
}

TEST(LinkSupervisor, ClosingBeforeStartingIsNoTrouble) {
  LinkSupervisor links({{LinkKind::serial, "/nowhere", 0, ""}});
  links.command(0, 100, 100);
  links.emergency_stop();
  EXPECT_EQ(links.close(1.0).size(), 1u);
}

TEST_F(Supervised, ManyThreadsAtOnce) {
  start(4, patient);
  std::atomic<bool> done{false};
  std::thread watcher([&] {
    while (!done) (void)links->status();
  });
  std::thread stopper([&] {
    while (!done) {
      links->emergency_stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      links->release_stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  for (int i = 0; i < 100; ++i) {
    for (std::size_t robot = 0; robot < 4; ++robot) links->command(robot, i, -i);
    (void)links->wait_acknowledged(0.01);
  }
  done = true;
  watcher.join();
  stopper.join();
  for (const LinkStatus& link : links->close(20.0)) EXPECT_TRUE(link.stop_acknowledged);
  for (std::size_t robot = 0; robot < 4; ++robot) EXPECT_EQ(robots->wheels(robot), WheelSpeeds{});
}

}  // namespace
}  // namespace skein::comms
