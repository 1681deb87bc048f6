#pragma once

#include <QElapsedTimer>
#include <QPixmap>
#include <QWidget>
#include <memory>
#include <optional>

#include "app/session/session.h"
#include "ui/arena/arena_gestures.h"
#include "ui/arena/arena_map.h"
#include "ui/arena/arena_scene.h"

namespace skein::ui {

struct Colours;

/// The arena, seen from above, and the operator's hand in it: simulated robots are dragged, turned with the mouse wheel
/// and kicked, obstacles dropped and dragged, distances measured, couplings switched with a click. Without a mouse the
/// arrow keys move the selected robot or, with any tool except the hand, a cross, at which Return presses and releases.
class ArenaView final : public QWidget {
  Q_OBJECT

 public:
  explicit ArenaView(QWidget* parent = nullptr);

  void show_experiment(const app::Experiment& experiment);
  /// Where floor points stand in the camera's picture; none: there is no camera.
  void set_camera(ArenaMap::Camera camera);
  void show_record(const app::TickRecord& record) { scene_.show_record(record); }
  void set_picture(const app::Picture& picture);
  void set_unseen(const std::vector<app::UnseenTag>& tags) { unseen_ = tags; }  ///< by robot: why it is not seen
  void set_may_be_driving(std::vector<std::size_t> robots);  ///< from 0: their stop was not acknowledged
  void set_others(std::vector<OtherRun> others);             ///< drawn pale
  /// Where every robot would go from now on, drawn pale; empty: not requested.
  void set_foreseen(std::vector<std::vector<core::Pose>> ways);
  void set_banner(const QString& text, bool alarms);
  void set_alert(const QString& text, const QColor& colour);
  /// `gives_way`: it is not shown where it would lie over a robot.
  void set_hint(const QString& text, bool gives_way = false);
  /// Why nothing can be changed here now, for the tips; empty: the mouse can.
  void set_fixed(const QString& why) { fixed_ = why; }
  /// After a jump in time.
  void set_circumstances(const Circumstances& circumstances);

  bool shows_picture() const { return scene_.show_picture; }
  void show_picture(bool on);
  void show_regions(bool on);
  void show_trails(bool on);
  void show_couplings(bool on);
  void show_grid(bool on);
  void set_tool(ArenaTool tool);
  ArenaTool tool() const { return tool_; }
  /// Of robots i < j, from 0: how wide the line between them is, 0 (off: a dotted trace) to about 1.
  void set_coupling(std::size_t i, std::size_t j, double strength);
  void fit();
  void zoom_in();
  void zoom_out();
  /// Where on this widget the keyboard is: its cross, the selected robot, or the middle.
  QPoint place_of_keys() const;

  const ArenaMap& map() const { return map_; }
  const ArenaScene& scene() const { return scene_; }
  QSize minimumSizeHint() const override { return {200, 150}; }
  /// Low: it takes the available room, but not that of the check list.
  QSize sizeHint() const override { return {620, 150}; }

 public slots:
  void select(int robot);  ///< from 0; -1: none
  void refresh();          ///< thirty times a second: paints what is new, sends the wheel's turns

 signals:
  void move_wanted(int robot, const skein::core::Pose& pose);
  void kick_wanted(int robot, QPointF velocity);                            ///< [m/s]
  void obstacle_wanted(int number, const skein::core::Obstacle& obstacle);  ///< -1: a new one; radius 0: remove it
  void coupling_clicked(int i, int j);
  void selected(int robot);
  void refused(const QString& why);

 protected:
  void paintEvent(QPaintEvent*) override;
  void changeEvent(QEvent*) override;
  void resizeEvent(QResizeEvent*) override;
  void mousePressEvent(QMouseEvent*) override;
  void mouseMoveEvent(QMouseEvent*) override;
  void mouseReleaseEvent(QMouseEvent*) override;
  void mouseDoubleClickEvent(QMouseEvent*) override;
  void wheelEvent(QWheelEvent*) override;
  void leaveEvent(QEvent*) override;
  void keyPressEvent(QKeyEvent*) override;
  void focusInEvent(QFocusEvent*) override;
  void focusOutEvent(QFocusEvent*) override;
  bool event(QEvent*) override;

 private:
  int robot_under(QPointF screen) const;
  int obstacle_under(QPointF screen) const;
  std::optional<std::array<int, 2>> coupling_under(QPointF screen) const;
  bool movable(int robot) const;
  bool may_take(int robot, QPoint where);
  QString why_not(int robot) const;
  QString tip_at(QPointF where) const;
  QString tip_of(int robot) const;
  QString can_do(const QString& what) const;
  QString spoken() const;
  void begin_tip(QPointF where);
  void follow_tip();
  std::unique_ptr<ArenaGesture> begin_gesture(QPointF screen, Qt::KeyboardModifiers modifiers, QPoint global);
  void hover(QPointF screen);
  bool point(const QKeyEvent& event, QPointF step);
  void press_at_cross();
  void move_cross(QPointF step);
  bool work_obstacle(const QKeyEvent& event);
  ArenaRequests requests();
  void turn(int robot, double by);
  void nudge(int robot, QPointF by);
  void resize_obstacle(int number, double factor);
  void end_gesture();
  void choose_sheet();
  const QPixmap& ground(const Colours& colours);

  ArenaMap map_;
  ArenaMap::Camera camera_;
  ArenaScene scene_;
  QPixmap ground_;    // floor, grid, bounds and path; null: to be drawn
  QRectF ground_of_;  // where the plan is in it
  double painted_t_ = -1.0;
  std::vector<app::UnseenTag> unseen_;
  struct Tip {
    QPointF at;  // on this widget, or from the robot that it goes with
    int robot;   // from 0; -1: none
    QString said;
  };
  std::optional<Tip> tip_;  // the newest: its text is kept up to date, and it goes with its robot
  QString fixed_;

  ArenaTool tool_ = ArenaTool::hand;
  std::unique_ptr<ArenaGesture> gesture_;
  QPoint pressed_;       // where the gesture began, on the screen
  bool moving_ = false;  // moved far enough from there not to be a click
  std::optional<QPointF> panned_;

  // Several notches of the wheel, or arrow keys, may come between two ticks: each continues from the heading or place
  // that the previous one requested.
  struct Nudge {
    int robot;
    double turn = 0.0;  // not requested yet [rad]
    QPointF way;        // [m]
    std::optional<double> heading;
    std::optional<QPointF> place;
    QElapsedTimer since;
  };
  Nudge& nudged(int robot);
  void request(Nudge& nudge);
  std::optional<Nudge> nudge_;
};

}  // namespace skein::ui
