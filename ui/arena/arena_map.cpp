#include "ui/arena/arena_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein::ui {
namespace {

constexpr double margin = 14.0;  // around the sheet when it fits [px]
constexpr double closest = 30.0;

}  // namespace

void ArenaMap::show_plan(double width, double height) {
  camera_ = nullptr;
  sheet_ = QRectF(-width / 2, -height / 2, width, height);
  fit();
}

void ArenaMap::show_picture(QSizeF picture, Camera camera) {
  camera_ = std::move(camera);
  sheet_ = QRectF(QPointF(-0.5, -0.5), picture);  // (0, 0) is the centre of the first pixel
  fit();
}

void ArenaMap::fit() {
  zoom_ = 1.0;
  centre_ = sheet_.center();
}

double ArenaMap::scale() const {
  const double across = std::max(1.0, screen_.width() - 2 * margin) / sheet_.width();
  const double down = std::max(1.0, screen_.height() - 2 * margin) / sheet_.height();
  return zoom_ * std::min(across, down);
}

QPointF ArenaMap::from_sheet(QPointF sheet) const {
  return QPointF(screen_.width() / 2, screen_.height() / 2) + (sheet - centre_) * scale();
}

void ArenaMap::zoom(double factor, QPointF anchor) {
  const QPointF from_centre = anchor - QPointF(screen_.width() / 2, screen_.height() / 2);
  const QPointF under_anchor = centre_ + from_centre / scale();
  zoom_ = std::clamp(zoom_ * factor, 1.0, closest);
  centre_ = under_anchor - from_centre / scale();
  pan({});
}

void ArenaMap::pan(QPointF by) {
  centre_ -= by / scale();
  // The middle of the screen stays on the sheet: nobody gets lost.
  centre_.setX(std::clamp(centre_.x(), sheet_.left(), sheet_.right()));
  centre_.setY(std::clamp(centre_.y(), sheet_.top(), sheet_.bottom()));
  if (zoom_ == 1.0 && by.isNull()) centre_ = sheet_.center();
}

QPointF ArenaMap::to_floor(QPointF screen) const {
  const QPointF target = centre_ + (screen - QPointF(screen_.width() / 2, screen_.height() / 2)) / scale();
  if (!camera_) return {target.x(), -target.y()};
  // The camera tells only floor -> picture. Newton's steps turn that round: the map is smooth and nearly straight, so a
  // handful reach a thousandth of a pixel.
  constexpr double h = 1e-4;
  QPointF floor(0.0, 0.0);
  for (int step = 0; step < 20; ++step) {
    const QPointF here = camera_(floor);
    const QPointF miss = target - here;
    if (std::hypot(miss.x(), miss.y()) < 1e-3) break;
    const QPointF dx = (camera_(floor + QPointF(h, 0)) - here) / h;
    const QPointF dy = (camera_(floor + QPointF(0, h)) - here) / h;
    const double determinant = dx.x() * dy.y() - dy.x() * dx.y();
    if (std::abs(determinant) < 1e-9) break;
    floor += QPointF(miss.x() * dy.y() - dy.x() * miss.y(), dx.x() * miss.y() - miss.x() * dx.y()) / determinant;
  }
  return floor;
}

double ArenaMap::scale_at(QPointF floor) const {
  constexpr double h = 0.01;
  const QPointF across = to_screen(floor + QPointF(h, 0)) - to_screen(floor - QPointF(h, 0));
  return std::hypot(across.x(), across.y()) / (2 * h);
}

QPolygonF ArenaMap::outline(QPointF centre, double a, double b, double p) const {
  constexpr int most = 64;
  constexpr double finest = 0.1;  // how far a side of the polygon may be from the curve [px]
  const bool ellipse = p == 2.0;
  const double radius = std::max(a, b) * scale_at(centre);
  // A quarter at least, and four times as many, so that the four extreme points are corners.
  const int corners =
      ellipse ? std::clamp(4 * static_cast<int>(std::ceil(std::numbers::pi / 4 * std::sqrt(radius / (2 * finest)))), 12,
                           most)
              : most;
  const auto along = [&](double x) { return ellipse ? x : std::copysign(std::pow(std::abs(x), 2 / p), x); };
  QPolygonF polygon;
  polygon.reserve(corners + 1);
  for (int k = 0; k <= corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners;
    polygon << to_screen(centre + QPointF(a * along(std::cos(angle)), b * along(std::sin(angle))));
  }
  return polygon;
}

}  // namespace skein::ui
