#include "vision/bench/bench_scenes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "vision/synthetic/random.h"
#include "vision/tags/tag_plane.h"

namespace skein::vision::detail {
namespace {

constexpr double arena_width = 2.0;
constexpr double arena_height = 1.5;

/// Robots that go round in circles, each in its own cell of the arena, at an e-puck's full speed of 0.13 m/s.
struct Roundabout {
  int tags;
  double size;
  double lap = bench_frames;  // frames of a round

  BenchMoment operator()(int k) const {
    const int columns = static_cast<int>(std::ceil(std::sqrt(tags)));
    const int rows = (tags + columns - 1) / columns;
    const int turns = columns > 4 ? 3 : 1;  // in a lap: small cells, small circles
    const double radius = 0.13 * lap * bench_period / (2.0 * std::numbers::pi * turns);
    BenchMoment moment;
    for (int i = 0; i < tags; ++i) {
      const double angle = 0.7 * i + 2.0 * std::numbers::pi * turns * k / lap;
      const double x = arena_width * ((i % columns + 0.5) / columns - 0.5) + radius * std::cos(angle);
      const int line = i / columns;
      const double y = arena_height * ((line + 0.5) / rows - 0.5) + radius * std::sin(angle);
      moment.tags.push_back({i, {x, y, core::wrap_angle(angle + std::numbers::pi / 2)}, size});
    }
    moment.in_sight.assign(moment.tags.size(), true);
    return moment;
  }
};

/// The same, but robots change places: one in a hundred jumps in every frame, by a third of a metre and more.
class Teleports {
 public:
  explicit Teleports(int tags) : roundabout_{tags, 0.06} {
    for (int i = 0; i < tags; ++i) cell_of_.push_back(static_cast<std::size_t>(i));
  }

  BenchMoment operator()(int k) {
    for (std::size_t& cell : cell_of_)
      if (k > 0 && random_.unit() < 0.005) std::swap(cell, cell_of_[random_.below(cell_of_.size())]);
    const BenchMoment in_place = roundabout_(k);
    BenchMoment moment = in_place;
    for (std::size_t i = 0; i < cell_of_.size(); ++i) moment.tags[i].pose = in_place.tags[cell_of_[i]].pose;
    return moment;
  }

 private:
  Roundabout roundabout_;
  std::vector<std::size_t> cell_of_;
  Random random_{11};
};

/// How far it is from the arena's middle to the picture's border. [m]
double to_the_border(const Calibration& calibration, double along_x, double along_y) {
  constexpr double step = 1e-3;
  double way = 0.0;
  for (;; way += step) {
    const auto at = pixel_from_world(calibration, {way * along_x, way * along_y, calibration.tag_height});
    const bool inside = at && at->x() >= 0.0 && at->y() >= 0.0 && at->x() <= calibration.width - 1.0 &&
                        at->y() <= calibration.height - 1.0;
    if (!inside) return way;
  }
}

/// All robots move outwards, each by the same part of its way, until the outer ones drive along the picture's border,
/// which cuts the paper of their tags there. A tag is in sight while all of its paper is.
class AlongTheBorder {
 public:
  AlongTheBorder(const Roundabout& robots, const Calibration& calibration)
      : robots_(robots), calibration_(calibration) {
    // The black square stays in the picture; of the paper around it, which is an eighth wide, a half is cut off.
    constexpr double cut_at = 0.5 + 0.125 / 2.0;
    double most_x = 0.0, most_y = 0.0;
    for (int k = 0; k < bench_frames; ++k)
      for (const SyntheticTag& tag : robots_(k).tags) {
        most_x = std::max(most_x, std::abs(tag.pose.x));
        most_y = std::max(most_y, std::abs(tag.pose.y));
      }
    const auto least = [&](double x, double y) {
      return std::min(to_the_border(calibration, x, y), to_the_border(calibration, -x, -y)) - cut_at * robots_.size;
    };
    out_x_ = least(1.0, 0.0) - most_x;
    out_y_ = least(0.0, 1.0) - most_y;
  }

  BenchMoment operator()(int k) const {
    BenchMoment moment = robots_(k);
    for (std::size_t i = 0; i < moment.tags.size(); ++i) {
      SyntheticTag& tag = moment.tags[i];
      tag.pose.x += std::copysign(out_x_, tag.pose.x);
      tag.pose.y += std::copysign(out_y_, tag.pose.y);
      moment.in_sight[i] = in_sight(tag);
    }
    return moment;
  }

