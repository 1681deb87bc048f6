#include "ui/arena/arena_other.h"

#include <cmath>

namespace skein::ui {

void paint_other(QPainter& painter, const OtherRun& other, const ArenaScene& scene, const ArenaMap& map,
                 const Colours& colours) {
  const auto at = [&](double x, double y) { return map.to_screen({x, y}); };
  for (std::size_t i = 0; i < other.trails.size(); ++i) {
    const auto& trail = other.trails[i];
    if (trail.empty()) continue;
    QColor pale = colours.robot(i);
    pale.setAlphaF(0.45F);
    painter.setPen(QPen(pale, 1.6, Qt::DotLine));
    painter.setBrush(Qt::NoBrush);
    QPolygonF line;
    for (const core::Pose& pose : trail) line << at(pose.x, pose.y);
    painter.drawPolyline(line);
    const core::Pose& now = trail.back();
    const QPointF centre = at(now.x, now.y);
    const double body = scene.radius(i);
    const QPointF edge = at(now.x + body * std::cos(now.theta), now.y + body * std::sin(now.theta));
    const double radius = std::hypot(edge.x() - centre.x(), edge.y() - centre.y());
    painter.setPen(QPen(pale, 2.0));
    painter.drawEllipse(centre, radius, radius);
    painter.drawLine(centre, edge);
  }
}

}  // namespace skein::ui
