#include "ui/arena_scene.h"

#include <cmath>

#include "core/reference/reference.h"

namespace skein::ui {

void ArenaScene::reset(const app::Experiment& of) {
  experiment = of;
  record.reset();
  trails.assign(experiment.robots.size(), {});
  ghost.reset();
  hovered = -1;
  if (selected >= static_cast<int>(experiment.robots.size())) selected = -1;
  picture = {};

  lines = app::make_reference(experiment)->lines();
}

void ArenaScene::take(const app::TickRecord& newest) {
  const bool jumped = record && newest.t < record->t;
  record = newest;
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

int ArenaScene::robot_at(double x, double y, double reach) const {
  int nearest = -1;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const auto at = pose(i);
    if (!at) continue;
    const double away = std::hypot(at->x - x, at->y - y);
    if (away > reach) continue;
    reach = away;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace skein::ui
