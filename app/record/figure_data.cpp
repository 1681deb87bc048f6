#include "app/record/figure_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/geometry/pose.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

// A panel is 815 pixels wide and a path's line a hundredth of the figure: more than these nobody sees.
constexpr std::size_t buckets_of_all = 65536, fewest_buckets = 1024, most_buckets = 4096;
constexpr std::size_t points_of_all = 160000, fewest_points = 2500, most_points = 10000;
constexpr double first_cell = 1e-3;  // of the floor's size
// Driving, a robot never does 3 cm in a tick: it was put elsewhere, and its path is broken there.
constexpr double jump = 0.03;  // [m]
constexpr std::size_t most_moves = 10000;

bool known(double x, double y) {
  return std::isfinite(x) && std::isfinite(y);
}

std::string block(const char* name, std::size_t robot, const std::string& lines) {
  // gnuplot knows no empty block: what is not known draws nothing.
  return fmt::format("${}_{} << end\n{}end\n", name, robot + 1, lines.empty() ? "NaN NaN NaN NaN\n" : lines);
}

}  // namespace

void Extent::include(double value) {
  if (!std::isfinite(value)) return;
  low = std::fmin(low, value);  // of one that is not known and a number: the number
  high = std::fmax(high, value);
}

void Curve::Bucket::include(const Point& point) {
  if (std::isnan(point.value)) return;
  if (std::isnan(low.value) || point.value < low.value) low = point;
  if (std::isnan(high.value) || point.value > high.value) high = point;
}

void Curve::add(double t, double value) {
  if (buckets_.empty() || in_last_ == each_) {
    if (buckets_.size() == most_) {
      for (std::size_t k = 0; 2 * k < buckets_.size(); ++k) {
        Bucket both = buckets_[2 * k];
        if (2 * k + 1 < buckets_.size()) {
          both.include(buckets_[2 * k + 1].low);
          both.include(buckets_[2 * k + 1].high);
        }
        buckets_[k] = both;
      }
      buckets_.resize((buckets_.size() + 1) / 2);
      each_ *= 2;
    }
    buckets_.emplace_back();
    in_last_ = 0;
  }
  ++in_last_;
  buckets_.back().include({t, value});
}

std::string Curve::text() const {
  std::string lines;
  bool broken = true;
  for (const Bucket& bucket : buckets_) {
    if (std::isnan(bucket.low.value)) {
      if (!std::exchange(broken, true)) lines += '\n';
      continue;
    }
    broken = false;
    Point first = bucket.low, second = bucket.high;
    if (second.t < first.t) std::swap(first, second);
    lines += fmt::format("{:.9g} {:.6g}\n", first.t, first.value);
    if (second.t != first.t) lines += fmt::format("{:.9g} {:.6g}\n", second.t, second.value);
  }
  return lines;
}

Curve::Point Curve::peak() const {
  Point farthest{none, none};
  for (const Bucket& bucket : buckets_)
    for (const Point& point : {bucket.low, bucket.high})
      if (!(std::abs(point.value) <= std::abs(farthest.value)) && !std::isnan(point.value)) farthest = point;
  return farthest;
}

std::uint32_t FloorLine::cell(const Point& point) const {
  constexpr double middle = 32768.0, last = 65535.0;
  const auto index = [&](double place) {
    return static_cast<std::uint32_t>(std::clamp(std::floor(place / cell_) + middle, 0.0, last));
  };
  return index(point.x) << 16U | index(point.y);
}

void FloorLine::take(const Point& point) {
  bool is_new = !point.begins;
  if (is_new && cell_ > 0.0) {
    const std::uint64_t here = cell(point), before = cell(at_);
    if (here == before) return;
    is_new = drawn_.insert(std::max(here, before) << 32U | std::min(here, before)).second;
  }
  if (is_new && !at_is_drawn_) points_.push_back({at_.x, at_.y, true});
  if (is_new) points_.push_back(point);
  at_ = point;
  at_is_drawn_ = is_new;
}

void FloorLine::add(double x, double y, bool leads_here) {
  if (!known(x, y)) {
    at_ = {none, none, true};
    return;
  }
  take({x, y, !leads_here || std::isnan(at_.x)});
  while (points_.size() > most_) {
    cell_ = cell_ > 0.0 ? 2.0 * cell_ : first_cell * size_;
    drawn_.clear();
    for (const Point& point : std::exchange(points_, {})) take(point);
  }
}

std::string FloorLine::text() const {
  std::string lines;
  for (const Point& point : points_)
    lines += fmt::format("{}{:.6g} {:.6g}\n", point.begins && !lines.empty() ? "\n" : "", point.x, point.y);
  return lines;
}

