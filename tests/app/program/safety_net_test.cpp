// A program that dies: by a signal in any of its threads, killed, or in good order. Its robots stand.
#include "app/guard/safety_net.h"
#include "app/guard/robot_addresses.h"
#include "app/guard/run_marker.h"
#include "app/guard/stop_run.h"
#include "app/guard/stop_socket.h"
#include "app/run/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <stop_token>
#include <string_view>
#include <thread>

#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/memory_lock.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/emulator/tcp_epuck.h"
#include "comms/link_supervisor.h"
#include "tests/eventually.h"
#include "tests/places.h"
#include "tests/seconds.h"

extern char** environ;

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using core::WheelSpeeds;

using test::eventually;
using test::seconds;

class DyingProgram : public testing::Test {
 protected:
  void SetUp() override {
    const fs::path state = fs::temp_directory_path() / ("skein-state-" + std::to_string(::getpid()));
    fs::remove_all(state);
    ::setenv("XDG_STATE_HOME", state.c_str(), 1);
    state_ = state;
    // The leak checker waits for ever for a process that is continued while it ends.
    ::setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
  }
  void TearDown() override {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    // Guards whose robots go with this test would try for ever.
    testing::internal::CaptureStdout();
    forget_runs();
    testing::internal::GetCapturedStdout();
    EXPECT_TRUE(eventually([this] { return guards() == 0; })) << "a guard goes on after its robots have been forgotten";
    fs::remove_all(state_);
  }
  /// The marker of a run that has ended badly; it drove the first robot.
  RunMarker leave_behind() {
    RunMarker marker{{}, "gone", {comms::parse_link_address("serial:" + ptys.device(0)).value()}};
    const auto written = write_marker(marker);
    EXPECT_TRUE(written) << written.error();
    if (written) ::close(written->lock);
    return marker;
  }
  /// A shell script that stands in for the program of a guard.
  std::string script(const std::string& text) const {
    const fs::path path = state_ / "script";
    fs::create_directories(state_);
    std::ofstream(path) << "#!/bin/sh\n" << text;
    fs::permissions(path, fs::perms::owner_all);
    return path;
  }
  /// The guards of this test's runs.
  std::vector<pid_t> all_guards() const {
    std::vector<pid_t> all;
    std::error_code gone;
    for (const auto& process : fs::directory_iterator("/proc", gone)) {
      std::string name, first;
      std::getline(std::ifstream(process.path() / "comm"), name);
      std::getline(std::ifstream(process.path() / "environ"), first, '\0');
      if (name == guard_name && first.starts_with(fmt::format("{}={}/", marker_variable, state_.string())))
        all.push_back(std::stoi(process.path().filename()));
    }
    return all;
  }
  std::size_t guards() const { return all_guards().size(); }
  pid_t guard() const {
    EXPECT_TRUE(eventually([this] { return guards() == 1; }));
    return all_guards().at(0);
  }

  /// Starts the victim and waits until all robots drive.
  void start(const std::string& guard) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&files, ends[0]);
    posix_spawn_file_actions_addclose(&files, ends[1]);
    std::vector<std::string> words{test::victim(), guard, "serial:" + ptys.device(0), "serial:" + ptys.device(1),
                                   "tcp:127.0.0.1:" + std::to_string(wifi.port())};
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ASSERT_EQ(::posix_spawn(&pid_, test::victim().c_str(), &files, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&files);
    ::close(ends[1]);
    char said = 0;
    ASSERT_EQ(::read(ends[0], &said, 1), 1) << "the victim said nothing";
    ::close(ends[0]);
    ASSERT_TRUE(eventually([this] { return drive(); }));
  }
  bool drive() const { return ptys.wheels(0).left > 0 && ptys.wheels(1).left > 0 && wifi.wheels().left > 0; }
  bool stand() const {
    return ptys.wheels(0) == WheelSpeeds{} && ptys.wheels(1) == WheelSpeeds{} && wifi.wheels() == WheelSpeeds{};
  }
  std::vector<pid_t> threads() const {
    std::vector<pid_t> all;
    for (const auto& entry : fs::directory_iterator("/proc/" + std::to_string(pid_) + "/task"))
      all.push_back(std::stoi(entry.path().filename()));
    return all;
  }
  bool markers() const { return fs::exists(state_ / "skein") && !fs::is_empty(state_ / "skein"); }
  int wait_for_the_end() {
    int status = 0;
    ::waitpid(std::exchange(pid_, -1), &status, 0);
    return status;
  }

  comms::PtyEmulator ptys{{core::MotorModel::epuck1, core::MotorModel::epuck2}, nullptr, seconds};
  comms::TcpEpuck wifi{seconds};
  pid_t pid_ = -1;
  fs::path state_;
};

