#include "ui/arena/arena_other.h"

#include <cmath>

#include "ui/base/compared.h"

namespace skein::ui {

void paint_other(QPainter& painter, const OtherRun& other, const ArenaScene& scene, const ArenaMap& map,
                 const Colours& colours) {
  const auto at = [&](double x, double y) { return map.to_screen({x, y}); };
  QColor faint = colours.text;
  faint.setAlphaF(0.7F);
  for (std::size_t i = 0; i < other.trails.size(); ++i) {
    const auto& trail = other.trails[i];
    if (trail.empty()) continue;
    QColor pale = colours.robot(i);
    pale.setAlphaF(0.45F);
    painter.setPen(QPen(pale, 1.6, compared_style(other.number)));
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
    painter.setPen(faint);
    painter.drawText(QRectF(centre - QPointF(radius, radius), QSizeF(2 * radius, 2 * radius)), Qt::AlignCenter,
                     compared_letter(other.number));
  }
}

}  // namespace skein::ui