FigureData::FigureData(const Experiment& experiment) {
  const std::size_t n = std::max<std::size_t>(1, experiment.robots.size());
  const std::size_t buckets = std::clamp(buckets_of_all / n, fewest_buckets, most_buckets);
  const std::size_t points = std::clamp(points_of_all / n, fewest_points, most_points);
  const FloorLine line(points, std::max(experiment.arena_width, experiment.arena_height));
  const Curve curve(buckets);
  for (std::size_t i = 0; i < experiment.robots.size(); ++i)
    robots_.push_back({line, line, curve, curve, curve, curve});
}

void FigureData::record(const TickRecord& row) {
  if (row.phase == Phase::finished) return;
  for (std::size_t i = 0; i < std::min(robots_.size(), row.robots.size()); ++i) {
    const RobotRecord& seen = row.robots[i];
    if (seen.is(staging)) continue;
    Robot& robot = robots_[i];
    const core::Pose &pose = seen.pose, &place = seen.nominal.pose;
    const core::Pose error{place.x - pose.x, place.y - pose.y, core::wrap_angle(place.theta - pose.theta)};
    const double way = core::math::hypot(pose.x - robot.last.x, pose.y - robot.last.y);
    const bool moved = way > jump;
    if (moved && robot.moved++ < most_moves)
      robot.moves += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g}\n", robot.last.x, robot.last.y, pose.x - robot.last.x,
                                 pose.y - robot.last.y);
    robot.reference.add(place.x, place.y, true);
    robot.path.add(pose.x, pose.y, !moved);
    robot.x.add(row.t, error.x);
    robot.y.add(row.t, error.y);
    robot.theta.add(row.t, error.theta);
    if (i < row.delta.size()) robot.delta.add(row.t, row.delta[i]), extents_.delta.include(row.delta[i]);
    for (const double x : {pose.x, place.x}) extents_.x.include(x);
    for (const double y : {pose.y, place.y}) extents_.y.include(y);
    for (const double e : {error.x, error.y}) extents_.e_xy.include(e);
    extents_.e_theta.include(error.theta);
    extents_.t.include(row.t);
    if (std::isnan(robot.first.x)) robot.first = pose;  // unless it is not seen yet
    robot.last = pose;
  }
}

std::string FigureData::paths() const {
  std::string text;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Robot& robot = robots_[i];
    text += block("reference", i, robot.reference.text());
    text += block("path", i, robot.path.text());
    text += block("moves", i, robot.moves);
    text +=
        block("ends", i,
              fmt::format("{:.6g} {:.6g}\n{:.6g} {:.6g}\n", robot.first.x, robot.first.y, robot.last.x, robot.last.y));
  }
  return text;
}

std::string FigureData::peaks(std::size_t panel, Curve Robot::*curve, const Extent& values) const {
  constexpr std::size_t most = 8;
  const double wide = curve == &Robot::delta ? 0.12 : 0.06;  // a number of two digits, or two, as a share of a panel
  constexpr double high = 0.09;
  struct Peak {
    double t, value;
    std::size_t robot;
  };
  std::vector<Peak> all, shown;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (const Curve::Point peak = (robots_[i].*curve).peak(); !std::isnan(peak.value))
      all.push_back({peak.t, peak.value, i + 1});
  std::ranges::stable_sort(all, std::greater(), [](const Peak& peak) { return std::abs(peak.value); });
  const double times = extents_.t.high - extents_.t.low, range = values.high - values.low;
  for (const Peak& peak : all) {
    const bool free = std::ranges::none_of(shown, [&](const Peak& other) {
      return std::abs(peak.t - other.t) < wide * times && std::abs(peak.value - other.value) < high * range;
    });
    if (free && shown.size() < most) shown.push_back(peak);
  }
  std::string lines;  // without any, one of no robot: gnuplot crashes where no label has a place
  for (const Peak& peak : shown) lines += fmt::format("{:.9g} {:.6g} {}\n", peak.t, peak.value, peak.robot);
  return block("peaks", panel - 1, lines.empty() ? "0 0 0\n" : lines);
}

std::string FigureData::errors() const {
  std::string text;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    text += block("x", i, robots_[i].x.text());
    text += block("y", i, robots_[i].y.text());
    text += block("theta", i, robots_[i].theta.text());
    if (i + 1 < robots_.size()) text += block("delta", i, robots_[i].delta.text());
  }
  text += peaks(1, &Robot::x, extents_.e_xy) + peaks(2, &Robot::y, extents_.e_xy) +
          peaks(3, &Robot::theta, extents_.e_theta) + peaks(4, &Robot::delta, extents_.delta);
  return text;
}

}  // namespace skein::app
