#include "app/bench/bench_links.h"

#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "app/run/interrupted.h"
#include "comms/asercom.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/link_supervisor.h"

namespace skein::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double period = 0.04;  // [s]

double now() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Emulated robots, and when each of them last obeyed a command: the bytes were written before that.
class Robots {
 public:
  explicit Robots(std::size_t count)
      : obeyed_(count),
        emulator_(
            std::vector(count, core::MotorModel::epuck2),
            [this](std::size_t robot, const core::WheelSpeeds&) { obeyed_[robot].store(now()); }, now) {}

  std::string device(std::size_t robot) const { return emulator_.device(robot); }
  /// Adds how long each robot took from `given` on; clears what it has seen. Those that did not obey are missing.
  void collect(double given, std::vector<double>& seconds) {
    for (std::atomic<double>& obeyed : obeyed_)
      if (const double at = obeyed.exchange(0.0); at >= given) seconds.push_back(at - given);
  }

 private:
  std::deque<std::atomic<double>> obeyed_;
  comms::PtyEmulator emulator_;  // last: its thread uses the others
};

/// Serial lines that are written to without any ado: the baseline.
class PlainLines {
 public:
  explicit PlainLines(const Robots& robots, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      lines_.push_back(::open(robots.device(i).c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  }
  ~PlainLines() {
    for (const int line : lines_)
      if (line >= 0) ::close(line);
  }
  PlainLines(const PlainLines&) = delete;
  PlainLines& operator=(const PlainLines&) = delete;

  void write(comms::WheelCommand command) {
    const auto bytes = comms::wheel_request(command, comms::Question::wheels);
    for (const int line : lines_) [[maybe_unused]]
      const auto written = ::write(line, bytes.data(), bytes.size());
  }
  void drop_answers() {
    std::array<char, 256> bytes;
    for (const int line : lines_)
      while (::read(line, bytes.data(), bytes.size()) > 0) {
      }
  }

 private:
  std::vector<int> lines_;
};

std::set<std::string> threads() {
  std::set<std::string> all;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) all.insert(entry.path().string());
  return all;
}

/// Processor time of a thread, as Linux counts it. [s]
double processor_time(const std::string& thread) {
  double nanoseconds = 0.0;
  std::ifstream(thread + "/schedstat") >> nanoseconds;
  return 1e-9 * nanoseconds;
}

double p99(std::vector<double>& seconds) {
  if (seconds.empty()) return NAN;
  const auto nth = seconds.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(seconds.size() - 1));
  std::nth_element(seconds.begin(), nth, seconds.end());
  return *nth;
}

/// Commands to every robot at 25 Hz through the supervisor, and half a period later through plain write().
void links(benchmark::State& state, double seconds) {
  const auto count = static_cast<std::size_t>(state.range(0));
  for ([[maybe_unused]] auto _ : state) {
    Robots robots(count), plain_robots(count);
    PlainLines plain(plain_robots, count);
    std::vector<comms::LinkAddress> addresses;
    for (std::size_t i = 0; i < count; ++i) addresses.push_back({comms::LinkKind::serial, robots.device(i), 0, {}, {}});
    const std::set<std::string> before = threads();
    comms::LinkSupervisor supervisor(addresses);
    if (const auto started = supervisor.start(10.0); !started) {
      state.SkipWithError(started.error().c_str());
      return;
    }
    std::string link_thread;
    for (const std::string& thread : threads())
      if (!before.contains(thread)) link_thread = thread;

    std::vector<double> through_links, through_write, written;
    const double begun = now(), busy_before = processor_time(link_thread);
    const auto start = Clock::now();
    const auto ticks = static_cast<int>(std::lround(seconds / period));
    const auto at = [start](double ticks_later) {
      return start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period * ticks_later));
    };
    for (int k = 0; k < ticks && !interrupted(); ++k) {
      const int speed = k % 2 == 0 ? 100 : 200;  // another one every tick: wheels that change are reported
      std::this_thread::sleep_until(at(k));
      double given = now();
      for (std::size_t i = 0; i < count; ++i) supervisor.command(i, speed, speed);
      std::this_thread::sleep_until(at(k + 0.5));
      robots.collect(given, through_links);
      for (std::size_t i = 0; i < count; ++i)
        if (const double done_at = supervisor.times(i).written; done_at >= given) written.push_back(done_at - given);
      given = now();
      plain.write(comms::clamped(speed, speed));
      std::this_thread::sleep_until(at(k + 0.9));
      plain_robots.collect(given, through_write);
      plain.drop_answers();
    }
    const double busy = processor_time(link_thread) - busy_before, lasted = now() - begun;
    const double commands = static_cast<double>(count) * ticks;
    const double links_p99 = p99(through_links), write_p99 = p99(through_write);
    state.counters["tick_to_written_ms_p99"] = 1e3 * p99(written);
    state.counters["tick_to_robot_ms_p99"] = 1e3 * links_p99;
    state.counters["of_period"] = links_p99 / period;
    state.counters["of_plain_write"] = links_p99 / write_p99;
    state.counters["cores"] = busy / lasted;
    state.counters["late_or_lost"] = commands - static_cast<double>(through_links.size());
  }
}

}  // namespace

void register_link_benchmarks(double seconds) {
  for (const int count : {4, 28})
    benchmark::RegisterBenchmark("links at 25 Hz", [seconds](benchmark::State& state) { links(state, seconds); })
        ->Arg(count)
        ->Unit(benchmark::kSecond)
        ->UseRealTime()
        ->Iterations(1);
}

}  // namespace skein::app
