#include "app/tools/passage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/simulation/random.h"

namespace skein::app {
namespace {

constexpr std::uint64_t passage_stream = 1'000'033;  // of chance: others belong to robots and to other changes
constexpr double thickness = 0.025, every = 0.035;   // of a wall's obstacles: radius, and from one to the next [m]
constexpr int most_passage_tries = 1000, most_scenes = 1000;

/// A scene in its own frame: x through the passage, y along the wall.
class Scene {
 public:
  Scene(const Passage& passage, const Experiment& e, std::uint64_t seed)
      : passage_(passage),
        w_(0.5 * e.arena_width),
        h_(0.5 * e.arena_height),
        radius_(e.robots.front().radius),
        random_(seed, passage_stream) {}

  tl::expected<std::vector<std::string>, std::string> draw() {
    for (int tries = 0; tries < most_scenes; ++tries)
      if (lay_out()) return sets();
    return tl::unexpected(std::string("there is no room for the passage and its robots"));
  }

 private:
  double between(const std::array<double, 2>& span) { return span[0] + (span[1] - span[0]) * random_.uniform(); }
  core::Point world(double x, double y) const {
    return {x_ + x * core::math::cos(turn_) - y * core::math::sin(turn_),
            y_ + x * core::math::sin(turn_) + y * core::math::cos(turn_)};
  }
  /// How far beyond the passage a place of the floor is, negative before it.
  double through(const core::Point& p) const {
    return (p.x - x_) * core::math::cos(turn_) + (p.y - y_) * core::math::sin(turn_);
  }
  /// Draws everything; false: there was no room for it.
  bool lay_out() {
    walls_.clear(), starts_.clear(), places_.clear();
    const double width = 2.0 * radius_ * between(passage_.width), length = between(passage_.length);
    turn_ = core::pi * (1.0 - 2.0 * random_.uniform());
    x_ = 0.4 * w_ * (1.0 - 2.0 * random_.uniform());
    y_ = 0.4 * h_ * (1.0 - 2.0 * random_.uniform());
    const double far = 2.0 * core::math::hypot(w_, h_), side = 0.5 * width + thickness;
    from_ = thickness;
    switch (passage_.kind) {
      case PassageKind::corridor:
        corridor(side, length, far);
        return change_sides({1, 1});
      case PassageKind::head_on:
        corridor(side, length, far);
        return change_sides(passage_.robots);
      case PassageKind::door:
        for (const double y : {side, -side}) wall(0.0, y, 0.0, y > 0.0 ? far : -far);
        return change_sides(passage_.robots);
      case PassageKind::dead_end:
        for (const double y : {side, -side}) wall(-length, y, 0.0, y);
        wall(0.0, -side, 0.0, side);
        return leave_dead_end(width, length);
    }
    return false;
  }
  void corridor(double side, double length, double far) {
    for (const double y : {side, -side}) {
      wall(-0.5 * length, y, 0.5 * length, y);
      for (const double x : {-0.5 * length, 0.5 * length}) wall(x, y, x, y > 0.0 ? far : -far);
    }
    from_ = 0.5 * length + thickness;
  }
  bool change_sides(const std::array<std::int64_t, 2>& robots) {
    const auto n =
        robots[0] + static_cast<std::int64_t>(static_cast<double>(robots[1] - robots[0] + 1) * random_.uniform());
    for (std::int64_t i = 0; i < n; ++i) {
      const double left = i % 2 == 0 ? -1.0 : 1.0;
      if (!put(starts_, left) || !put(places_, -left)) return false;
    }
    return true;
  }
  void wall(double x0, double y0, double x1, double y1) {
    const double long_ = core::math::hypot(x1 - x0, y1 - y0);
    const int n = std::max(1, static_cast<int>(std::ceil(long_ / every)));
    for (int k = 0; k <= n; ++k) {
      const double s = static_cast<double>(k) / n;
      const core::Point p = world(x0 + s * (x1 - x0), y0 + s * (y1 - y0));
      if (std::abs(p.x) <= w_ && std::abs(p.y) <= h_) walls_.push_back({p.x, p.y, thickness});
    }
  }
  bool clear(const core::Point& p, const std::vector<core::Pose>& others) const {
    const double edge = passage_.clearance - core::standard_radius;
    return std::abs(p.x) <= w_ - edge && std::abs(p.y) <= h_ - edge &&
           std::all_of(
               others.begin(), others.end(),
               [&](const core::Pose& o) { return core::math::hypot(o.x - p.x, o.y - p.y) >= passage_.clearance; }) &&
           std::all_of(walls_.begin(), walls_.end(), [&](const core::Obstacle& o) {
             return core::math::hypot(o.x - p.x, o.y - p.y) >= o.radius + edge;
           });
  }
  /// Anywhere on one side of the passage.
  bool put(std::vector<core::Pose>& poses, double side) {
    for (int tries = 0; tries < most_passage_tries; ++tries) {
      const core::Point p{w_ * (1.0 - 2.0 * random_.uniform()), h_ * (1.0 - 2.0 * random_.uniform())};
      if (side * through(p) < from_ || !clear(p, poses)) continue;
      poses.push_back({p.x, p.y, core::pi * (1.0 - 2.0 * random_.uniform())});
      return true;
    }
    return false;
  }
  bool leave_dead_end(double width, double length) {
    const double beside = 0.5 * width + 2.0 * thickness + passage_.clearance;
    for (const double x : {-length - passage_.clearance, passage_.clearance})  // a robot can drive round it
      for (const double y : {-beside, beside})
        if (const core::Point corner = world(x, y); std::abs(corner.x) > w_ || std::abs(corner.y) > h_) return false;
    // At the end of the U, as near to it as the shield lets a robot be, or anywhere else in it.
    const double keeps = std::min(0.5 * width, radius_ + 0.01);
    const double room = std::max(0.0, length - 2.0 * keeps);
    const core::Point p = world(-thickness - keeps - room * random_.uniform(), 0.0);
    starts_.push_back({p.x, p.y, core::pi * (1.0 - 2.0 * random_.uniform())});
    return put(places_, 1.0);
  }
  std::vector<std::string> sets() const {
    std::string obstacles, robots;
    for (const core::Obstacle& o : walls_)
      obstacles += fmt::format("{}{{x={}, y={}, radius={}}}", obstacles.empty() ? "" : ", ", o.x, o.y, o.radius);
    for (std::size_t i = 0; i < starts_.size(); ++i)
      robots += fmt::format(
          "{}{{start=[{}, {}, {}], trajectory={{path={{shape=\"line\", from=[{}, {}], to=[{}, {}]}}}}}}", i ? ", " : "",
          starts_[i].x, starts_[i].y, starts_[i].theta, starts_[i].x, starts_[i].y, places_[i].x, places_[i].y);
    return {"obstacle=[" + obstacles + "]", "robot=[" + robots + "]"};
  }

  const Passage passage_;
  double w_, h_, radius_;
  core::Random random_;
  double turn_ = 0.0, x_ = 0.0, y_ = 0.0;
  double from_ = 0.0;  // from the passage's middle to where its sides begin [m]
  std::vector<core::Obstacle> walls_;
  std::vector<core::Pose> starts_, places_;
};

}  // namespace

tl::expected<std::vector<std::string>, std::string> draw_passage(const Passage& passage, const Experiment& experiment,
                                                                 std::uint64_t seed) {
  return Scene(passage, experiment, seed).draw();
}

}  // namespace skein::app