 private:
  bool in_sight(const SyntheticTag& tag) const {
    const double half = 0.5 * 1.25 * tag.size;
    const double c = std::cos(tag.pose.theta) * half, s = std::sin(tag.pose.theta) * half;
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0}) {
        const auto at = pixel_from_world(
            calibration_, {tag.pose.x + c * x - s * y, tag.pose.y + s * x + c * y, calibration_.tag_height});
        if (!at || at->x() < 1.0 || at->y() < 1.0 || at->x() > calibration_.width - 2.0 ||
            at->y() > calibration_.height - 2.0)
          return false;
      }
    return true;
  }

  Roundabout robots_;
  Calibration calibration_;
  double out_x_ = 0.0;  // [m]
  double out_y_ = 0.0;
};

BenchMoment smeared(BenchMoment moment, double metres) {
  for (SyntheticTag& tag : moment.tags) tag.smear = metres;
  return moment;
}

/// An arm's end wanders over the arena; a tag is in sight while it keeps clear of its paper.
BenchMoment with_arm(BenchMoment moment, const Calibration& calibration, int k) {
  const double angle = 2.0 * std::numbers::pi * k / bench_frames;
  const SyntheticDisc arm{0.8 * std::cos(angle), 0.55 * std::sin(2.0 * angle), 0.09, 0.15, 110.0, 0.0};
  const auto at = pixel_from_world(calibration, {arm.x, arm.y, arm.height});
  const auto edge = pixel_from_world(calibration, {arm.x + arm.radius, arm.y, arm.height});
  for (std::size_t i = 0; i < moment.tags.size(); ++i) {
    const core::Pose& pose = moment.tags[i].pose;
    const double half_diagonal = 0.5 * 1.25 * std::numbers::sqrt2 * moment.tags[i].size;
    const auto tag = pixel_from_world(calibration, {pose.x, pose.y, calibration.tag_height});
    const auto corner = pixel_from_world(calibration, {pose.x + half_diagonal, pose.y, calibration.tag_height});
    moment.in_sight[i] = (*tag - *at).norm() > (*edge - *at).norm() + (*corner - *tag).norm() + 3.0;
  }
  moment.discs.push_back(arm);
  return moment;
}

/// Two people lean over the arena: shadows with a narrow and a wide edge wander over it. The tags stay in sight.
BenchMoment with_shadows(BenchMoment moment, const Calibration& calibration, int k) {
  const double angle = 2.0 * std::numbers::pi * k / bench_frames;
  const double height = calibration.tag_height;
  moment.discs.push_back({0.8 * std::cos(angle), 0.5 * std::sin(2.0 * angle), 0.25, height, 0.0, 0.03, 0.6});
  moment.discs.push_back({-0.7 * std::sin(angle), 0.5 * std::cos(angle), 0.3, height, 0.0, 0.15, 0.6});
  return moment;
}

/// The same path for a lamp's reflection, a veil with a wide edge over half of what it covers.
BenchMoment with_glare(BenchMoment moment, const Calibration& calibration, int k) {
  const double angle = 2.0 * std::numbers::pi * k / bench_frames;
  const double height = calibration.tag_height;
  moment.discs.push_back({0.8 * std::cos(angle), 0.5 * std::sin(2.0 * angle), 0.25, height, 255.0, 0.2, 0.5});
  return moment;
}

Calibration rolling(Calibration calibration) {
  calibration.row_time = 25e-6;
  return calibration;
}

Calibration with_tags(double size) {
  Calibration calibration = overhead_calibration(arena_width, arena_height);
  calibration.tag_size = size;
  return calibration;
}

Calibration halved(Calibration calibration) {
  calibration.width /= 2;
  calibration.height /= 2;
  calibration.fx /= 2.0;
  calibration.fy /= 2.0;
  calibration.cx = (calibration.cx + 0.5) / 2.0 - 0.5;
  calibration.cy = (calibration.cy + 0.5) / 2.0 - 0.5;
  return calibration;
}

}  // namespace

