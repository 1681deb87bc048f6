#include "ui/arena/arena_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/reference/reference.h"
#include "ui/base/tr.h"

namespace skein::ui {

void ArenaScene::reset(const app::Experiment& of) {
  experiment = of;
  record.reset();
  may_be_driving.clear();
  trails.assign(experiment.robots.size(), {});
  forget_gesture();
  ruler.reset();
  circumstances = Circumstances(experiment);
  couplings.assign(experiment.robots.size() * experiment.robots.size(), 0.0);
  selected_obstacle = -1;
  hovered_coupling.reset();
  hovered = -1;
  if (selected >= static_cast<int>(experiment.robots.size())) selected = -1;
  picture = {};
  pictured_at = app::none;

  lines = app::make_reference(experiment)->lines();
}

QString ArenaScene::old_picture() const {
  constexpr double old = 1.0;  // [s]
  const double age = record ? record->now - pictured_at : app::none;
  if (!show_picture || picture.isNull() || !(age > old)) return {};
  return tr("This picture is %1 s old").arg(age, 0, 'f', 0);
}

void ArenaScene::show_record(const app::TickRecord& newest) {
  const bool jumped = record && newest.t < record->t;
  record = newest;
  circumstances.note(newest);
  for (std::size_t i = 0; i < trails.size() && i < newest.robots.size(); ++i) {
    auto& trail = trails[i];
    if (jumped) trail.clear();
    while (!trail.empty() && trail.front().t < newest.t - trail_seconds) trail.pop_front();
    const auto at = pose(i);
    if (!at || newest.robots[i].is(app::lost)) continue;
    const double way = trail.empty() ? 1.0 : std::hypot(at->x - trail.back().x, at->y - trail.back().y);
    constexpr double still = 0.0005, carried = 0.03;  // a tick at full speed is 4 mm
    if (way > still) trail.push_back({newest.t, at->x, at->y, way > carried});
  }
}

std::optional<core::Pose> ArenaScene::pose(std::size_t i) const {
  if (!record || i >= record->robots.size()) return std::nullopt;
  const app::RobotRecord& robot = record->robots[i];
  if (std::isfinite(robot.truth.x)) return robot.truth;
  const bool seen = robot.measurement.captured_at > -1e8;
  if (!seen || !std::isfinite(robot.pose.x)) return std::nullopt;
  return robot.pose;
}

bool ArenaScene::draws_coupling(std::size_t i, std::size_t j) const {
  constexpr std::size_t most = 30;  // robots
  if (experiment.robots.size() <= most || j == i + 1) return true;
  return selected == static_cast<int>(i) || selected == static_cast<int>(j);
}

bool ArenaScene::is_out_of_group(std::size_t i) const {
  const app::RobotRecord& robot = record->robots[i];
  return robot.is(app::lost) || (record->phase == app::Phase::running && robot.is(app::stopped));
}

ModeStyle ArenaScene::style_of(std::size_t i, const Colours& colours) const {
  const bool unknown = std::find(may_be_driving.begin(), may_be_driving.end(), i) != may_be_driving.end();
  return unknown ? may_be_driving_style(colours) : mode_style(record->robots[i].mode, colours, is_held(i));
}

QPointF ArenaScene::cross_at() const {
  if (!cross) return {};
  if (cross->robot < 0) return cross->at;
  const auto at = pose(static_cast<std::size_t>(cross->robot));
  return at ? QPointF(at->x, at->y) : cross->at;
}

int ArenaScene::robot_at(double x, double y, double reach, bool bodies) const {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const auto at = pose(i);
    if (!at) continue;
    const double away = std::hypot(at->x - x, at->y - y);
    if (away > least || away > (bodies ? std::max(reach, radius(i)) : reach)) continue;
    least = away;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

int ArenaScene::obstacle_at(double x, double y) const {
  const std::vector<core::Obstacle>& obstacles = circumstances.obstacles;
  for (std::size_t k = obstacles.size(); k-- > 0;)  // the last one is drawn on top
    if (std::hypot(obstacles[k].x - x, obstacles[k].y - y) < obstacles[k].radius) return static_cast<int>(k);
  return -1;
}

std::vector<QPointF> ArenaScene::coupling_line(std::size_t i, std::size_t j, double scale) const {
  const auto one = pose(i), other = pose(j);
  if (!one || !other) return {};
  const QPointF a(one->x, one->y), b(other->x, other->y), way = b - a;
  if (j == i + 1) return {a, b};
  constexpr double bow = 0.16;    // of its length
  constexpr double finest = 0.5;  // how far a piece may be from the curve [px]
  const int pieces =
      std::clamp(static_cast<int>(std::ceil(std::sqrt(bow * std::hypot(way.x(), way.y()) * scale / finest))), 2, 12);
  const QPointF across(-way.y(), way.x());
  std::vector<QPointF> line;
  line.reserve(static_cast<std::size_t>(pieces) + 1);
  for (int k = 0; k <= pieces; ++k) {
    const double s = static_cast<double>(k) / pieces;
    line.push_back(a + way * s + across * (4 * bow * s * (1 - s)));
  }
  return line;
}

}  // namespace skein::ui
