#pragma once

#include <QElapsedTimer>
#include <QWidget>
#include <functional>
#include <optional>

#include "app/session.h"
#include "ui/arena_map.h"
#include "ui/arena_scene.h"

namespace skein::ui {

/// The arena, seen from above, and the operator's hand in it: a simulated robot is dragged to a new place, and turned
/// with the mouse wheel.
class ArenaView final : public QWidget {
  Q_OBJECT

 public:
  explicit ArenaView(QWidget* parent = nullptr);

  void show_experiment(const app::Experiment& experiment);
  /// Where floor points stand in the camera's picture; none: there is no camera.
  void set_camera(ArenaMap::Camera camera);
  void take(const app::TickRecord& record) { scene_.take(record); }
  void take(const app::Picture& picture);
  void set_banner(const QString& text, bool alarms);
  void set_hint(const QString& text);

  bool shows_picture() const { return scene_.show_picture; }
  void show_picture(bool on);
  void show_regions(bool on);
  void show_trails(bool on);
  void fit();
  void zoom_in();
  void zoom_out();

  const ArenaMap& map() const { return map_; }
  const ArenaScene& scene() const { return scene_; }
  QSize minimumSizeHint() const override { return {320, 240}; }
  QSize sizeHint() const override { return {620, 500}; }

 public slots:
  void select(int robot);  ///< from 0; -1: none
  void refresh();          ///< thirty times a second: paints what is new, sends what the wheel has turned

 signals:
  void move_wanted(int robot, const skein::core::Pose& pose);
  void selected(int robot);
  void refused(const QString& why);

 protected:
  void paintEvent(QPaintEvent*) override;
  void resizeEvent(QResizeEvent*) override;
  void mousePressEvent(QMouseEvent*) override;
  void mouseMoveEvent(QMouseEvent*) override;
  void mouseReleaseEvent(QMouseEvent*) override;
  void mouseDoubleClickEvent(QMouseEvent*) override;
  void wheelEvent(QWheelEvent*) override;
  void leaveEvent(QEvent*) override;
  bool event(QEvent*) override;

 private:
  int robot_under(QPointF screen) const;
  bool movable(int robot) const;
  QString why_not(int robot) const;
  core::Pose inside_arena(QPointF floor, double theta) const;
  void turn(int robot, double by);
  void cancel_drag();
  void choose_sheet();

  ArenaMap map_;
  ArenaMap::Camera camera_;
  ArenaScene scene_;
  double painted_t_ = -1.0;

  struct Drag {
    int robot;
    QPoint from;
    QPointF grip;  // from the robot's middle to the mouse, on the floor
    bool moving;
  };
  std::optional<Drag> drag_;
  std::optional<QPointF> panned_;

  // Several notches of the wheel come between two ticks: the next one turns on from what the last one asked for.
  struct Turn {
    int robot;
    double by;
    std::optional<double> asked;
    QElapsedTimer since;
  };
  std::optional<Turn> turn_;
};

}  // namespace skein::ui