std::vector<BenchScene> bench_scenes() {
  const Calibration large = with_tags(0.06);
  const Calibration small = with_tags(0.04);
  const Roundabout sixteen{16, 0.06};
  const double px = large.tag_size / tag_edge_px(large);  // [m]
  // So that ink and paper are 43 grey levels apart in the middle of the picture.
  const SceneOptions dim{.noise_sigma = 6.0, .brightness = 43.0 / 195.0 / 0.9};
  std::vector<BenchScene> scenes;
  for (const int n : {4, 16, 64})
    scenes.push_back({"n=" + std::to_string(n), large, {}, n, false, 8, true, Roundabout{n, 0.06}});
  scenes.push_back({"40 mm tags", small, {}, 16, false, 4, true, Roundabout{16, 0.04}});
  scenes.push_back({"teleports 1 %", large, {}, 16, false, 8, false, Teleports(16)});
  scenes.push_back(
      {"motion blur 5 px", large, {}, 16, false, 4, true, [=](int k) { return smeared(sixteen(k), 5.0 * px); }});
  // A lens out of focus, shortly before the operator is told.
  scenes.push_back({"lens blur 1.1 px", large, {.blur_px = 1.1}, 16, false, 4, true, sixteen});
  scenes.push_back({"contrast 43 sigma 6", large, dim, 16, false, 4, true, sixteen});
  scenes.push_back({"occluder", large, {}, 16, false, 8, true, [=](int k) { return with_arm(sixteen(k), large, k); }});
  scenes.push_back({"640x480", halved(large), {}, 16, false, 4, true, sixteen});
  // Mains are never quite at 50 Hz: bands creep over the picture, once round in the film.
  for (const int percent : {30, 50, 90})
    scenes.push_back({"flicker " + std::to_string(percent) + " %",
                      rolling(large),
                      {.flicker = 0.01 * percent, .flicker_hz = 100.2},
                      16,
                      false,
                      4,
                      true,
                      sixteen});
  scenes.push_back(
      {"moving shadows", large, {}, 16, false, 4, true, [=](int k) { return with_shadows(sixteen(k), large, k); }});
  scenes.push_back({"glare", large, {}, 16, false, 4, true, [=](int k) { return with_glare(sixteen(k), large, k); }});
  scenes.push_back({"first frame", large, {}, 16, true, 1, true, sixteen});
  const std::map<std::string, BenchTargets> targets{
      {"n=4", {.median_ms = 0.03, .p99_ms = 0.09, .recall = 100.0}},
      {"n=16", {.median_ms = 0.1, .p99_ms = 0.3, .times_faster = 200.0, .xy_mm = 0.03, .deg = 0.05, .recall = 100.0}},
      {"n=64", {.median_ms = 0.3, .p99_ms = 0.9, .recall = 100.0}},
      {"40 mm tags", {.xy_mm = 0.05, .deg = 0.1, .recall = 100.0}},
      {"teleports 1 %", {.p99_ms = 3.0, .recall = 99.5}},
      {"motion blur 5 px", {.recall = 99.5}},
      {"lens blur 1.1 px", {.recall = 100.0}},
      {"contrast 43 sigma 6", {.recall = 99.5}},
      {"occluder", {.p99_ms = 3.0, .recall = 99.5}},
      {"640x480", {.recall = 100.0}},
      {"flicker 30 %", {.recall = 100.0}},
      {"flicker 50 %", {.recall = 100.0}},
      {"flicker 90 %", {}},
      {"moving shadows", {.recall = 99.5}},
      {"glare", {.recall = 99.5}},
      {"first frame", {.median_ms = 15.0, .recall = 100.0}},
  };
  for (BenchScene& scene : scenes) scene.targets = targets.at(scene.name);
  return scenes;
}

std::vector<BenchScene> cold_scenes() {
  // No simple part of a round: on its next lap a robot is elsewhere between the pixels.
  constexpr double lap = bench_frames * std::numbers::phi / 1.5;
  const Calibration calibration = with_tags(0.06);
  const Roundabout sixteen{16, 0.06, lap};
  const auto scene = [&](const std::string& name, int tags, std::function<BenchMoment(int k)> moment,
                         const ColdTargets& targets) {
    BenchScene made;
    made.name = name;
    made.calibration = calibration;
    made.tags = tags;
    made.periodic = false;
    made.moment = std::move(moment);
    made.cold = targets;
    return made;
  };
  const ColdTargets usual{.times_faster = 100.0, .times_faster_p99 = 50.0};
  const ColdTargets hard{.times_faster = 50.0, .times_faster_p99 = 15.0};
  std::vector<BenchScene> scenes;
  scenes.push_back(scene("n=4", 4, Roundabout{4, 0.06, lap}, {}));
  scenes.push_back(scene("n=16", 16, sixteen, usual));
  scenes.push_back(scene("n=64", 64, Roundabout{64, 0.06, lap}, {}));
  scenes.push_back(scene("border", 16, AlongTheBorder(sixteen, calibration), hard));
  scenes.push_back(scene(
      "moving shadows", 16, [=](int k) { return with_shadows(sixteen(k), calibration, k); }, hard));
  scenes.push_back(scene(
      "glare", 16, [=](int k) { return with_glare(sixteen(k), calibration, k); }, hard));
  scenes.push_back(scene("MJPEG", 16, sixteen, {.p99_ms = 3.0}));
  scenes.back().mjpeg = true;
  return scenes;
}

}  // namespace skein::vision::detail