TEST_F(DyingProgram, ACrashInAnyThreadStopsTheRobotsFirst) {
  for (std::size_t thread = 0; thread < 2; ++thread)
    for (const int signal : {SIGSEGV, SIGABRT}) {
      start("-");
      if (HasFatalFailure()) return;
      std::vector<pid_t> ids = threads();
      ASSERT_GE(ids.size(), 2u);
      // The first is the main thread, the last the links'; a sanitizer's own, which takes no signals, is between them.
      std::sort(ids.begin(), ids.end());
      const double crashed = seconds();
      ::syscall(SYS_tgkill, pid_, thread == 0 ? ids.front() : ids.back(), signal);
      EXPECT_TRUE(eventually([this] { return stand(); })) << "thread " << thread << ", signal " << signal;
      RecordProperty("stop_ms_" + std::to_string(thread) + "_" + std::to_string(signal),
                     static_cast<int>(1e3 * (seconds() - crashed)));
      std::printf("thread %zu, signal %d: all robots stand after %.1f ms\n", thread, signal,
                  1e3 * (seconds() - crashed));
      EXPECT_NE(wait_for_the_end(), 0);
      EXPECT_TRUE(stand());
    }
}

/// The links' thread, which would repeat the stop, is the one that crashed.
TEST_F(DyingProgram, ACrashStopsARobotThatDidNotHearTheFirstStop) {
  start("-");
  if (HasFatalFailure()) return;
  const std::vector<pid_t> ids = threads();
  ptys.silence(0, true);
  ::syscall(SYS_tgkill, pid_, *std::max_element(ids.begin(), ids.end()), SIGSEGV);
  ASSERT_TRUE(eventually([this] { return ptys.wheels(1) == WheelSpeeds{}; })) << "the first stop";
  EXPECT_GT(ptys.wheels(0).left, 0);
  ptys.silence(0, false);
  EXPECT_TRUE(eventually([this] { return stand(); }));
  wait_for_the_end();
}

TEST_F(DyingProgram, WhenItIsKilledTheGuardStopsTheRobots) {
  start(test::program());
  if (HasFatalFailure()) return;
  EXPECT_TRUE(markers());
  EXPECT_TRUE(bad_ends().empty()) << "it lives";
  ::kill(pid_, SIGKILL);
  wait_for_the_end();
  EXPECT_TRUE(eventually([this] { return stand(); }));
  EXPECT_TRUE(eventually([this] { return !markers(); })) << "and nothing is left to say";
}

/// When it is needed, the disk that its program is on may stall.
TEST_F(DyingProgram, ItsGuardIsKeptInMemory) {
  if (memory_lock_limit() >= 0) GTEST_SKIP() << MemoryLock().refused();
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer passes no request for a lock on to the kernel";
#endif
  start(test::program());
  if (HasFatalFailure()) return;
  const auto locked = [this] {
    std::ifstream status("/proc/" + std::to_string(guard()) + "/status");
    for (std::string word; status >> word;)
      if (word == "VmLck:" && status >> word) return std::stol(word);  // [kB]
    return 0L;
  };
  EXPECT_TRUE(eventually([&] { return locked() > 1000; })) << locked() << " kB";
}

