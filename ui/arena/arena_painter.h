#pragma once

#include <QPainter>
#include <functional>
#include <utility>
#include <vector>

#include "ui/arena/arena_map.h"
#include "ui/arena/arena_scene.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// Draws an ArenaScene, from the floor up.
class ArenaPainter {
 public:
  ArenaPainter(QPainter& painter, const ArenaScene& scene, const ArenaMap& map, const Colours& colours)
      : p_(painter), scene_(scene), map_(map), c_(colours) {}

  /// Floor, grid, bounds and path, or the camera's picture: what lies below everything that moves.
  void paint_ground(const QRectF& widget);
  void paint(const QRectF& widget);  ///< everything above

 private:
  void floor(const QRectF& widget);
  void grid();
  void bounds_and_path();
  void obstacles();
  void trails();
  void regions();
  void couplings();
  void references();
  void robots();
  void robot(const core::Pose& pose, std::size_t i, double opacity);
  void number(const core::Pose& pose, std::size_t i, double opacity, std::vector<QRectF>* others = nullptr);
  QPointF rim(const core::Pose& pose, double radius, double turn) const;
  static QPointF badge_place(QPointF centre, double robot);
  double badge_radius(double robot) const;
  void badge(QPointF centre, const QString& symbol, const QColor& colour, double robot);
  void ghost();
  void kick();
  void ruler();
  void keyboard(const QRectF& widget);
  void note(QPointF centre, const QString& text);
  void scale_bar(const QRectF& widget);
  void legend(const QRectF& widget);
  double chip(const QRectF& where, const QString& text, const QColor& background, const QColor& ink, bool bold);
  QSizeF chip_size(const QString& text, double width, bool bold) const;
  void messages(const QRectF& widget);
  std::size_t hidden_by(const QRectF& card) const;
  QRectF freest(const QRectF& widget, const std::function<QSizeF(double)>& size_in, bool low) const;

  QPointF at(double x, double y) const { return map_.to_screen({x, y}); }

  QPainter& p_;
  const ArenaScene& scene_;
  const ArenaMap& map_;
  const Colours& c_;
  QRectF scale_;                 // where the scale stands
  std::vector<QRectF> written_;  // messages and notes, which others should not cover
  struct Body {
    QPointF centre;
    double radius;  // [px]
    std::size_t weight;
  };
  std::vector<Body> bodies_;  // robots and obstacles, which messages should not hide
};

}  // namespace skein::ui
