// Another robot answers where one was driven: it was swapped, flashed, or its address now leads elsewhere, and it
// drives, as its last host has left it. Whatever it is, it is not said to stand while it drives.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "comms/emulator/emulated_epuck.h"
#include "comms/emulator/make_firmware.h"
#include "comms/protocol.h"
#include "core/kinematics/robot_type.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

struct SpeakingRobot {
  const char* type;
  EpuckProgram program;
  const char* protocol;
};
constexpr std::array speaking_robots{
    SpeakingRobot{"epuck1", EpuckProgram::asercom, "asercom"},
    SpeakingRobot{"epuck2", EpuckProgram::asercom, "asercom"}, SpeakingRobot{"epuck2", EpuckProgram::wifi, "wifi"},
    SpeakingRobot{"khepera4", EpuckProgram::asercom, "khepera4"}, SpeakingRobot{"open", EpuckProgram::asercom, "open"}};

/// A robot and who speaks with it, in steps of a millisecond.
class Conversation {
 public:
  explicit Conversation(const char* protocol) {
    LinkOptions options;
    options.ask_version = true;
    session = find_protocol(protocol)->make_session(options);
  }
  void meet(EmulatedEpuck& other, double now) {
    robot = &other;
    (void)robot->take();
    robot->accept();
    session->opened(now);
  }
  void turn(double now, bool commands) {
    robot->advance(now);
    session->received(robot->take(), now);
    if (commands && ++turns_ % 40 == 0)
      session->command({static_cast<std::int16_t>(300 + turns_ % 70), 280}, ++ticket_, now);
    session->advance(now);
    if (session->garbled()) {  // Link opens it again
      session->lost("garbled", now);
      meet(*robot, now);
    }
    for (int k = 0; k < 20 && !session->output().empty(); ++k) {
      const std::vector<std::uint8_t> bytes(session->output().begin(), session->output().end());
      session->sent(bytes.size(), now);
      robot->receive(bytes, now);
      session->received(robot->take(), now);
    }
  }
  std::unique_ptr<LinkSession> session;
  EmulatedEpuck* robot = nullptr;

 private:
  int turns_ = 0;
  std::uint16_t ticket_ = 0;
};

EmulatedEpuck robot_of(const SpeakingRobot& kind, double now) {
  const core::RobotType& type = *core::find_robot_type(kind.type);
  if (auto firmware = make_firmware(type)) return {std::move(firmware), now, {}, 0};
  return {type.motor, now, {}, 0, kind.program};
}

TEST(OtherRobot, IsNotSaidToStandWhileItDrives) {
  int driven = 0;
  for (const SpeakingRobot& first : speaking_robots)
    for (const SpeakingRobot& second : speaking_robots) {
      SCOPED_TRACE(std::string(first.type) + "/" + first.protocol + ", then " + second.type + "/" + second.protocol);
      EmulatedEpuck before = robot_of(first, 0.0), after = robot_of(second, 0.0);
      Conversation ours(first.protocol), theirs(second.protocol);
      ours.meet(before, 0.0);
      theirs.meet(after, 0.0);
      double now = 0.0;
      for (; now < 1.5; now += 0.001) {
        ours.turn(now, true);
        theirs.turn(now, true);
      }
      ASSERT_TRUE(ours.session->up());
      driven += after.wheels() != core::WheelSpeeds{} ? 1 : 0;
      ours.session->lost("the line hung up", now);
      ours.meet(after, now);
      for (; now < 6.0; now += 0.001) {
        ours.turn(now, now > 4.0);
        ASSERT_FALSE(ours.session->stop_acknowledged() && after.wheels() != core::WheelSpeeds{}) << now << " s";
      }
      if (std::string_view(first.protocol) == second.protocol) {
        EXPECT_TRUE(ours.session->up()) << ours.session->status(now).reason;
      } else {
        EXPECT_FALSE(ours.session->status(now).reason.empty());
      }
    }
  EXPECT_EQ(driven, static_cast<int>(speaking_robots.size() * speaking_robots.size())) << "or it proves little";
}

}  // namespace
}  // namespace skein::comms
