#include "app/bench/bench_publish.h"

#include <arpa/inet.h>
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "app/exchange/publisher.h"
#include "app/experiment/experiment_file.h"
#include "app/record/csv_file.h"
#include "app/run/interrupted.h"
#include "app/runs/kept_run.h"
#include "app/runs/run_folder.h"
#include "app/runs/run_index.h"
#include "app/session/session.h"

namespace skein::app {
namespace {

constexpr int robots = 30;

/// The paper's platoon with more robots, on a longer path.
Experiment long_platoon(double seconds) {
  std::vector<std::string> sets{fmt::format("duration={}", seconds), "arena.width=20", "arena.height=20",
                                "reference.path.width=12", "reference.path.height=12"};
  for (int i = 1; i <= robots; ++i) sets.push_back(fmt::format("robot.{}.tag={}", i, i));
  for (const char* const gain : {"k_xx", "k_tt", "k_yy"})  // (18f, g) share the authority among 29 pairs
    sets.push_back(fmt::format("controller.gains.{}=0.0002", gain));
  return parse_experiment(paper_experiment().source, "platoon.toml", sets).value();
}

/// A receiver with next to no room, that never reads.
class StalledReceiver {
 public:
  StalledReceiver() : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    const int room = 2048;
    ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    if (::bind(descriptor_, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
        ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size) == 0)
      where_ = fmt::format("udp:127.0.0.1:{}", ntohs(address.sin_port));
  }
  ~StalledReceiver() { ::close(descriptor_); }
  StalledReceiver(const StalledReceiver&) = delete;
  StalledReceiver& operator=(const StalledReceiver&) = delete;
  const std::string& where() const noexcept { return where_; }

 private:
  int descriptor_;
  std::string where_;
};

/// Publishes in every other stretch of 2 s, and notes when each tick began.
class Turns final : public RecordSink {
 public:
  Turns(RecordSink& publisher, double rate) : publisher_(publisher), rate_(rate) {}
  void record(const TickRecord& row) override {
    constexpr double stretch = 2.0;  // [s]
    const bool published = static_cast<std::int64_t>(row.t / stretch) % 2 == 1;
    begun_[published ? 1 : 0].push_back(row.now - static_cast<double>(row.tick) / rate_);
    if (published) publisher_.record(row);
  }
  /// How late the ticks began, beside the earliest of the run: the 99th percentile. [s]
  double lateness_p99(bool published) {
    std::vector<double>& late = begun_[published ? 1 : 0];
    const double earliest = std::min(smallest(begun_[0]), smallest(begun_[1]));
    std::sort(late.begin(), late.end());
    return late.empty() ? none : late[static_cast<std::size_t>(0.99 * static_cast<double>(late.size() - 1))] - earliest;
  }
  std::size_t ticks(bool published) const noexcept { return begun_[published ? 1 : 0].size(); }

 private:
  static double smallest(const std::vector<double>& values) {
    return values.empty() ? 0.0 : *std::min_element(values.begin(), values.end());
  }
  RecordSink& publisher_;
  double rate_;
  std::vector<double> begun_[2];
};

/// A folder that is gone afterwards.
class Place {
 public:
  Place() {
    std::string name = (std::filesystem::temp_directory_path() / "skein-bench-XXXXXX").string();
    if (::mkdtemp(name.data())) path = name;
  }
  ~Place() {
    std::error_code ignored;
    if (!path.empty()) std::filesystem::remove_all(path, ignored);
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  std::filesystem::path path;
};

void publish(benchmark::State& state, double seconds) {
  for ([[maybe_unused]] auto _ : state) {
    const Experiment experiment = long_platoon(seconds);
    const StalledReceiver receiver;
    auto publisher = Publisher::open(receiver.where(), experiment);
    if (!publisher) {
      state.SkipWithError(publisher.error().c_str());
      return;
    }
    const Place place;
    CsvFile csv((place.path / "run.csv").string(), experiment);
    Turns turns(**publisher, experiment.rate);
    auto session = Session::open(experiment, Session::Clock::wall, {.sinks = {&csv, &turns}});
    if (!session) {
      state.SkipWithError(session.error().c_str());
      return;
    }
    (*session)->run([] { return !interrupted(); });
    (*session)->close();
    csv.finish();
    const Publisher::Counts counts = (*publisher)->finish();
    const double with = turns.lateness_p99(true), without = turns.lateness_p99(false);
    state.counters["robots"] = robots;
    state.counters["ticks_published"] = static_cast<double>(turns.ticks(true));
    state.counters["ticks_not"] = static_cast<double>(turns.ticks(false));
    state.counters["late_ms_p99_published"] = 1e3 * with;
    state.counters["late_ms_p99_not"] = 1e3 * without;
    state.counters["difference_ms"] = 1e3 * (with - without);
    state.counters["rows_sent"] = static_cast<double>(counts.sent);
    state.counters["rows_dropped"] = static_cast<double>(counts.dropped);
  }
}

/// Folders with run.json alone, each a copy of a real one with other values.
void keep_many(const std::filesystem::path& directory, int count) {
  const Place one;
  const Experiment experiment = paper_experiment();
  auto kept = KeptRun::begin({one.path.string(), "", {}, {}, false}, experiment);
  Statistics statistics(experiment);
  auto session = Session::open(experiment, Session::Clock::virtual_, {.sinks = {&statistics}});
  (*session)->run();
  (*session)->close();
  [[maybe_unused]] const auto ended = kept->end(statistics.summary(), {});
  auto story = read_story(kept->folder()).value();
  for (int i = 0; i < count; ++i) {
    story["experiment"]["controller.gains.k_xx"] = 1e-6 * i;
    story["summary"]["collisions"] = i % 7;
    const auto folder = directory / fmt::format("2026-11-20_{:06}_platoon", i);
    std::filesystem::create_directories(folder);
    std::ofstream(folder / run_files::story) << story.dump(2);
  }
}

void find(benchmark::State& state, bool indexed) {
  constexpr int runs = 10'000;
  static const Place place;
  if (static bool made = false; !std::exchange(made, true)) keep_many(place.path, runs);
  const auto query = parse_query("k_xx > 0.009 and collisions = 0").value();
  [[maybe_unused]] const auto made_before = RunIndex::open(place.path.string());
  std::size_t found = 0;
  for ([[maybe_unused]] auto _ : state) {
    if (!indexed) std::filesystem::remove(place.path / ".index.sqlite");
    auto index = RunIndex::open(place.path.string());
    found = index->find(query, {"collisions", "min_distance", "final_error"})->size();
  }
  state.counters["runs"] = runs;
  state.counters["found"] = static_cast<double>(found);
}

}  // namespace

void register_publish_benchmark(double seconds) {
  benchmark::RegisterBenchmark("publish to a receiver that stalls",
                               [seconds](benchmark::State& state) { publish(state, seconds); })
      ->Unit(benchmark::kSecond)
      ->UseRealTime()
      ->Iterations(1);
}

void register_runs_benchmark() {
  benchmark::RegisterBenchmark("find in runs, index made anew (baseline)",
                               [](benchmark::State& state) { find(state, false); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->Iterations(1);
  benchmark::RegisterBenchmark("find in runs", [](benchmark::State& state) { find(state, true); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->Iterations(5);
}

}  // namespace skein::app