TEST_F(DyingProgram, WithoutAGuardTheNextStartKnowsOfItAndStopsThem) {
  start("/bin/true");
  if (HasFatalFailure()) return;
  ::kill(pid_, SIGKILL);
  wait_for_the_end();
  EXPECT_TRUE(drive()) << "robots have no watchdog";
  const std::vector<RunMarker> ends = bad_ends();
  ASSERT_EQ(ends.size(), 1u);
  EXPECT_EQ(ends[0].experiment, "victim");
  EXPECT_EQ(ends[0].robots.size(), 3u);
  testing::internal::CaptureStderr();
  look_after_bad_ends();
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("\"victim\" ended badly"), std::string::npos) << said;
  EXPECT_NE(said.find("serial:" + ptys.device(1)), std::string::npos) << said;
  testing::internal::CaptureStdout();
  EXPECT_EQ(stop_robots({}), done);
  EXPECT_NE(testing::internal::GetCapturedStdout().find("stopped"), std::string::npos);
  EXPECT_TRUE(stand());
  EXPECT_TRUE(bad_ends().empty());
}

TEST_F(DyingProgram, AGoodEndLeavesNothingBehind) {
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  auto net = SafetyNet::spread({"good", robots, test::program()});
  ASSERT_TRUE(net) << net.error();
  EXPECT_TRUE(markers());
  net->done({{comms::to_text(robots[0]), true}});
  EXPECT_FALSE(markers());
}

TEST_F(DyingProgram, ARobotThatIsNotKnownToStandIsLeftToTheGuard) {
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  {
    comms::LinkSupervisor link(robots, {.command_silence = 0.0, .close_timeout = 0.0});
    ASSERT_TRUE(link.start(10.0));
    link.command(0, 200, 200);
    ASSERT_TRUE(link.wait_acknowledged(10.0));
    ptys.silence(0, true);
  }
  ptys.silence(0, false);
  ASSERT_NE(ptys.wheels(0), WheelSpeeds{});
  auto net = SafetyNet::spread({"bad", robots, test::program()});
  ASSERT_TRUE(net) << net.error();
  net->done({{comms::to_text(robots[0]), false, "no answer"}});
  EXPECT_TRUE(eventually([this] { return ptys.wheels(0) == WheelSpeeds{} && !markers(); }));
}

TEST_F(DyingProgram, WhenItIsFrozenTheGuardStopsTheRobotsOnTheirOwnLines) {
  start(test::program());
  if (HasFatalFailure()) return;
  const double frozen = seconds();
  ::kill(pid_, SIGSTOP);
  EXPECT_TRUE(eventually([this] { return stand(); }));
  std::printf("all robots stand %.1f ms after SIGSTOP\n", 1e3 * (seconds() - frozen));
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  ::kill(pid_, SIGCONT);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_TRUE(stand()) << "nobody drives on by itself";
}

TEST_F(DyingProgram, AGuardThatDiesIsNoticedAndThereIsANewOne) {
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  auto net = SafetyNet::spread({"guarded", robots, test::program()});
  ASSERT_TRUE(net) << net.error();
  ASSERT_TRUE(eventually([&] { return net->guard_process() > 0; }));
  const pid_t first = net->guard_process();
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // one that dies at once is not started again at once
  ::kill(first, SIGKILL);
  EXPECT_TRUE(eventually([&] { return net->guard_process() > 0 && net->guard_process() != first; }));
  std::vector<std::string> alarms;  // said once the new guard is there
  ASSERT_TRUE(eventually([&] { return !(alarms = net->alarms()).empty(); }));
  EXPECT_NE(alarms[0].find("the guard has died"), std::string::npos) << alarms[0];
  net->done({{comms::to_text(robots[0]), true}});
}

