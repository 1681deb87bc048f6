#include "vision/bench/bench.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <Eigen/Cholesky>

#include <time.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "vision/bench/bench_methods.h"
#include "vision/bench/bench_scenes.h"
#include "vision/frames/frame.h"
#include "vision/tags/tag_pose.h"

namespace skein::vision {
namespace {

using detail::BenchMethod;
using detail::BenchMoment;
using detail::BenchScene;

// A pose further off than this is a wrong one, wherever the tag. [m], [rad]
constexpr double wrong_xy = 2e-3;
constexpr double wrong_theta = 2.0 * core::pi / 180.0;

// Of the claimed covariance: what the squared error is in its units, for each of x, y and theta, and may be.
constexpr double least_nees = 0.7;
constexpr double most_nees = 1.5;

// The slow methods take so many frames of a scene, all of them in its first round; the tracker takes all frames.
constexpr int frames_of_slow_ones = 50;

/// How a method has done in a scene.
struct Score {
  std::vector<double> ms;
  double xy2 = 0.0;
  double theta2 = 0.0;
  double nees = 0.0;  // sum over the poses that come with a covariance
  std::int64_t with_covariance = 0;
  std::int64_t right = 0;
  std::int64_t in_sight = 0;
  std::int64_t seen_in_sight = 0;
  std::int64_t wrong_poses = 0;
  std::int64_t wrong_ids = 0;

  void add(const BenchMoment& truth, const std::vector<TagPose>& poses) {
    std::vector<bool> seen(truth.tags.size());
    for (const TagPose& pose : poses) {
      if (static_cast<std::size_t>(pose.tag) >= truth.tags.size()) {
        ++wrong_ids;
        continue;
      }
      const auto i = static_cast<std::size_t>(pose.tag);
      const double xy = core::distance(pose.pose, truth.tags[i].pose);
      const double theta = core::wrap_angle(pose.pose.theta - truth.tags[i].pose.theta);
      if (pose.covariance(0, 0) > 0.0) {
        const Eigen::Vector3d error(pose.pose.x - truth.tags[i].pose.x, pose.pose.y - truth.tags[i].pose.y, theta);
        nees += error.dot(pose.covariance.ldlt().solve(error)) / 3.0;
        ++with_covariance;
      }
      if (xy > wrong_xy || std::abs(theta) > wrong_theta) {
        ++wrong_poses;
        continue;
      }
      seen[i] = true;
      if (!truth.in_sight[i]) continue;
      ++right;
      xy2 += xy * xy;
      theta2 += theta * theta;
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
      in_sight += truth.in_sight[i] ? 1 : 0;
      seen_in_sight += truth.in_sight[i] && seen[i] ? 1 : 0;
    }
  }

  double recall() const {
    return 100.0 * static_cast<double>(seen_in_sight) / static_cast<double>(std::max<std::int64_t>(1, in_sight));
  }

  /// Normalised estimation error squared, per degree of freedom: 1 where the claimed deviations are true.
  double mean_nees() const { return nees / static_cast<double>(std::max<std::int64_t>(1, with_covariance)); }

  double percentile(double share) const {
    if (ms.empty()) return 0.0;
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  }
};

using Scores = std::map<std::string, Score>;

/// The time that this thread has worked: all methods keep to one, and what else the machine does is not theirs.
double own_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

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

/// Measured when the first of its methods is asked for.
const Scores& scores_of(const BenchScene& scene) {
  auto& known = known_scores();
  const auto found = known.find(scene.name);
  return found != known.end() ? found->second : known.emplace(scene.name, measure(scene)).first->second;
}

void report(benchmark::State& state, const BenchScene& scene, const std::string& method) {
  const Scores& scores = scores_of(scene);
  const auto found = scores.find(method);
  if (found == scores.end()) {
    state.SkipWithError("its module cannot be loaded");
    return;
  }
  const Score& score = found->second;
  for ([[maybe_unused]] auto _ : state) state.SetIterationTime(1e-3 * score.percentile(0.5));
  const auto right = static_cast<double>(std::max<std::int64_t>(1, score.right));
  state.counters["p99_ms"] = score.percentile(0.99);
  state.counters["max_ms"] = score.percentile(1.0);
  state.counters["x_AprilTag"] = scores.at("AprilTag").percentile(0.5) / score.percentile(0.5);
  state.counters["xy_mm"] = 1e3 * std::sqrt(score.xy2 / right);
  state.counters["deg"] = 180.0 / core::pi * std::sqrt(score.theta2 / right);
  if (score.with_covariance > 0) state.counters["nees"] = score.mean_nees();
  state.counters["recall_%"] = score.recall();
  state.counters["wrong_poses"] = static_cast<double>(score.wrong_poses);
  state.counters["wrong_ids"] = static_cast<double>(score.wrong_ids);
}

}  // namespace

void register_vision_benchmarks() {
  for (const BenchScene& scene : detail::bench_scenes()) {
    for (const char* method : {"AprilTag", "AprilTag tuned", "OpenCV ArUco", "Skein"}) {
      const std::string name = "vision, " + scene.name + "/" + method;
      benchmark::RegisterBenchmark(name.c_str(),
                                   [scene, method](benchmark::State& state) { report(state, scene, method); })
          ->Unit(benchmark::kMillisecond)
          ->UseManualTime()
          ->Iterations(1);
    }
  }
}

bool print_vision_targets() {
  bool all_met = true;
  for (const BenchScene& scene : detail::bench_scenes()) {
    const auto found = known_scores().find(scene.name);
    if (found == known_scores().end()) continue;
    const Score& s = found->second.at("Skein");
    const auto right = static_cast<double>(std::max<std::int64_t>(1, s.right));
    const Score& apriltag = found->second.at("AprilTag");
    const detail::BenchTargets& wanted = scene.targets;
    std::string line;
    const auto row = [&](const char* what, double measured, double target, bool at_most) {
      if (std::isnan(target)) return;
      const bool met = at_most ? measured <= target : measured >= target;
      all_met = all_met && met;
      line += fmt::format("; {} {:.4g} ({} {:g}{})", what, measured, at_most ? "at most" : "at least", target,
                          met ? "" : ", MISSED");
    };
    row("median ms", s.percentile(0.5), wanted.median_ms, true);
    row("p99 ms", s.percentile(0.99), wanted.p99_ms, true);
    row("times AprilTag", apriltag.percentile(0.5) / s.percentile(0.5), wanted.times_faster, false);
    row("rms mm", 1e3 * std::sqrt(s.xy2 / right), wanted.xy_mm, true);
    row("rms deg", 180.0 / core::pi * std::sqrt(s.theta2 / right), wanted.deg, true);
    row("NEES", s.mean_nees(), least_nees, false);
    row("NEES", s.mean_nees(), most_nees, true);
    row("recall %", s.recall(), wanted.recall, false);
    row("recall % beside AprilTag's", s.recall(), apriltag.recall(), false);
    row("wrong poses and ids", static_cast<double>(s.wrong_poses + s.wrong_ids), 0.0, true);
    fmt::print("target, {}: {}\n", scene.name, line.substr(2));
  }
  return all_met;
}

}  // namespace skein::vision
