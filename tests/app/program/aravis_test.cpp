// A GigE Vision camera in software, tracked and driven by, through the program itself; and lost in the middle of a run.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/calibration/calibration_file.h"
#include "tests/app/folder.h"
#include "tests/files.h"
#include "tests/places.h"
#include "tests/vision/aravis/fake_gige.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/receive_buffer.h"

namespace {

using namespace skein;
namespace fs = std::filesystem;

constexpr const char* camera = "aravis:127.0.0.1";

/// Whether this machine holds a frame of 1280x960 until it is read: the camera in software sends it at once, where a
/// network would take 10 ms. Root reads it from the network itself.
bool frames_are_whole() {
  long limit = 0;
  std::ifstream(vision::receive_buffer_setting) >> limit;
  return ::geteuid() == 0 || limit >= 1280L * 960;
}

/// A folder with the calibration of the fake camera's pictures, and the program, running in it.
class AravisRun : public testing::Test {
 protected:
  AravisRun() { EXPECT_TRUE(app::save_calibration(vision::overhead_calibration(2.0, 1.5), folder_ / "cal.toml")); }

 public:
  ~AravisRun() override {
    if (pid_ != 0) end(SIGKILL);
  }

 protected:
  void begin(std::vector<std::string> words) {
    words.insert(words.begin(), test::program());
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, file("out").c_str(), O_CREAT | O_WRONLY, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, file("err").c_str(), O_CREAT | O_WRONLY, 0600);
    ASSERT_EQ(posix_spawn(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  int end(int signal) {
    if (signal != 0) ::kill(pid_, signal);
    int status = 0;
    ::waitpid(std::exchange(pid_, 0), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  /// Waits until the file has so many lines; with sanitizers AprilTag takes a second for each picture.
  bool grows(const std::string& name, long lines) const {
    for (int i = 0; i < 3000; ++i) {
      const std::string text = skein::test::read_file(folder_ / name);
      if (std::count(text.begin(), text.end(), '\n') >= lines) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  std::string said() const { return skein::test::read_file(folder_ / "out") + skein::test::read_file(folder_ / "err"); }

 private:
  const test::Folder own_folder_;
  const fs::path folder_ = own_folder_.path;
  pid_t pid_ = 0;
};

/// The rows of a table, behind lines of a comment: from column to text.
std::vector<std::map<std::string, std::string>> rows_of(const std::string& text) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::istringstream in(text);
  std::vector<std::string> header;
  std::vector<std::map<std::string, std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    const std::vector<std::string> cells = split(line);
    if (header.empty()) {
      header = cells;
      continue;
    }
    if (cells.size() != header.size()) continue;  // a comma inside an event, or a torn line
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) row[header[i]] = cells[i];
  }
  return rows;
}

TEST_F(AravisRun, TagsOfANetworkCameraAreTracked) {
  if (!frames_are_whole()) GTEST_SKIP() << "wants: sysctl net.core.rmem_max=33554432";
  test::FakeGige fake({"--tags", "--clock"});
  ASSERT_TRUE(fake.running());
  begin({"track", camera, "--camera", file("cal.toml"), "--rate", "25", "--set", "exposure=0.002", "--csv",
         file("tags.csv")});
  ASSERT_TRUE(grows("tags.csv", 100)) << said();
  EXPECT_EQ(end(SIGINT), 0) << said();
  std::map<int, int> seen;
  for (auto row : rows_of(skein::test::read_file(file("tags.csv")))) {
    if (row["theta"].empty()) continue;  // torn by the signal, or cut by the border
    const int tag = std::stoi(row["tag"]);
    for (const vision::SyntheticTag& there : test::fake_gige_tags())
      if (there.tag == tag) {
        ++seen[tag];
        EXPECT_NEAR(std::stod(row["x"]), there.pose.x, 0.001) << tag;
        EXPECT_NEAR(std::stod(row["y"]), there.pose.y, 0.001) << tag;
        EXPECT_NEAR(std::stod(row["theta"]), there.pose.theta, 0.01) << tag;
      }
  }
  ASSERT_EQ(seen.size(), 4U) << said();
  for (const auto& [tag, times] : seen) EXPECT_GT(times, 20) << tag;
  EXPECT_NE(said().find("camera aravis:127.0.0.1 (1280x960 Mono8, 25 frames/s)"), std::string::npos) << said();
}

TEST_F(AravisRun, ACameraThatIsLostEndsTheRunAndTheOperatorIsToldWhy) {
  if (!frames_are_whole()) GTEST_SKIP() << "wants: sysctl net.core.rmem_max=33554432";
  test::FakeGige fake({"--tags"});
  ASSERT_TRUE(fake.running());
  begin({"run", test::in_source("resources/experiments/platoon.toml"), "--set", std::string("camera.source=") + camera,
         "--set", "camera.calibration=" + file("cal.toml"), "--set", "perturb=[]", "--set", "expect={}", "--set",
         "duration=60", "--csv", file("run.csv")});
  ASSERT_TRUE(grows("run.csv", 150)) << said();
  EXPECT_THAT(said(), testing::HasSubstr("aravis:127.0.0.1: its clock cannot be read"))
      << "what the camera does not do is told while the run goes on";
  fake.kill();
  const test::PortLock nobody_comes_back;
  EXPECT_EQ(end(0), 3) << said();
  // A quarter of a second, or three frames of a camera that is slower, as this one is on a starved machine.
  EXPECT_THAT(said(), testing::ContainsRegex(
                          R"(aravis:127\.0\.0\.1: no frame for 0\.[0-9]+ s \(unplugged, or the network is full\?\))"));
  // From the bridge time on after the last pose everybody stands, long before the camera is given up.
  const auto rows = rows_of(skein::test::read_file(file("run.csv")));
  ASSERT_GT(rows.size(), 250U);
  for (std::size_t i = rows.size() - 200; i < rows.size(); ++i)
    for (const char* robot : {"r1", "r2", "r3", "r4"}) {
      EXPECT_EQ(std::stod(rows[i].at(robot + std::string("_wheel_left"))), 0.0) << i;
      EXPECT_EQ(std::stod(rows[i].at(robot + std::string("_wheel_right"))), 0.0) << i;
    }
}

TEST_F(AravisRun, CamerasAreListed) {
  test::FakeGige fake({"--clock"});
  ASSERT_TRUE(fake.running());
  begin({"camera", "list"});
  EXPECT_EQ(end(0), 0);
  EXPECT_NE(said().find("aravis:Aravis-Fake-SKEIN1: Aravis Fake (GigEVision, 127.0.0.1)\n"), std::string::npos)
      << said();
  begin({"camera", "list", "aravis:Aravis-Fake-SKEIN1"});
  EXPECT_EQ(end(0), 0);
  EXPECT_NE(said().find("\nclock: TimestampLatch\n"), std::string::npos) << said();
}

}  // namespace