/// As on a disk that stalls.
TEST_F(DyingProgram, AGuardThatDoesNotBeginIsReplaced) {
  const std::string stalls = script("exec sleep 1000\n");
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  auto net = SafetyNet::spread({"guarded", robots, stalls, 2.0});
  ASSERT_TRUE(net) << net.error();
  fs::remove(stalls);
  fs::create_symlink(test::program(), stalls);
  std::vector<std::string> alarms;
  ASSERT_TRUE(eventually([&] { return !(alarms = net->alarms()).empty(); }));
  EXPECT_EQ(alarms[0], "the guard has not begun within 2 s: a new guard has been started");
  EXPECT_TRUE(eventually([&] { return net->guard_process() > 0; }));
  net->done({{comms::to_text(robots[0]), true}});
}

/// Its process may be out of reach until then, as one that waits for a disk.
TEST_F(DyingProgram, AGuardThatBeginsAfterItWasReplacedStopsNoRobot) {
  const fs::path here = state_ / "here";
  const std::string late = script(
      fmt::format("exec 3<&0\nsh -c 'sleep 2.5; echo $$ > {}; exec {} guard <&3' &\n", here.string(), test::program()));
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  auto net = SafetyNet::spread({"guarded", robots, late, 0.5});
  ASSERT_TRUE(net) << net.error();
  fs::remove(late);
  fs::create_symlink(test::program(), late);
  comms::LinkSupervisor link(robots, {.command_silence = 0.0});
  ASSERT_TRUE(link.start(10.0));
  link.command(0, 200, 200);
  ASSERT_TRUE(link.wait_acknowledged(10.0));
  int process = 0;
  ASSERT_TRUE(eventually([&] { return bool(std::ifstream(here) >> process); }));
  EXPECT_TRUE(eventually([&] { return ::kill(process, 0) != 0; })) << "the late guard goes on";
  EXPECT_GT(net->guard_process(), 0) << "there is another";
  EXPECT_GT(ptys.wheels(0).left, 0) << "the run lives";
  link.emergency_stop();
  EXPECT_TRUE(eventually([&] { return ptys.wheels(0) == WheelSpeeds{}; }));
  net->done({{comms::to_text(robots[0]), true}});
}

/// Before that, a kill of the run's process tree takes the guard with it.
TEST_F(DyingProgram, NoLineIsOpenedBeforeTheGuardHasBegun) {
  const std::string late = script(fmt::format("sleep 0.3\nexec '{}' guard\n", test::program()));
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  auto net = SafetyNet::spread({"guarded", robots, late});
  ASSERT_TRUE(net) << net.error();
  EXPECT_GT(net->guard_process(), 0);
  net->done({{comms::to_text(robots[0]), true}});
}

TEST_F(DyingProgram, WhoeverEndsItsProcessTreeOrAllThatIsCalledSkeinSparesTheGuard) {
  start(test::program());
  if (HasFatalFailure()) return;
  const fs::path process = "/proc/" + std::to_string(guard());
  std::ostringstream status, words;
  status << std::ifstream(process / "status").rdbuf();
  words << std::ifstream(process / "cmdline").rdbuf();
  EXPECT_EQ(status.str().find("\nPPid:\t" + std::to_string(pid_) + "\n"), std::string::npos) << "a child of the run";
  EXPECT_EQ(words.str(), std::string("robot-guard\0guard\0", 18));
}

TEST_F(DyingProgram, StopFromOutsideReachesARunThroughItsSocket) {
  start(test::program());
  if (HasFatalFailure()) return;
  testing::internal::CaptureStdout();
  EXPECT_EQ(stop_runs(), done);
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_TRUE(stand());
  EXPECT_NE(said.find("serial:" + ptys.device(0) + ": stopped"), std::string::npos) << said;
}

TEST_F(DyingProgram, ARunThatDoesNotRespondToStopIsAFailure) {
  const RunMarker marker = leave_behind();
  const auto nobody_answers = StopSocket::listen(marker.socket());
  ASSERT_TRUE(nobody_answers) << nobody_answers.error();
  testing::internal::CaptureStderr();
  EXPECT_EQ(stop_runs(), device_failed);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "skein: the run \"gone\" does not respond to STOP: `skein robots stop` ends it\n");
  marker.forget();
}

