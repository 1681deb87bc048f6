// What is under the pointer, and what is said of it.
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "ui/arena/arena_view.h"
#include "ui/base/modes.h"
#include "ui/base/number_text.h"
#include "ui/base/picture.h"
#include "ui/base/why.h"

namespace skein::ui {
namespace {

/// From a point to a line between two others.
double distance_to(QPointF point, QPointF a, QPointF b) {
  const QPointF way = b - a;
  const double length2 = QPointF::dotProduct(way, way);
  const double s = length2 > 0.0 ? std::clamp(QPointF::dotProduct(point - a, way) / length2, 0.0, 1.0) : 0.0;
  const QPointF off = point - (a + way * s);
  return std::hypot(off.x(), off.y());
}

}  // namespace

int ArenaView::robot_under(QPointF screen) const {
  const QPointF floor = map_.to_floor(screen);
  // Zoomed out, a robot is small: some pixels around it still catch it.
  return scene_.robot_at(floor.x(), floor.y(), 12.0 / map_.scale_at(floor), true);
}

int ArenaView::obstacle_under(QPointF screen) const {
  const QPointF floor = map_.to_floor(screen);
  return scene_.obstacle_at(floor.x(), floor.y());
}

std::optional<std::array<int, 2>> ArenaView::coupling_under(QPointF screen) const {
  if (!scene_.draws_couplings() || !scene_.record) return std::nullopt;
  constexpr double reach = 6.0;  // [px]
  std::optional<std::array<int, 2>> nearest;
  double least = reach;
  const auto robots = static_cast<int>(scene_.experiment.robots.size());
  const double scale = map_.scale_at({0.0, 0.0});
  for (int i = 0; i < robots; ++i)
    for (int j = i + 1; j < robots; ++j) {
      const auto one = static_cast<std::size_t>(i), other = static_cast<std::size_t>(j);
      if (!scene_.draws_coupling(one, other)) continue;
      const std::vector<QPointF> line = scene_.coupling_line(one, other, scale);
      for (std::size_t k = 1; k < line.size(); ++k) {
        const double away = distance_to(screen, map_.to_screen(line[k - 1]), map_.to_screen(line[k]));
        if (away >= least) continue;
        least = away;
        nearest = {i, j};
      }
    }
  return nearest;
}

bool ArenaView::movable(int robot) const {
  return robot >= 0 && scene_.experiment.robots[static_cast<std::size_t>(robot)].simulated();
}

bool ArenaView::may_take(int robot, QPoint where) {
  if (movable(robot)) return true;
  emit refused(why_not(robot));
  if (!where.isNull()) QToolTip::showText(where, why_not(robot), this);
  return false;
}

QString ArenaView::why_not(int robot) const {
  return tr("Robot %1 is real: move it by hand.").arg(robot + 1);
}

/// The banner, and what each robot does, or the selected one alone.
QString ArenaView::spoken() const {
  if (!scene_.record) return {};
  QStringList lines;
  if (!scene_.banner.isEmpty()) lines << scene_.banner;
  if (const QString old = scene_.old_picture(); !old.isEmpty()) lines << old;
  for (std::size_t i = 0; i < scene_.record->robots.size(); ++i) {
    const auto pose = scene_.pose(i);
    if (scene_.selected >= 0 && static_cast<std::size_t>(scene_.selected) != i) continue;
    const QString doing = why(*scene_.record, i, scene_.circumstances);
    lines << (pose ? tr("Robot %1 at x %2 m, y %3 m, heading %4°: %5")
                         .arg(i + 1)
                         .arg(fixed(pose->x, 2), fixed(pose->y, 2), fixed(pose->theta * 180.0 / core::pi, 0), doing)
                   : tr("Robot %1: %2").arg(i + 1).arg(doing));
  }
  return lines.join(QStringLiteral("; "));
}

void ArenaView::begin_tip(QPointF where) {
  const int robot = robot_under(where);
  const auto pose = robot >= 0 ? scene_.pose(static_cast<std::size_t>(robot)) : std::nullopt;
  if (pose)
    tip_ = {where - map_.to_screen({pose->x, pose->y}), robot, tip_of(robot)};
  else
    tip_ = {where, -1, tip_at(where)};
  QToolTip::showText(mapToGlobal(where.toPoint()), tip_->said, this);  // without a text: none any more
}

/// A robot drives on while its tip is read: the tip goes with it, and says what is so now.
void ArenaView::follow_tip() {
  if (!tip_) return;
  const int robot = tip_->robot;
  const bool still_there = QToolTip::isVisible() && QToolTip::text() == tip_->said;  // and not another widget's
  const auto pose = robot >= 0 ? scene_.pose(static_cast<std::size_t>(robot)) : std::nullopt;
  if (!still_there || (robot >= 0 && !pose)) return tip_.reset();
  tip_->said = pose ? tip_of(robot) : tip_at(tip_->at);
  const QPointF where = pose ? map_.to_screen({pose->x, pose->y}) + tip_->at : tip_->at;
  QToolTip::showText(mapToGlobal(where.toPoint()), tip_->said, this);
}

/// Of an obstacle or a coupling.
QString ArenaView::tip_at(QPointF where) const {
  if (!scene_.record) return {};
  const int obstacle = obstacle_under(where);
  if (obstacle >= 0) {
    const core::Obstacle& o = scene_.circumstances.obstacles[static_cast<std::size_t>(obstacle)];
    return tr("<b>Obstacle %1</b><br>x %2 m, y %3 m, radius %4 m<br>%5")
        .arg(obstacle + 1)
        .arg(fixed(o.x, 3), fixed(o.y, 3), fixed(o.radius, 3))
        .arg(can_do(tr("Drag to move it, wheel to resize it; drag it off the floor, or press Delete, to remove it.")));
  }
  const auto pair = coupling_under(where);
  return pair ? tr("Coupling of robots %1 and %2. %3")
                    .arg((*pair)[0] + 1)
                    .arg((*pair)[1] + 1)
                    .arg(can_do(tr("Click to switch it off or on.")))
              : QString();
}

/// Of a robot whose place is known.
QString ArenaView::tip_of(int robot) const {
  const auto i = static_cast<std::size_t>(robot);
  const core::Pose pose = scene_.pose(i).value_or(core::Pose{});
  const bool unseen = scene_.record->robots[i].is(app::lost) && i < unseen_.size();
  return (unseen ? html_of(unseen_[i]) : QString()) +
         tr("<b>Robot %1</b> (tag %2): %3: %4<br>x %5 m, y %6 m, heading %7°<br>%8")
             .arg(robot + 1)
             .arg(scene_.experiment.robots[i].tag)
             .arg(mode_text(scene_.record->robots[i].mode, scene_.is_held(i)),
                  why(*scene_.record, i, scene_.circumstances).toHtmlEscaped())
             .arg(fixed(pose.x, 3), fixed(pose.y, 3), fixed(pose.theta * 180.0 / core::pi, 0))
             .arg(can_do(movable(robot)
                             ? tr("Drag to move it, wheel to turn it (Shift: 1° a notch), Shift+drag to kick it.")
                             : why_not(robot)));
}

/// What the mouse would do, or why it does nothing.
QString ArenaView::can_do(const QString& what) const {
  return fixed_.isEmpty() ? what : fixed_.toHtmlEscaped() + QLatin1Char('.');
}

}  // namespace skein::ui
