#include "ui/base/circumstances.h"

#include <algorithm>
#include <cmath>

namespace skein::ui {

Circumstances::Circumstances(const app::Experiment& experiment)
    : obstacles(experiment.obstacles),
      half_width(0.5 * experiment.arena_width),
      half_height(0.5 * experiment.arena_height),
      detects(std::max(experiment.avoidance.alpha, experiment.avoidance.beta)) {
  for (const app::RobotSpec& robot : experiment.robots) radii.push_back(robot.radius);
}

void Circumstances::note(const app::TickRecord& record) {
  using namespace app::events;
  constexpr double in_place = 0.01, takes_effect = 0.5;  // [m, s]
  std::erase_if(moved, [&](const auto& entry) {
    const auto& [robot, how] = entry;
    const core::TrackingError& error = record.robots[static_cast<std::size_t>(robot)].error;
    return record.t < how.t || (record.t > how.t + takes_effect && std::hypot(error.x, error.y) < in_place);
  });
  for (const app::Event& event : record.events) {
    if (const auto* const put = std::get_if<PutObstacle>(&event)) {
      if (put->number >= obstacles.size()) obstacles.resize(put->number + 1);
      obstacles[put->number] = put->obstacle;
    }
    const auto robot = app::robot_of(event);
    if (!robot || *robot >= record.robots.size()) continue;
    const int i = static_cast<int>(*robot);
    if (app::is<Hold>(event)) held.insert(i);
    if (app::is<Release>(event)) held.erase(i);
    if (app::is<Runaway>(event)) disobedient.insert(i);
    if (app::is<Obeys>(event)) disobedient.erase(i);
    if (app::is<Move, Kick, Perturb, Kidnap>(event)) moved.insert_or_assign(i, Moved{event, record.t});
  }
}

}  // namespace skein::ui