TEST_F(DyingProgram, ARunWhoseMarkerCannotBeReadMayDriveOn) {
  fs::create_directories(state_ / "skein");
  fs::permissions(state_ / "skein", fs::perms::owner_all);
  const auto unreadable =
      StopSocket::listen((state_ / "skein" / "run-odd").string());  // a socket, which not even root opens
  ASSERT_TRUE(unreadable) << unreadable.error();
  testing::internal::CaptureStderr();
  EXPECT_EQ(stop_runs(), device_failed);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("run-odd: cannot be read: "), std::string::npos) << said;
  EXPECT_NE(said.find("a run that is not found here is not stopped"), std::string::npos) << said;
}

TEST_F(DyingProgram, ARunWhoseRobotIsNotKnownToStandIsNotForgotten) {
  RunMarker marker{{}, "gone", {{comms::LinkKind::serial, "/nowhere"}}};
  const auto written = write_marker(marker);
  ASSERT_TRUE(written) << written.error();
  ::close(written->lock);
  testing::internal::CaptureStderr();
  EXPECT_EQ(stop_robots({}), device_failed);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("serial:/nowhere: NOT known to be stopped"), std::string::npos) << said;
  EXPECT_EQ(bad_ends().size(), 1u) << "the next start knows of it";
  testing::internal::CaptureStderr();
  EXPECT_FALSE(stop_left_behind(bad_ends())) << "as the window stops them";
  testing::internal::GetCapturedStderr();
  EXPECT_EQ(bad_ends().size(), 1u);
}

/// Robots are stopped on their own lines, which a guard that is stuck might hold.
TEST_F(DyingProgram, AGuardThatDoesNotRespondIsEnded) {
  const RunMarker marker = leave_behind();
  std::string shell = "sh", option = "-c", loop = "while :; do sleep 0.1; done";
  std::string variable = fmt::format("{}={}", marker_variable, marker.path), path = "PATH=/usr/bin:/bin";
  char* const words[] = {shell.data(), option.data(), loop.data(), nullptr};
  char* const environment[] = {variable.data(), path.data(), nullptr};
  ASSERT_EQ(::posix_spawn(&pid_, "/bin/sh", nullptr, nullptr, words, environment), 0);
  testing::internal::CaptureStderr();
  EXPECT_TRUE(stop_run(marker).by_hand);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("the guard of the run \"gone\" does not respond: ending it"), std::string::npos) << said;
  EXPECT_TRUE(eventually([this] { return ::waitpid(pid_, nullptr, WNOHANG) == pid_; }, std::chrono::seconds(10)));
  marker.forget();
}

TEST_F(DyingProgram, AMarkerWithADamagedLineNamesTheOtherRobots) {
  fs::create_directories(state_ / "skein");
  const fs::path path = state_ / "skein" / "run-damaged";
  std::ofstream(path) << "skein run damaged\nnonsense\t\t\nserial:/dev/a\t\t\n";
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  const std::vector<RunMarker> found = all_markers();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].names(), "serial:/dev/a");
}

TEST_F(DyingProgram, RobotsStopReachesARunThatIsFrozen) {
  start(test::program());
  if (HasFatalFailure()) return;
  ::kill(pid_, SIGSTOP);
  testing::internal::CaptureStdout();
  EXPECT_EQ(stop_robots({}), done);
  EXPECT_NE(testing::internal::GetCapturedStdout().find("stopped"), std::string::npos);
  EXPECT_TRUE(stand());
  EXPECT_EQ(wait_for_the_end(), SIGKILL) << "SIGTERM does not reach it";
}

TEST_F(DyingProgram, RobotsStopReachesARunThatIsFrozenWithItsGuard) {
  start(test::program());
  if (HasFatalFailure()) return;
  const std::vector<pid_t> both{guard(), pid_};
  for (const pid_t process : both) ::kill(process, SIGSTOP);
  testing::internal::CaptureStdout();
  EXPECT_EQ(stop_robots({}), done);
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_TRUE(stand()) << said;
  for (const pid_t process : both) ::kill(process, SIGCONT);  // where it failed
}

