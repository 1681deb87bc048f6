#include "ui/arena/arena_other.h"

#include <cmath>

#include "ui/base/compared.h"

namespace skein::ui {
namespace {

/// A robot's way and, at its end, the robot, hollow; `letter` in it.
void paint_way(QPainter& painter, const std::vector<core::Pose>& way, std::size_t robot, Qt::PenStyle style,
               const QString& letter, const ArenaScene& scene, const ArenaMap& map, const Colours& colours) {
  if (way.empty()) return;
  const auto at = [&](double x, double y) { return map.to_screen({x, y}); };
  QColor pale = colours.robot(robot), faint = colours.text;
  pale.setAlphaF(0.45F);
  faint.setAlphaF(0.7F);
  painter.setPen(QPen(pale, 1.6, style));
  painter.setBrush(Qt::NoBrush);
  QPolygonF line;
  for (const core::Pose& pose : way) line << at(pose.x, pose.y);
  painter.drawPolyline(line);
  const core::Pose& last = way.back();
  const QPointF centre = at(last.x, last.y);
  const double body = scene.radius(robot);
  const QPointF edge = at(last.x + body * std::cos(last.theta), last.y + body * std::sin(last.theta));
  const double radius = std::hypot(edge.x() - centre.x(), edge.y() - centre.y());
  painter.setPen(QPen(pale, 2.0));
  painter.drawEllipse(centre, radius, radius);
  painter.drawLine(centre, edge);
  painter.setPen(faint);
  painter.drawText(QRectF(centre - QPointF(radius, radius), QSizeF(2 * radius, 2 * radius)), Qt::AlignCenter, letter);
}

}  // namespace

void paint_other(QPainter& painter, const OtherRun& other, const ArenaScene& scene, const ArenaMap& map,
                 const Colours& colours) {
  for (std::size_t i = 0; i < other.trails.size(); ++i)
    paint_way(painter, other.trails[i], i, compared_style(other.number), compared_letter(other.number), scene, map,
              colours);
}

void paint_foreseen(QPainter& painter, const ArenaScene& scene, const ArenaMap& map, const Colours& colours) {
  for (std::size_t i = 0; i < scene.foreseen.size(); ++i)
    paint_way(painter, scene.foreseen[i], i, Qt::SolidLine, {}, scene, map, colours);
}

}  // namespace skein::ui
