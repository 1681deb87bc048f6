#pragma once

#include <QPointF>
#include <QString>
#include <functional>
#include <memory>

#include "ui/arena/arena_scene.h"

namespace skein::ui {

/// What the mouse does in the arena.
enum class ArenaTool {
  hand,      ///< drags robots and obstacles
  kick,      ///< draws the velocity of a kick out of a simulated robot
  measure,   ///< a ruler between two points
  obstacle,  ///< drops obstacles
};

/// The differences between the tools.
struct ArenaToolKind {
  bool grasps = false;          ///< takes hold of what lies there, couplings as well; without it, keys move a cross
  bool kicks = false;           ///< a drag out of a robot is a kick
  bool measures = false;        ///< with a ruler, through robots and obstacles
  bool sets_obstacles = false;  ///< before robots
  bool aims = false;            ///< at a point of the floor
};
constexpr ArenaToolKind kind(ArenaTool tool) noexcept {
  switch (tool) {
    case ArenaTool::hand:
      return {.grasps = true};
    case ArenaTool::kick:
      return {.kicks = true};
    case ArenaTool::measure:
      return {.measures = true, .aims = true};
    case ArenaTool::obstacle:
      return {.sets_obstacles = true, .aims = true};
  }
  return {};
}

/// The requests that the operator's gestures make; gestures change the run only through these.
struct ArenaRequests {
  std::function<void(int robot, const core::Pose&)> move;
  std::function<void(int robot, QPointF velocity)> kick;            // [m/s]
  std::function<void(int number, const core::Obstacle&)> obstacle;  // number -1: a new one; radius 0: remove it
  std::function<void(const QString& why)> refuse;                   // nothing is done
};

/// One drag of the mouse from press to release: shows its effect in the scene, and executes it on release.
class ArenaGesture {
 public:
  virtual ~ArenaGesture() = default;
  virtual void move(QPointF floor) = 0;
  virtual void release(const ArenaRequests& ask) = 0;
};

/// `grip`: where on the floor the mouse was pressed.
std::unique_ptr<ArenaGesture> drag_robot(ArenaScene& scene, int robot, QPointF grip);
std::unique_ptr<ArenaGesture> kick_robot(ArenaScene& scene, int robot);
std::unique_ptr<ArenaGesture> drag_obstacle(ArenaScene& scene, int number, QPointF grip);
std::unique_ptr<ArenaGesture> drop_obstacle(ArenaScene& scene, QPointF at);
std::unique_ptr<ArenaGesture> measure(ArenaScene& scene, QPointF from);

/// The point nearest to this one that is inside the arena and at least `margin` from its edges [m].
QPointF inside_arena(const ArenaScene& scene, QPointF floor, double margin);

}  // namespace skein::ui