// A guard that says three times that it has not reached a robot.
TEST_F(DyingProgram, RobotsStopGoesOnUntilTheGuardHasReachedARobot) {
  const RunMarker marker = leave_behind();
  auto socket = StopSocket::listen(marker.socket());
  ASSERT_TRUE(socket) << socket.error();
  int asked = 0;
  std::jthread guard([&](const std::stop_token& token) {
    while (!token.stop_requested()) {
      pollfd caller{socket->descriptor(), POLLIN, 0};
      ::poll(&caller, 1, 10);
      socket->turn([&](std::string_view) { ++asked; },
                   [&] {
                     return std::vector<StopResult>{{comms::to_text(marker.robots[0]), asked > 3, "not reached yet"}};
                   },
                   /*last=*/true);
    }
  });
  const StoppedRun stopped = stop_run(marker);
  guard.request_stop();
  guard.join();
  EXPECT_EQ(asked, 4);
  EXPECT_FALSE(stopped.by_hand);
  ASSERT_EQ(stopped.robots.size(), 1u);
  EXPECT_TRUE(stopped.robots[0].stopped) << stopped.robots[0].reason;
  marker.forget();
}

TEST_F(DyingProgram, RobotsStopSaysWhomItWaitsForWhileTheGuardTries) {
  const RunMarker marker = leave_behind();
  auto socket = StopSocket::listen(marker.socket());
  ASSERT_TRUE(socket) << socket.error();
  const double enough = seconds() + 1.5 * std::chrono::duration<double>(silent_for).count();
  std::jthread guard([&](const std::stop_token& token) {
    while (!token.stop_requested()) {
      pollfd caller{socket->descriptor(), POLLIN, 0};
      ::poll(&caller, 1, 10);
      const bool stands = seconds() > enough;
      socket->turn([](std::string_view) {},
                   [&] {
                     return std::vector<StopResult>{{comms::to_text(marker.robots[0]), stands, "out of reach"}};
                   },
                   /*last=*/true);
    }
  });
  testing::internal::CaptureStderr();
  EXPECT_TRUE(all_stand(stop_run(marker).robots));
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "skein: " + comms::to_text(marker.robots[0]) + ": not stopped yet: out of reach; still trying\n");
  marker.forget();
}

/// Whoever wants robots to stop must not wonder for 15 s what the program does.
TEST_F(DyingProgram, StoppingARobotSaysWhatItWaitsForAfterASecond) {
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  int said = 0;
  EXPECT_EQ(stop_one(robots, 0, [&](const std::string&) { ++said; }), "");
  EXPECT_EQ(said, 0) << "it is quick";
  const int line = ::open(ptys.device(0).c_str(), O_RDWR | O_NOCTTY);
  ASSERT_EQ(::flock(line, LOCK_EX), 0);
  const auto failure = stop_one(robots, 0, [&](const std::string& reason) {
    ++said;
    EXPECT_EQ(reason, "another program is using the device");
    ::close(line);
  });
  EXPECT_EQ(failure, "") << "and it goes on trying";
  EXPECT_EQ(said, 1);
}

// The window would open 5 s later for each such run.
TEST_F(DyingProgram, TheNextStartDoesNotWaitForAGuardThatKeepsTrying) {
  const RunMarker marker = leave_behind();
  auto socket = StopSocket::listen(marker.socket());
  ASSERT_TRUE(socket) << socket.error();
  testing::internal::CaptureStderr();
  look_after_bad_ends();
  EXPECT_NE(testing::internal::GetCapturedStderr().find("its guard keeps trying"), std::string::npos);
  int asked = 0;
  socket->turn([&](std::string_view) { ++asked; }, [] { return std::vector<StopResult>(1); });
  EXPECT_EQ(asked, 0) << "it waits for an answer";
  EXPECT_FALSE(socket->waits());
  marker.forget();
}

