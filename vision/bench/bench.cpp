#include "vision/bench/bench.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "vision/bench/bench_cold.h"
#include "vision/bench/bench_methods.h"
#include "vision/bench/bench_scenes.h"
#include "vision/bench/bench_score.h"
#include "vision/frames/frame.h"
#include "vision/tags/tag_pose.h"

namespace skein::vision {
namespace {

using detail::BenchMethod;
using detail::BenchMoment;
using detail::BenchScene;
using detail::ColdScores;
using detail::own_ms;
using detail::Score;
using detail::Scores;

// Of the claimed covariance: what the squared error is in its units, for each of x, y and theta, and may be.
constexpr double least_nees = 0.7;
constexpr double most_nees = 1.5;

// The slow methods take so many frames of a scene, all of them in its first round; the tracker takes all frames.
constexpr int frames_of_slow_ones = 50;

/// All methods on the same frames, each frame by one after the other. Rendering is done before, a round at a time.
Scores measure(const BenchScene& scene) {
  SyntheticCamera camera(scene.calibration, scene.options, 17);
  auto methods = detail::bench_methods(scene);
  Scores scores;
  std::vector<BenchMoment> moments(detail::bench_frames);
  std::vector<Frame> film(detail::bench_frames);
  auto moment_of = scene.moment;  // it may have a memory
  Frame frame;
  for (int round = 0; round < scene.rounds; ++round) {
    for (int k = 0; k < detail::bench_frames && (round == 0 || !scene.periodic); ++k) {
      const auto place = static_cast<std::size_t>(k);
      moments[place] = moment_of(round * detail::bench_frames + k);
      camera.render(moments[place].tags, moments[place].discs, detail::bench_period * k, film[place]);
    }
    for (int k = 0; k < detail::bench_frames; k += scene.first_only ? 5 : 1) {
      const auto place = static_cast<std::size_t>(k);
      frame = film[place];  // as a camera's driver does, and leaves it in the cache
      frame.captured_at = detail::bench_period * (round * detail::bench_frames + k);
      for (auto& method : methods) {
        const bool slow = method != methods.back();
        if (slow && (round > 0 || k >= frames_of_slow_ones)) continue;
        if (scene.first_only) method->restart();
        Score& score = scores[method->name];
        const double start = own_ms();
        const std::vector<TagPose>& poses = method->detect(frame);
        const double ms = own_ms() - start;
        const bool settled = slow || scene.first_only || round > 0 || k >= 2 * frames_of_slow_ones;
        if (settled) score.ms.push_back(ms);
        if (settled || k > 0) score.add(moments[place], poses);
      }
    }
  }
  return scores;
}

/// Of the scenes that were measured.
std::map<std::string, Scores>& known_scores() {
  static std::map<std::string, Scores> known;
  return known;
}

/// Measured when the first of its methods is requested.
const Scores& scores_of(const BenchScene& scene) {
  auto& known = known_scores();
  const auto found = known.find(scene.name);
  return found != known.end() ? found->second : known.emplace(scene.name, measure(scene)).first->second;
}

/// The same of those with cold caches.
std::map<std::string, ColdScores>& known_cold_scores() {
  static std::map<std::string, ColdScores> known;
  return known;
}

const ColdScores& cold_scores_of(const BenchScene& scene, int frames) {
  auto& known = known_cold_scores();
  const auto found = known.find(scene.name);
  return found != known.end() ? found->second
                              : known.emplace(scene.name, detail::measure_cold(scene, frames)).first->second;
}

/// How many times faster than another method, at this share of the sorted times.
double times_faster(const Scores& scores, const std::string& than, double share, const Score& score) {
  return scores.at(than).percentile(share) / score.percentile(share);
}

constexpr double middle = 0.5;
constexpr double slowest = 0.99;

void report(benchmark::State& state, const Scores& scores, const std::string& method) {
  const auto found = scores.find(method);
  if (found == scores.end()) {
    state.SkipWithError("its module cannot be loaded");
    return;
  }
  const Score& score = found->second;
  for ([[maybe_unused]] auto _ : state) state.SetIterationTime(1e-3 * score.percentile(middle));
  state.counters["p99_ms"] = score.percentile(slowest);
  state.counters["max_ms"] = score.percentile(1.0);
  state.counters["x_tuned"] = times_faster(scores, "AprilTag tuned", middle, score);
  state.counters["x_tuned_p99"] = times_faster(scores, "AprilTag tuned", slowest, score);
  state.counters["x_stock"] = times_faster(scores, "AprilTag", middle, score);
  if (score.in_sight == 0) return;  // decoding
  state.counters["xy_mm"] = 1e3 * score.rms_xy();
  state.counters["deg"] = 180.0 / core::pi * score.rms_theta();
  if (score.with_covariance > 0) state.counters["nees"] = score.mean_nees();
  state.counters["recall_%"] = score.recall();
  state.counters["wrong_poses"] = static_cast<double>(score.wrong_poses);
  state.counters["wrong_ids"] = static_cast<double>(score.wrong_ids);
}

void register_one(const std::string& name, std::function<void(benchmark::State&)> row) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(row))
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime()
      ->Iterations(1);
}

void register_cold(const BenchScene& scene, int frames) {
  std::vector<std::string> methods{"AprilTag", "AprilTag tuned", "Skein"};
  if (scene.mjpeg) methods.emplace_back("decoding");
  for (const bool cold : {true, false})
    for (const std::string& method : methods)
      register_one("vision, cold, " + scene.name + "/" + method + (cold ? "" : ", warm"), [=](benchmark::State& state) {
        const ColdScores& scores = cold_scores_of(scene, frames);
        report(state, cold ? scores.cold : scores.warm, method);
      });
}

