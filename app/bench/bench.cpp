#include "app/bench/bench.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/bench/bench_cameras.h"
#include "app/bench/bench_control.h"
#include "app/bench/bench_controllers.h"
#include "app/bench/bench_joint.h"
#include "app/bench/bench_latency.h"
#include "app/bench/bench_links.h"
#include "app/bench/bench_motors.h"
#include "app/bench/bench_planner.h"
#include "app/bench/bench_publish.h"
#include "app/bench/bench_radio.h"
#include "app/bench/bench_swaps.h"
#include "app/bench/bench_timing.h"
#include "app/bench/identify_study.h"
#include "app/manual/manual.h"
#include "app/manual/mistakes.h"
#include "app/manual/whole_number.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/version.h"
#include "comms/crash_stop.h"
#include "vision/bench/bench.h"

namespace skein::app {
namespace {

/// A word of `skein-bench`: a room's benchmarks are a file of their own here or in the room, and one row in this table.
struct Bench {
  const char *name, *what;
  /// Registers with Google Benchmark, which runs all of it. `seconds`: how long each measurement takes that does not
  /// know by itself. Null: it has none.
  void (*add)(double seconds);
  /// After they have run: what was to be reached, or measurements of its own, on stdout; an exit status. May be null.
  int (*report)(double seconds) = nullptr;
  bool unasked = true;  ///< is measured when no word is given
};

int cold_frames = 300;

int report_vision(double) {
  return vision::print_vision_targets() ? done : expectation_failed;
}

CamerasBench cameras;

int report_cameras(double) {
  return bench_cameras(cameras);
}

ControllersBench controllers;  // as the command line says

int report_controllers(double seconds) {
  controllers.seconds = std::min(seconds, 40.0);
  return bench_controllers(controllers);
}

IdentifyBench identification;

int report_identify(double) {
  return bench_identify(identification);
}

PlannerBench planning;

int report_planner(double) {
  return bench_planner(planning);
}

SwapsBench swaps;

int report_swaps(double) {
  return bench_swaps(swaps);
}

TimingBench timing;

int report_timing(double seconds) {
  timing.seconds = seconds;
  return bench_timing(timing);
}

RadioBench radio;  // as the command line says

int report_radio(double) {
  return report_radio_faults(radio);
}

constexpr Bench table[] = {
    {"tick", "one control tick, and the law alone", [](double) { register_tick_benchmarks(); }},
    {"control", "law, avoidance and shield for 4 to 1,000 robots", [](double) { register_control_benchmarks(); }},
    {"run", "`skein run platoon.toml --csv`", [](double) { register_run_benchmark(); }},
    {"vision", "the tag tracker, AprilTag and ArUco", [](double) { vision::register_vision_benchmarks(cold_frames); },
     report_vision},
    {"cameras", "several cameras: four frames to 64 poses, robots that cross a seam", nullptr, report_cameras,
     /*unasked=*/false},
    {"controllers", "users' controllers: what one adds to the tick; --runs under adversaries", nullptr,
     report_controllers, /*unasked=*/false},
    {"identify", "what `skein identify` finds of 1,000 robots that are known", nullptr, report_identify,
     /*unasked=*/false},
    {"joint", "what `skein calibrate joint` mends of calibrations that are wrong in known ways", nullptr,
     [](double) { return bench_joint(); }, /*unasked=*/false},
    {"latency", "what `skein camera latency` finds of stamps that are late by a known time", nullptr,
     [](double) { return bench_latency(); },
     /*unasked=*/false},
    {"planner", "what planning costs a tick: 30 robots anywhere, kicks of the platoon", nullptr, report_planner},
    {"swaps", "planned routes beside ORCA, barrier certificates and the field, same scenes", nullptr, report_swaps,
     /*unasked=*/false},
    {"timing", "lateness of ticks beside that of a bare thread: the ratios with their intervals", nullptr,
     report_timing,
     /*unasked=*/false},
    {"links", "links at 25 Hz on pseudo-terminals (2 minutes)", register_link_benchmarks},
    {"radio", "the paper's lap over slow radios; --faults at random", [](double) { register_radio_benchmarks(); },
     report_radio},
    {"motors", "steady tracking error of emulated e-pucks at 0.05 m/s", nullptr, [](double) { return bench_motors(); }},
    {"publish", "`--publish` to a receiver that stalls, 30 robots in real time", register_publish_benchmark},
    {"runs", "a search in 10,000 kept runs", [](double) { register_runs_benchmark(); }},
    {"loopback", "camera, tracker and protocol in real time (84 s)", [](double) { register_loopback_benchmark(); }},
};
constexpr const char* window = "ui";  // takes the process for itself: an application of Qt

std::string words_of_the_table() {
  std::string words;
  for (const Bench& bench : table) words += fmt::format("  {:<11} {}\n", bench.name, bench.what);
  return words + fmt::format("  {:<11} {}\n", window, "what the window costs (6 minutes), unless it is named left out");
}

int parse_and_measure(int argc, char** argv, const BenchWindow& bench_window) {
  CLI::App program{"Measures Skein on this machine, as ratios against a baseline of the same run (docs/benchmarks.md).",
                   "skein-bench"};
  program.set_version_flag("--version", "skein-bench " + version_and_commit());
  std::vector<std::string> names{window};
  for (const Bench& bench : table) names.emplace_back(bench.name);
  std::string what;
  program
      .add_option(
          "what", what,
          "one of those below; default: all but cameras, controllers, identify, joint, latency, swaps, timing and ui")
      ->check(CLI::IsMember(names));
  double seconds = 60.0;
  program
      .add_option("--seconds", seconds,
                  "how long each measurement takes, where it does not know by itself: links, publish, timing, ui")
      ->check(number_within(1.0, 3600.0))
      ->capture_default_str();
  std::optional<std::int64_t> runs;
  program
      .add_option(
          "--runs", runs,
          "cameras: crossings; controllers: runs under adversaries, 0: none; identify: robots; planner, swaps: scenes; "
          "timing: runs; default: 10000, 140, 1000, 8, 40, 20")
      ->check(whole_number(0, 10'000'000))
      ->type_name("N");
  double hours = 0.0;
  program.add_option("--hours", hours, "ui: its memory in a run of so many hours instead, 50 times as fast")
      ->check(number_within(0.0, 24.0));
  program.add_option("--faults", radio.faults, "radio: random fault sequences; 0: none")
      ->check(whole_number(0, 1'000'000))
      ->capture_default_str();
  program
      .add_option("--frames", cold_frames,
                  "vision: frames of each scene that is measured with cold caches, too; 0: none of these")
      ->check(whole_number(0, 1'000'000))
      ->capture_default_str();
  std::uint64_t seed = 1;
  program
      .add_option("--seed", seed,
                  "cameras, controllers, identify, planner, swaps, radio: of the first of them; the next ones count on")
      ->capture_default_str();
  program.allow_extras()->footer(words_of_the_table() +
                                 "Further options go to Google Benchmark, e.g. --benchmark_repetitions=5");
  std::string manual_folder;
  program.add_option("--manual", manual_folder)->group("");  // writes its own manual page there

  if (argc > 1 && std::string_view(argv[1]) == "complete") {  // a shell asks: resources/completion
    print_out(completions(program, {argv + 2, argv + argc}));
    return done;
  }
  refuse_missing_values(program);
  say_mistakes_plainly(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? done : wrong_input;
  }
  if (!manual_folder.empty()) {
    const auto written = write_manual(program, version_and_commit(), manual_folder);
    if (!written) complain(written.error());
    return written ? done : wrong_input;
  }
  cameras.runs = runs.value_or(cameras.runs);
  controllers.runs = runs.value_or(controllers.runs);
  identification.runs = runs.value_or(identification.runs);
  swaps.runs = runs.value_or(swaps.runs);
  timing.runs = runs.value_or(timing.runs);
  planning.runs = runs.value_or(planning.runs);
  cameras.seed = controllers.seed = identification.seed = planning.seed = swaps.seed = radio.seed = timing.seed = seed;
  catch_interrupts();
  comms::stop_robots_on_crash();
  if (what == window) {
    if (bench_window) return bench_window(seconds, hours, argc, argv);
    complain("this program was built without a window");
    return wrong_input;
  }
  const auto asked = [&](const Bench& bench) { return what.empty() ? bench.unasked : what == bench.name; };
  bool any = false;
  for (const Bench& bench : table)
    if (asked(bench) && bench.add != nullptr) bench.add(seconds), any = true;

  std::string name = "skein-bench";
  std::vector<std::string> extras = program.remaining();
  std::vector<char*> words{name.data()};
  for (std::string& word : extras) words.push_back(word.data());
  int count = static_cast<int>(words.size());
  words.push_back(nullptr);
  benchmark::Initialize(&count, words.data());
  if (benchmark::ReportUnrecognizedArguments(count, words.data())) return wrong_input;
  if (any) benchmark::RunSpecifiedBenchmarks();  // says that none was found otherwise
  int status = done;
  for (const Bench& bench : table)
    if (asked(bench) && bench.report != nullptr) status = std::max(status, bench.report(seconds));
  return what.empty() ? done : status;
}

}  // namespace

int bench(int argc, char** argv, const BenchWindow& bench_window) {
  return exit_status_of([&] { return parse_and_measure(argc, argv, bench_window); });
}

}  // namespace skein::app