TEST_F(DyingProgram, MarkersHaveNamesThatAreNeverUsedTwice) {
  const std::vector<comms::LinkAddress> robots{comms::parse_link_address("serial:" + ptys.device(0)).value()};
  {
    const auto one = SafetyNet::spread({"one", robots, "/bin/true"}),
               two = SafetyNet::spread({"two", robots, "/bin/true"});
    ASSERT_TRUE(one && two);
    EXPECT_EQ(all_markers().size(), 2u) << "of one process";
    EXPECT_TRUE(bad_ends().empty());
  }
  // A guard that was forked holds the marker's lock as well until it has become the program that it is told to be.
  EXPECT_TRUE(eventually([] { return bad_ends().size() == 2u; })) << bad_ends().size();
}

TEST_F(DyingProgram, AMarkerOfAnotherUserIsNotBelieved) {
  fs::create_directories(state_ / "skein");
  const fs::path marker = state_ / "skein" / "run-planted";
  std::ofstream(marker) << "skein run planted\nserial:/dev/null\t\t\n";
  fs::permissions(marker, fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(all_markers().size(), 1u) << "the control";
  fs::permissions(marker, fs::perms::others_write, fs::perm_options::add);
  EXPECT_TRUE(all_markers().empty());
  fs::permissions(state_ / "skein", fs::perms::others_write, fs::perm_options::add);
  EXPECT_NE(state_directory(), (state_ / "skein").string());
}

TEST_F(DyingProgram, RobotsAreFoundInAFileWithMistakes) {
  fs::create_directories(state_);
  const std::string path = (state_ / "robots.toml").string();
  std::ofstream(path) << "[[robot]\nname = \"a\"\nlink = \"rfcomm:10:00:E8:AA:BB:CC/1\"\nadapter = \"hci1\"\n"
                         "[[robot]]\nlink = \"serial:/dev/ttyACM0\"\n";
  const RobotAddresses found = robot_addresses(path);
  ASSERT_EQ(found.robots.size(), 2u);
  EXPECT_EQ(found.robots[0].adapter, "hci1");
  EXPECT_EQ(found.robots[1].adapter, "");
  EXPECT_EQ(found.problems.size(), 1u) << "and the mistake is told";
}

/// What a run of this experiment connects to is what `robots stop` connects to, adapters included: over another adapter
/// a robot may be out of reach.
TEST_F(DyingProgram, RobotsOfAFileAreReachedAsItsRunReachesThem) {
  fs::create_directories(state_);
  std::ofstream(state_ / "robots.toml")
      << "[[robot]]\nname = \"anna\"\nlink = \"rfcomm:10:00:E8:AA:BB:CC/1\"\nadapter = "
         "\"hci3\"\n[[robot]]\nname = \"bert\"\nlink = \"rfcomm:10:00:E8:AA:BB:CD/2\"\n";
  const std::string file = R"(robots_file = "robots.toml"
[robot_defaults]
adapter = "hci1"
[[robot]]
link = "rfcomm:10:00:E8:AA:BB:01/1"
[[robot]]
link = "rfcomm:10:00:E8:AA:BB:02/1"
adapter = "hci2"
[[robot]]
name = "anna"
[[robot]]
name = "bert"
[camera]
source = "images:pictures"
calibration = "camera.toml"
)";
  const std::string path = (state_ / "experiment.toml").string(), damaged = (state_ / "damaged.toml").string();
  std::ofstream(path) << file;
  const auto experiment = load({path, {}});
  ASSERT_TRUE(experiment);
  const auto run = real_robots(*experiment);
  ASSERT_TRUE(run) << run.error();
  const RobotAddresses found = robot_addresses(path);
  EXPECT_TRUE(found.problems.empty());
  ASSERT_EQ(found.robots.size(), run->size());
  for (std::size_t i = 0; i < run->size(); ++i) {
    EXPECT_EQ(comms::to_text(found.robots[i]), comms::to_text((*run)[i])) << i;
    EXPECT_EQ(found.robots[i].adapter, (*run)[i].adapter) << i;
  }
  std::ofstream(damaged) << file << "[[robot\n";
  const RobotAddresses rest = robot_addresses(damaged);
  ASSERT_EQ(rest.robots.size(), 2u);
  EXPECT_EQ(rest.robots[0].adapter, "hci1");
  EXPECT_EQ(rest.robots[1].adapter, "hci2");
}

