// The timing certificate of a run.
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <thread>

#include "app/experiment/experiment_file.h"
#include "app/run/timing.h"
#include "app/session/bare_thread.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/folder.h"

namespace skein::app {
namespace {

Experiment a_second() {
  Experiment experiment = paper_experiment();
  experiment.duration = 1.0;
  experiment.perturbations.clear();
  return experiment;
}

TEST(Timing, EveryRunInRealTimeHasACertificate) {
  auto session = Session::open(a_second(), Session::Clock::wall);
  ASSERT_TRUE(session);
  (*session)->run();
  EXPECT_FALSE((*session)->timing()) << "not before the end";
  (*session)->close();
  const auto timing = (*session)->timing();
  ASSERT_TRUE(timing);
  EXPECT_GE(timing->tick.total(), 10u);
  EXPECT_GE(timing->bare.total(), 10u);
  EXPECT_GT(timing->tick.largest(), 0.0);
  EXPECT_GT(timing->bare.largest(), 0.0);
  EXPECT_EQ(timing->priority > 0, timing->no_priority.empty()) << "no priority without a reason";
}

TEST(Timing, VirtualTimeHasNone) {
  auto session = Session::open(a_second(), Session::Clock::virtual_);
  ASSERT_TRUE(session);
  (*session)->run();
  (*session)->close();
  EXPECT_FALSE((*session)->timing());
}

TEST(Timing, ABareThreadWakesAtEveryDeadlineAndEnds) {
  const auto began = std::chrono::steady_clock::now();
  BareThread thread(0.01, 0);
  EXPECT_EQ(thread.priority(), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const Histogram late = thread.end();
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began;
  EXPECT_GE(late.total(), 3u);
  EXPECT_LE(static_cast<double>(late.total()), passed.count() / 0.01 + 1.0);
}

TEST(Timing, ARunThatDrivesRobotsAsksThatProcessorsWakeFast) {
  Experiment experiment = a_second();
  for (RobotSpec& robot : experiment.robots) robot.link = RobotSpec::Link::loopback;
  auto session = Session::open(experiment, Session::Clock::wall);
  ASSERT_TRUE(session) << session.error();
  (*session)->run();
  (*session)->close();
  const auto timing = (*session)->timing();
  ASSERT_TRUE(timing);
  EXPECT_EQ(timing->cpu_latency.has_value(), timing->no_cpu_latency.empty()) << "no limit without a reason";
  EXPECT_EQ(timing->memory_locked, timing->no_memory_lock.empty()) << "no lock without a reason";
}

/// The real-time priorities of this process' threads.
std::multiset<int> priorities() {
  std::multiset<int> all;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    const pid_t thread = std::stoi(task.path().filename());
    sched_param parameters{};
    if ((::sched_getscheduler(thread) & ~SCHED_RESET_ON_FORK) == SCHED_FIFO &&
        ::sched_getparam(thread, &parameters) == 0)
      all.insert(parameters.sched_priority);
  }
  return all;
}

/// Other programs that keep all processors busy must not delay the poses that a tick waits for.
TEST(Timing, PosesAreMadeAtAPriorityOfTheirOwnBelowTheTicks) {
  auto session = Session::open(good(paper_experiment().source, {"camera.source=synthetic", "duration=1", "perturb=[]"}),
                               Session::Clock::wall);
  ASSERT_TRUE(session) << session.error();
  std::multiset<int> meanwhile;
  (*session)->run([&] {
    if (meanwhile.count(control_priority) == 0 || meanwhile.count(camera_priority) == 0) meanwhile = priorities();
    return true;
  });
  (*session)->close();
  if ((*session)->timing()->priority == 0) GTEST_SKIP() << (*session)->timing()->no_priority;
  EXPECT_EQ(meanwhile.count(camera_priority), 1u) << "one camera";
  EXPECT_GE(meanwhile.count(control_priority), 1u);
  EXPECT_LT(camera_priority, control_priority);
}

/// Files in the place of the kernel's.
class CpuLatency : public testing::Test {
 protected:
  void kernel_has(const std::string& idle_driver) {
    const std::ofstream empty(device);
    std::ofstream{driver} << idle_driver << '\n';
  }
  /// What was written to the device; none: nothing, or something else.
  std::optional<std::int32_t> written() {
    std::ifstream file(device, std::ios::binary);
    std::int32_t value = 0;
    if (!file.read(reinterpret_cast<char*>(&value), sizeof value) || file.get() != EOF) return std::nullopt;
    return value;
  }
  CpuLatencyLimit limit() { return CpuLatencyLimit({device.c_str(), driver.c_str()}); }

  const skein::test::Folder folder;
  const std::string device = folder / "cpu_dma_latency", driver = folder / "current_driver";
};

TEST_F(CpuLatency, ASleepThatIsLeftFastIsAllowed) {
  kernel_has("intel_idle");
  EXPECT_EQ(limit().granted(), 3);
  EXPECT_EQ(written(), 3);
}

TEST_F(CpuLatency, AVirtualProcessorDoesNotSleep) {
  kernel_has("haltpoll");
  EXPECT_EQ(limit().granted(), 0);
  EXPECT_EQ(written(), 0);
}

TEST_F(CpuLatency, ThatIsRefusedHasAReason) {
  const CpuLatencyLimit refused = limit();
  EXPECT_FALSE(refused.granted());
  EXPECT_NE(refused.refused().find(device + ": No such file"), std::string::npos) << refused.refused();
}

TEST_F(CpuLatency, HoldsInTheKernel) {
  const char* const kernels = "/dev/cpu_dma_latency";
  if (::access(kernels, R_OK | W_OK) != 0) GTEST_SKIP() << kernels << " may not be written here";
  const CpuLatencyLimit limit;
  ASSERT_TRUE(limit.granted());
  std::int32_t in_force = -1;
  ASSERT_TRUE(std::ifstream(kernels, std::ios::binary).read(reinterpret_cast<char*>(&in_force), sizeof in_force));
  EXPECT_GE(in_force, 0);
  EXPECT_LE(in_force, *limit.granted()) << "another program may have asked for less";
}

TEST_F(CpuLatency, LastsAsLongAsItsObject) {
  kernel_has("intel_idle");
  const auto holds_it = [&] {
    const std::filesystem::directory_iterator descriptors("/proc/self/fd");
    return std::any_of(begin(descriptors), end(descriptors), [&](const std::filesystem::directory_entry& entry) {
      std::error_code closed;
      return std::filesystem::read_symlink(entry.path(), closed) == device;
    });
  };
  {
    const CpuLatencyLimit held = limit();
    EXPECT_TRUE(holds_it());
  }
  EXPECT_FALSE(holds_it());
}

TEST(Timing, APriorityThatIsNotGrantedHasAReason) {
  EXPECT_NE(ask_for_priority(1000), "") << "there is no such priority";
}

}  // namespace
}  // namespace skein::app