/// What a scene had to reach, in one line.
class Targets {
 public:
  /// The control, if there is one, is printed and asks for nothing.
  void row(const std::string& what, double measured, double target, bool at_most, const std::string& control = {}) {
    if (std::isnan(target)) return;
    const bool met = at_most ? measured <= target : measured >= target;
    met_ = met_ && met;
    line_ += fmt::format("{}{} {:.4g} ({} {:g}: {}{})", line_.empty() ? "" : "; ", what, measured,
                         at_most ? "at most" : "at least", target, met ? "met" : "MISSED", control);
  }
  void note(const std::string& what) { line_ += (line_.empty() ? "" : "; ") + what; }

  /// Prints it. false: something was missed.
  bool print(const std::string& title) const {
    fmt::print("target, {}: {}\n", title, line_);
    return met_;
  }

 private:
  std::string line_;
  bool met_ = true;
};

bool print_cold_targets(const BenchScene& scene, const ColdScores& scores) {
  const Score& skein = scores.cold.at("Skein");
  const Score& warm = scores.warm.at("Skein");
  const auto faster = [&](const Scores& of, double share) {
    return times_faster(of, "AprilTag tuned", share, of.at("Skein"));
  };
  const auto control = [](double value) { return fmt::format("; warm {:.4g}", value); };
  Targets targets;
  targets.note(fmt::format("median ms {:.4g} (warm {:.4g})", skein.percentile(middle), warm.percentile(middle)));
  if (std::isnan(scene.cold.p99_ms))
    targets.note(fmt::format("p99 ms {:.4g} (warm {:.4g})", skein.percentile(slowest), warm.percentile(slowest)));
  targets.row("p99 ms", skein.percentile(slowest), scene.cold.p99_ms, true, control(warm.percentile(slowest)));
  if (std::isnan(scene.cold.times_faster))
    targets.note(fmt::format("times tuned AprilTag {:.4g} (warm {:.4g}), p99 {:.4g} (warm {:.4g})",
                             faster(scores.cold, middle), faster(scores.warm, middle), faster(scores.cold, slowest),
                             faster(scores.warm, slowest)));
  targets.row("times tuned AprilTag", faster(scores.cold, middle), scene.cold.times_faster, false,
              control(faster(scores.warm, middle)));
  targets.row("p99", faster(scores.cold, slowest), scene.cold.times_faster_p99, false,
              control(faster(scores.warm, slowest)));
  targets.note(fmt::format("times stock {:.4g} (warm {:.4g})", times_faster(scores.cold, "AprilTag", middle, skein),
                           times_faster(scores.warm, "AprilTag", middle, warm)));
  if (scene.mjpeg)
    targets.note(fmt::format("{:.0f} kB a frame, of which decoding takes {:.4g} ms in the median, {:.4g} in the p99",
                             1e-3 * scores.jpeg_bytes, scores.cold.at("decoding").percentile(middle),
                             scores.cold.at("decoding").percentile(slowest)));
  targets.row("recall % beside AprilTag's", skein.recall(), scores.cold.at("AprilTag").recall(), false);
  targets.row("wrong poses and ids", static_cast<double>(skein.wrong_poses + skein.wrong_ids), 0.0, true);
  return targets.print("cold, " + scene.name);
}

bool print_warm_targets(const BenchScene& scene, const Scores& scores) {
  const Score& s = scores.at("Skein");
  const Score& apriltag = scores.at("AprilTag");
  const detail::BenchTargets& wanted = scene.targets;
  Targets targets;
  targets.row("median ms", s.percentile(middle), wanted.median_ms, true);
  targets.row("p99 ms", s.percentile(slowest), wanted.p99_ms, true);
  targets.row("times AprilTag", apriltag.percentile(middle) / s.percentile(middle), wanted.times_faster, false);
  targets.row("rms mm", 1e3 * s.rms_xy(), wanted.xy_mm, true);
  targets.row("rms deg", 180.0 / core::pi * s.rms_theta(), wanted.deg, true);
  targets.row("NEES", s.mean_nees(), least_nees, false);
  targets.row("NEES", s.mean_nees(), most_nees, true);
  targets.row("recall %", s.recall(), wanted.recall, false);
  targets.row("recall % beside AprilTag's", s.recall(), apriltag.recall(), false);
  targets.row("wrong poses and ids", static_cast<double>(s.wrong_poses + s.wrong_ids), 0.0, true);
  return targets.print(scene.name);
}

}  // namespace

void register_vision_benchmarks(int cold_frames) {
  if (cold_frames > 0)
    for (const BenchScene& scene : detail::cold_scenes()) register_cold(scene, cold_frames);
  for (const BenchScene& scene : detail::bench_scenes())
    for (const char* method : {"AprilTag", "AprilTag tuned", "OpenCV ArUco", "Skein"})
      register_one("vision, " + scene.name + "/" + method,
                   [scene, method](benchmark::State& state) { report(state, scores_of(scene), method); });
}

bool print_vision_targets() {
  bool all_met = true;
  for (const BenchScene& scene : detail::cold_scenes()) {
    const auto found = known_cold_scores().find(scene.name);
    if (found != known_cold_scores().end()) all_met = print_cold_targets(scene, found->second) && all_met;
  }
  for (const BenchScene& scene : detail::bench_scenes()) {
    const auto found = known_scores().find(scene.name);
    if (found != known_scores().end()) all_met = print_warm_targets(scene, found->second) && all_met;
  }
  return all_met;
}

}  // namespace skein::vision