TEST(Output, NeitherThrowsNorWaitsForAReaderThatDoesNotRead) {
  std::signal(SIGPIPE, SIG_IGN);  // as catch_interrupts() does in the program
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const int kept = ::dup(STDERR_FILENO);
  ::dup2(ends[1], STDERR_FILENO);
  const double began = seconds();
  for (int k = 0; k < 1000; ++k) complain(std::string(1000, 'x'));  // a pipe holds 64 kB
  const double took = seconds() - began;
  std::array<char, 65536> read;
  while (took < 60.0 && ::read(ends[0], read.data(), read.size()) == static_cast<ssize_t>(read.size())) {
  }
  ::dup2(kept, STDERR_FILENO);
  for (const int descriptor : {kept, ends[0], ends[1]}) ::close(descriptor);
  EXPECT_LT(took, 30.0) << "a thousand short waits are a long one";
}

TEST(Output, TheLastWordsAreWrittenThoughTheReaderIsLate) {
  std::signal(SIGPIPE, SIG_IGN);
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const int kept = ::dup(STDERR_FILENO);
  ::dup2(ends[1], STDERR_FILENO);
  std::string read;
  std::promise<void> ended;
  std::thread reader;
  exit_status_of([&] {
    for (int k = 0; k < 2; ++k) complain(std::string(60'000, 'x'));  // a pipe holds 64 kB
    complain("the reason");
    reader = std::thread([&] {  // as late as that, or once it would be too late
      ended.get_future().wait_for(std::chrono::milliseconds(500));
      std::array<char, 4096> some;
      for (ssize_t count = 0; (count = ::read(ends[0], some.data(), some.size())) > 0;)
        read.append(some.data(), static_cast<std::size_t>(count));
    });
    return 3;
  });
  ::dup2(kept, STDERR_FILENO);
  ::close(kept);
  ::close(ends[1]);
  ended.set_value();
  reader.join();
  ::close(ends[0]);
  EXPECT_NE(read.find("the reason"), std::string::npos) << read.size() << " bytes";
}

TEST_F(DyingProgram, WhereTheMarkerCannotBeWrittenTheReasonIsSaid) {
  ::setenv("XDG_STATE_HOME", "/proc/nowhere", 1);
  EXPECT_TRUE(all_markers().empty());
  auto net = SafetyNet::spread({"x", {{comms::LinkKind::serial, "/dev/a"}}, test::program()});
  ASSERT_TRUE(net) << net.error();
  const std::vector<std::string> alarms = net->alarms();
  ASSERT_EQ(alarms.size(), 1u);
  EXPECT_NE(alarms[0].find("/proc/nowhere/skein/run-"), std::string::npos) << alarms[0];
  EXPECT_TRUE(eventually([&] { return net->guard_process() > 0; })) << "it is guarded all the same";
  EXPECT_EQ(all_markers().size(), 1u) << "and found by the next start";
  ::setenv("XDG_STATE_HOME", state_.c_str(), 1);
  EXPECT_TRUE(all_markers().empty()) << "of whoever has the same state directory";
  ::setenv("XDG_STATE_HOME", "/proc/nowhere", 1);
  net->done({{"serial:/dev/a", true}});
  EXPECT_TRUE(all_markers().empty());
}

TEST_F(DyingProgram, AGuardIsForgottenAlsoWhileItStopsTheRobotsOnTheirLines) {
  start(test::program());
  if (HasFatalFailure()) return;
  ptys.silence(0, true);  // it will never acknowledge
  ::kill(pid_, SIGKILL);
  wait_for_the_end();
  testing::internal::CaptureStdout();
  EXPECT_EQ(forget_runs(), done);
  testing::internal::GetCapturedStdout();
  EXPECT_TRUE(eventually([this] { return guards() == 0; }));
}

}  // namespace
}  // namespace skein::app
