#include "comms/emulator/pty_emulator.h"

#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <system_error>
#include <thread>

#include "comms/asercom.h"
#include "comms/emulator/emulate.h"
#include "comms/transport.h"
#include "tests/comms/bytes.h"
#include "tests/comms/wait_until.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using core::MotorModel;
using test::Bytes;

/// Sends `request` and collects what comes back until `size` bytes are there (or nothing comes for 10 s).
Bytes exchange(Transport& line, std::span<const std::uint8_t> request, std::size_t size) {
  EXPECT_EQ(line.write(request).value_or(0), request.size());
  Bytes reply;
  while (reply.size() < size) {
    pollfd waiting = line.wanted(false);
    if (::poll(&waiting, 1, 10000) <= 0) break;
    std::array<std::uint8_t, 256> bytes;
    const auto count = line.read(bytes);
    if (!count) break;
    reply.insert(reply.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(*count));
  }
  return reply;
}

Transport open(const PtyEmulator& robots, std::size_t robot) {
  auto line = Transport::open({LinkKind::serial, robots.device(robot), 0, ""});
  if (!line) throw std::runtime_error(line.error().reason);
  return std::move(*line);
}

TEST(PtyEmulator, AnswersOverThePseudoTerminalByteForByte) {
  PtyEmulator robots({MotorModel::epuck1, MotorModel::epuck2}, nullptr, [] { return 0.0; });
  ASSERT_EQ(robots.size(), 2u);
  Transport first = open(robots, 0), second = open(robots, 1);
  // 0x0A and 0x0D pass unchanged: the line is raw.
  EXPECT_EQ(exchange(first, test::set_and_read({0x0A, 0x0D}), 4), (Bytes{0, 0, 0, 0}));
  EXPECT_EQ(robots.wheels(0), (core::WheelSpeeds{10, core::actual_step_rate(MotorModel::epuck1, 13)}));
  EXPECT_EQ(test::text(exchange(second, test::bytes("V\n"), 54)),
            "v,Version 2.0 January 2018 GCtronic\r\nHW version: FFFF\r\n");
}

TEST(PtyEmulator, WheelsAreReportedBeforeTheReplyAndDriveTheEncoders) {
  std::atomic<double> clock{5.0};
  std::atomic<double> left{0.0};
  PtyEmulator robots(
      {MotorModel::epuck2}, [&](std::size_t, const core::WheelSpeeds& actual) { left = actual.left; },
      [&] { return clock.load(); });
  Transport line = open(robots, 0);
  exchange(line, test::set_and_read({1000, -500}), 4);
  EXPECT_EQ(left.load(), 1000.0);
  clock = 7.0;
  EXPECT_EQ(exchange(line, test::set_and_read({0, 0}), 4), (Bytes{0xC6, 0x07, 0x1D, 0xFC})) << "10 ms to begin";
  EXPECT_EQ(left.load(), 0.0);
}

TEST(PtyEmulator, HangingUpBreaksTheLineAndTheNameLeadsToANewOne) {
  PtyEmulator robots({MotorModel::epuck2}, nullptr, [] { return 0.0; });
  Transport line = open(robots, 0);
  exchange(line, test::set_and_read({100, 100}), 4);
  robots.hang_up(0);
  std::array<std::uint8_t, 16> bytes;
  EXPECT_TRUE(test::wait_until([&] { return !line.read(bytes); }));
  EXPECT_EQ(robots.wheels(0), (core::WheelSpeeds{100, 100})) << "no watchdog: it drives on";
  Transport again = open(robots, 0);
  EXPECT_EQ(exchange(again, test::bytes("E\n"), 11).size(), 11u);
}

TEST(PtyEmulator, NamesAreMadeInADirectoryAndTakenAwayAgain) {
  const std::string directory = std::filesystem::temp_directory_path() / ("skein-test-" + std::to_string(::getpid()));
  {
    PtyEmulator robots(
        {MotorModel::epuck2, MotorModel::epuck2}, nullptr, [] { return 0.0; }, directory);
    EXPECT_EQ(robots.device(1), directory + "/robot2");
    EXPECT_TRUE(std::filesystem::is_character_file(directory + "/robot2"));
  }
  EXPECT_FALSE(std::filesystem::exists(directory));
  // Somebody's file of that name is not touched.
  std::filesystem::create_directory(directory);
  std::ofstream(directory + "/robot1") << "mine";
  EXPECT_THROW(PtyEmulator(
                   {MotorModel::epuck2}, nullptr, [] { return 0.0; }, directory),
               std::system_error);
  EXPECT_EQ(std::filesystem::file_size(directory + "/robot1"), 4u);
  std::filesystem::remove_all(directory);
}

TEST(PtyEmulator, ADirectoryThatCannotBeIsNamed) {
  try {
    const PtyEmulator emulator(
        {MotorModel::epuck2}, nullptr, [] { return 0.0; }, "/proc/none/robots");
    ADD_FAILURE() << "it cannot be made";
  } catch (const std::system_error& error) {
    EXPECT_EQ(std::string(error.what()), "/proc/none/robots cannot be made: No such file or directory");
  }
}

TEST(Emulate, RunsUntilItIsTold) {
  const std::string directory =
      std::filesystem::temp_directory_path() / ("skein-emulate-" + std::to_string(::getpid()));
  std::promise<int> status;
  std::thread emulation([&] { status.set_value(emulate({.robots = 2, .directory = directory, .verbose = true})); });
  EXPECT_TRUE(test::wait_until([&] { return std::filesystem::exists(directory + "/robot2"); }));
  {
    auto line = Transport::open({LinkKind::serial, directory + "/robot2", 0, ""});
    ASSERT_TRUE(line) << line.error().reason;
    EXPECT_EQ(exchange(*line, test::set_and_read({100, 100}), 4).size(), 4u);
  }
  // emulate() blocks the signal in its thread and waits for it there.
  ::pthread_kill(emulation.native_handle(), SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
  emulation.join();
  EXPECT_EQ(status.get_future().get(), 0);
  EXPECT_FALSE(std::filesystem::exists(directory));
}

TEST(Emulate, RefusesNoRobots) {
  EXPECT_EQ(emulate({.robots = 0}), 2);
}

}  // namespace
}  // namespace skein::comms
