#include "ui/arena/arena_gestures.h"

#include <algorithm>
#include <cmath>

#include "ui/base/tr.h"

namespace skein::ui {
namespace {

constexpr double kick_per_way = 4.0;  // [1/s]: an arrow of 25 cm is a kick of 1 m/s, the hardest there is
constexpr double hardest_kick = 1.0;  // [m/s]
constexpr double usual_radius = 0.04, smallest_radius = 0.01, largest_radius = 0.3;  // of a dropped obstacle [m]
constexpr double off_the_floor = 0.05;  // outside the arena: an obstacle that is let go here is taken away [m]
constexpr double snap = 0.03;           // a ruler's end holds on to the middle of what is this near [m]

class DragRobot final : public ArenaGesture {
 public:
  DragRobot(ArenaScene& scene, int robot, QPointF grip) : scene_(scene), robot_(robot) {
    const core::Pose pose = scene.pose(static_cast<std::size_t>(robot)).value_or(core::Pose{});
    grip_ = grip - QPointF(pose.x, pose.y);
  }
  void move(QPointF floor) override {
    const double theta = scene_.pose(static_cast<std::size_t>(robot_)).value_or(core::Pose{}).theta;
    const QPointF to = inside_arena(scene_, floor - grip_, scene_.radius(static_cast<std::size_t>(robot_)));
    scene_.ghost = {robot_, {to.x(), to.y(), theta}};
  }
  void release(const ArenaRequests& ask) override {
    if (!scene_.ghost) return;
    // It has driven on meanwhile, and turned: it keeps the heading that it has now.
    const auto now = scene_.pose(static_cast<std::size_t>(robot_));
    const core::Pose& to = scene_.ghost->pose;
    ask.move(robot_, {to.x, to.y, now ? now->theta : to.theta});
  }

 private:
  ArenaScene& scene_;
  int robot_;
  QPointF grip_;  // from the robot's middle
};

class KickRobot final : public ArenaGesture {
 public:
  KickRobot(ArenaScene& scene, int robot) : scene_(scene), robot_(robot) {}
  void move(QPointF floor) override {
    const core::Pose pose = scene_.pose(static_cast<std::size_t>(robot_)).value_or(core::Pose{});
    QPointF way = floor - QPointF(pose.x, pose.y);
    const double length = std::hypot(way.x(), way.y());
    if (length > hardest_kick / kick_per_way) way *= hardest_kick / kick_per_way / length;
    scene_.kick = {robot_, way, way * kick_per_way};
  }
  void release(const ArenaRequests& ask) override {
    if (!scene_.kick) return;
    const double reach = scene_.radius(static_cast<std::size_t>(robot_));
    if (std::hypot(scene_.kick->way.x(), scene_.kick->way.y()) > reach) return ask.kick(robot_, scene_.kick->velocity);
    ask.refuse(tr("Robot %1 is not kicked: the arrow has to end outside it, which takes at least %2 m/s")
                   .arg(robot_ + 1)
                   .arg(kick_per_way * reach, 0, 'f', 2));
  }

 private:
  ArenaScene& scene_;
  int robot_;
};

class DragObstacle final : public ArenaGesture {
 public:
  DragObstacle(ArenaScene& scene, int number, QPointF grip)
      : scene_(scene), number_(number), obstacle_(scene.circumstances.obstacles[static_cast<std::size_t>(number)]) {
    grip_ = grip - QPointF(obstacle_.x, obstacle_.y);
  }
  void move(QPointF floor) override {
    const QPointF to = floor - grip_, inside = inside_arena(scene_, to, 0.0);
    const bool leaves = std::hypot(to.x() - inside.x(), to.y() - inside.y()) > off_the_floor;
    const QPointF shown = leaves ? to : inside;
    scene_.ghost_obstacle = {number_, {shown.x(), shown.y(), obstacle_.radius}, leaves};
  }
  void release(const ArenaRequests& ask) override {
    if (!scene_.ghost_obstacle) return;
    ask.obstacle(number_, scene_.ghost_obstacle->leaves ? core::Obstacle{} : scene_.ghost_obstacle->obstacle);
  }

 private:
  ArenaScene& scene_;
  int number_;
  core::Obstacle obstacle_;
  QPointF grip_;
};

class DropObstacle final : public ArenaGesture {
 public:
  DropObstacle(ArenaScene& scene, QPointF at) : scene_(scene), at_(inside_arena(scene, at, 0.0)) {
    scene_.ghost_obstacle = {-1, {at_.x(), at_.y(), usual_radius}, false};
  }
  void move(QPointF floor) override {  // drawn out to its size
    const double radius = std::hypot(floor.x() - at_.x(), floor.y() - at_.y());
    scene_.ghost_obstacle->obstacle.radius = std::clamp(radius, smallest_radius, largest_radius);
  }
  void release(const ArenaRequests& ask) override { ask.obstacle(-1, scene_.ghost_obstacle->obstacle); }

 private:
  ArenaScene& scene_;
  QPointF at_;
};

class Measure final : public ArenaGesture {
 public:
  Measure(ArenaScene& scene, QPointF from) : scene_(scene) {
    const QPointF held = hold_on(from);
    scene_.ruler = {held, held};
  }
  void move(QPointF floor) override { scene_.ruler->to = hold_on(floor); }
  void release(const ArenaRequests&) override {
    if (scene_.ruler && scene_.ruler->from == scene_.ruler->to) scene_.ruler.reset();  // a click takes it away
  }

 private:
  QPointF hold_on(QPointF floor) const {
    const int robot = scene_.robot_at(floor.x(), floor.y(), snap, false);
    if (robot >= 0) {
      const core::Pose pose = *scene_.pose(static_cast<std::size_t>(robot));
      return {pose.x, pose.y};
    }
    for (const core::Obstacle& o : scene_.circumstances.obstacles)
      if (o.radius > 0.0 && std::hypot(o.x - floor.x(), o.y - floor.y()) < snap) return {o.x, o.y};
    return floor;
  }
  ArenaScene& scene_;
};

}  // namespace

QPointF inside_arena(const ArenaScene& scene, QPointF floor, double margin) {
  const double w = scene.experiment.arena_width / 2 - margin, h = scene.experiment.arena_height / 2 - margin;
  return {std::clamp(floor.x(), -w, w), std::clamp(floor.y(), -h, h)};
}

std::unique_ptr<ArenaGesture> drag_robot(ArenaScene& scene, int robot, QPointF grip) {
  return std::make_unique<DragRobot>(scene, robot, grip);
}
std::unique_ptr<ArenaGesture> kick_robot(ArenaScene& scene, int robot) {
  return std::make_unique<KickRobot>(scene, robot);
}
std::unique_ptr<ArenaGesture> drag_obstacle(ArenaScene& scene, int number, QPointF grip) {
  return std::make_unique<DragObstacle>(scene, number, grip);
}
std::unique_ptr<ArenaGesture> drop_obstacle(ArenaScene& scene, QPointF at) {
  return std::make_unique<DropObstacle>(scene, at);
}
std::unique_ptr<ArenaGesture> measure(ArenaScene& scene, QPointF from) {
  return std::make_unique<Measure>(scene, from);
}

}  // namespace skein::ui
