#pragma once

#include <QPointF>
#include <QPolygonF>
#include <QRectF>
#include <QSizeF>
#include <functional>
#include <optional>

namespace skein::ui {

/// Maps points of the floor to the screen, and back. Two steps: floor -> sheet (a plan with y upwards, or the camera's
/// own picture, which is never bent), and sheet -> screen (fit, zoom, pan).
class ArenaMap {
 public:
  /// (x, y) on the floor -> pixel of the camera's picture.
  using Camera = std::function<QPointF(QPointF)>;

  void show_plan(double width, double height);       ///< of the arena [m]
  void show_picture(QSizeF picture, Camera camera);  ///< `camera` follows the lens, curved or not
  bool shows_picture() const { return static_cast<bool>(camera_); }

  void resize(QSizeF screen) { screen_ = screen; }
  void fit();
  void zoom(double factor, QPointF anchor);  ///< what is under the anchor stays there
  void pan(QPointF by);
  double zoomed() const { return zoom_; }

  QPointF to_screen(QPointF floor) const { return from_sheet(to_sheet(floor)); }
  QPointF to_floor(QPointF screen) const;
  /// Screen pixels per metre around this point.
  double scale_at(QPointF floor) const;
  /// The sheet's rectangle on the screen: of the plan, or of the picture.
  QRectF sheet() const { return {from_sheet(sheet_.topLeft()), from_sheet(sheet_.bottomRight())}; }
  /// A closed curve around a point of the floor: |dx/a|^p + |dy/b|^p = 1. p = 2 and a = b: a circle.
  QPolygonF outline(QPointF centre, double a, double b, double p = 2.0) const;

 private:
  QPointF to_sheet(QPointF floor) const { return camera_ ? camera_(floor) : QPointF(floor.x(), -floor.y()); }
  QPointF from_sheet(QPointF sheet) const;
  double scale() const;  // screen pixels per unit of the sheet

  QRectF sheet_{-1.0, -0.75, 2.0, 1.5};
  QSizeF screen_{1.0, 1.0};
  Camera camera_;
  double zoom_ = 1.0;
  QPointF centre_;  // point of the sheet in the middle of the screen
};

}  // namespace skein::ui
