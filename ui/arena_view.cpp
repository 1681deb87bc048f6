#include "ui/arena_view.h"

#include <QApplication>
#include <QHelpEvent>
#include <QMouseEvent>
#include <QToolTip>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

#include "ui/arena_painter.h"
#include "ui/modes.h"

namespace skein::ui {
namespace {

constexpr double zoom_step = 1.2;
constexpr double notch = 120.0;       // of a mouse wheel, in Qt's unit
constexpr qint64 same_turn_ms = 400;  // the wheel keeps to a robot that drives away from under the pointer

}  // namespace

ArenaView::ArenaView(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("arena"));
  setAccessibleName(tr("Arena"));
  setAccessibleDescription(
      tr("The robots seen from above. Drag a simulated robot to move it, turn it with the wheel."));
  setMouseTracking(true);
  setFocusPolicy(Qt::ClickFocus);
  setAttribute(Qt::WA_OpaquePaintEvent);
}

void ArenaView::show_experiment(const app::Experiment& experiment) {
  cancel_drag();
  turn_.reset();
  scene_.reset(experiment);
  camera_ = nullptr;
  choose_sheet();
}

void ArenaView::set_camera(ArenaMap::Camera camera) {
  camera_ = std::move(camera);
  choose_sheet();
}

void ArenaView::take(const app::Picture& picture) {
  const bool first = scene_.picture.isNull();
  scene_.picture =
      QImage(picture.grey.data(), picture.width, picture.height, picture.width, QImage::Format_Grayscale8).copy();
  if (first) choose_sheet();
  if (scene_.show_picture) update();
}

void ArenaView::choose_sheet() {
  if (scene_.show_picture && camera_ && !scene_.picture.isNull())
    map_.show_picture(scene_.picture.size(), camera_);
  else
    map_.show_plan(scene_.experiment.arena_width, scene_.experiment.arena_height);
  update();
}

void ArenaView::set_banner(const QString& text, bool alarms) {
  if (scene_.banner == text && scene_.banner_alarms == alarms) return;
  scene_.banner = text;
  scene_.banner_alarms = alarms;
  update();
}

void ArenaView::set_hint(const QString& text) {
  if (scene_.hint == text) return;
  scene_.hint = text;
  update();
}

void ArenaView::show_picture(bool on) {
  scene_.show_picture = on;
  choose_sheet();
}

void ArenaView::show_regions(bool on) {
  scene_.show_regions = on;
  update();
}

void ArenaView::show_trails(bool on) {
  scene_.show_trails = on;
  update();
}

void ArenaView::fit() {
  map_.fit();
  update();
}

void ArenaView::zoom_in() {
  map_.zoom(zoom_step, rect().center());
  update();
}

void ArenaView::zoom_out() {
  map_.zoom(1 / zoom_step, rect().center());
  update();
}

void ArenaView::select(int robot) {
  if (scene_.selected == robot) return;
  scene_.selected = robot;
  emit selected(robot);
  update();
}

void ArenaView::refresh() {
  if (turn_ && turn_->by != 0.0) {
    if (const auto pose = scene_.pose(static_cast<std::size_t>(turn_->robot))) {
      const double theta = core::wrap_angle(turn_->asked.value_or(pose->theta) + turn_->by);
      turn_->asked = theta;
      turn_->by = 0.0;
      emit move_wanted(turn_->robot, {pose->x, pose->y, theta});
    }
  } else if (turn_ && turn_->since.elapsed() > same_turn_ms) {
    turn_.reset();
  }
  if (!scene_.record || scene_.record->now == painted_t_) return;
  painted_t_ = scene_.record->now;
  update();
}

void ArenaView::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setFont(font());
  const Colours c = colours(palette());
  ArenaPainter(painter, scene_, map_, c).paint(rect());
}

void ArenaView::resizeEvent(QResizeEvent*) {
  map_.resize(size());
}

int ArenaView::robot_under(QPointF screen) const {
  const QPointF floor = map_.to_floor(screen);
  // Zoomed out, a robot is small: some pixels around it still catch it.
  const double reach = std::max(robot_radius, 12.0 / map_.scale_at(floor));
  return scene_.robot_at(floor.x(), floor.y(), reach);
}

bool ArenaView::movable(int robot) const {
  return robot >= 0 && scene_.experiment.robots[static_cast<std::size_t>(robot)].simulated();
}

QString ArenaView::why_not(int robot) const {
  return tr("Robot %1 is a real one: put it in its new place by hand.").arg(robot + 1);
}

core::Pose ArenaView::inside_arena(QPointF floor, double theta) const {
  const double w = scene_.experiment.arena_width / 2 - robot_radius;
  const double h = scene_.experiment.arena_height / 2 - robot_radius;
  return {std::clamp(floor.x(), -w, w), std::clamp(floor.y(), -h, h), theta};
}

void ArenaView::mousePressEvent(QMouseEvent* event) {
  if (event->button() == Qt::MiddleButton || event->button() == Qt::RightButton) {
    cancel_drag();
    panned_ = event->position();
    setCursor(Qt::SizeAllCursor);
    return;
  }
  if (event->button() != Qt::LeftButton) return;
  const int robot = robot_under(event->position());
  select(robot);
  if (robot < 0) return;
  if (!movable(robot)) {
    emit refused(why_not(robot));
    QToolTip::showText(event->globalPosition().toPoint(), why_not(robot), this);
    return;
  }
  const core::Pose pose = *scene_.pose(static_cast<std::size_t>(robot));
  const QPointF grip = map_.to_floor(event->position()) - QPointF(pose.x, pose.y);
  drag_ = Drag{robot, event->position().toPoint(), grip, false};
  setCursor(Qt::ClosedHandCursor);
}

void ArenaView::mouseMoveEvent(QMouseEvent* event) {
  if (panned_) {
    map_.pan(event->position() - *panned_);
    panned_ = event->position();
    update();
    return;
  }
  if (drag_) {
    const auto robot = static_cast<std::size_t>(drag_->robot);
    drag_->moving = drag_->moving || (event->position().toPoint() - drag_->from).manhattanLength() >=
                                         QApplication::startDragDistance() / 2;
    if (!drag_->moving) return;
    const double theta = scene_.pose(robot).value_or(core::Pose{}).theta;
    scene_.ghost = {drag_->robot, inside_arena(map_.to_floor(event->position()) - drag_->grip, theta)};
    update();
    return;
  }
  const int hovered = robot_under(event->position());
  if (hovered == scene_.hovered) return;
  scene_.hovered = hovered;
  setCursor(movable(hovered) ? Qt::OpenHandCursor : hovered >= 0 ? Qt::ForbiddenCursor : Qt::ArrowCursor);
  update();
}

void ArenaView::mouseReleaseEvent(QMouseEvent* event) {
  if (panned_ && event->button() != Qt::LeftButton) {
    panned_.reset();
    unsetCursor();
    return;
  }
  if (!drag_ || event->button() != Qt::LeftButton) return;
  const auto ghost = scene_.ghost;
  cancel_drag();
  if (!ghost) return;
  // It has driven on meanwhile, and turned: it keeps the heading that it has now.
  const auto now = scene_.pose(static_cast<std::size_t>(ghost->robot));
  emit move_wanted(ghost->robot, {ghost->pose.x, ghost->pose.y, now ? now->theta : ghost->pose.theta});
}

void ArenaView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton && robot_under(event->position()) < 0)
    fit();
  else
    mousePressEvent(event);
}

void ArenaView::cancel_drag() {
  drag_.reset();
  scene_.ghost.reset();
  unsetCursor();
  update();
}

void ArenaView::wheelEvent(QWheelEvent* event) {
  // Some platforms turn Shift + wheel sideways.
  const QPoint delta = event->angleDelta();
  const double notches = (delta.y() != 0 ? delta.y() : delta.x()) / notch;
  event->accept();
  if (event->modifiers() & Qt::ControlModifier) {
    map_.zoom(std::pow(zoom_step, notches), event->position());
    update();
    return;
  }
  const int robot = turn_ ? turn_->robot : robot_under(event->position());
  if (robot < 0) return;
  if (!movable(robot)) {
    emit refused(why_not(robot));
    return;
  }
  const double degrees = event->modifiers() & Qt::ShiftModifier ? 1.0 : 15.0;
  turn(robot, notches * degrees * core::pi / 180.0);
}

void ArenaView::turn(int robot, double by) {
  if (!turn_ || turn_->robot != robot) turn_ = Turn{robot, 0.0, std::nullopt, {}};
  turn_->by += by;
  turn_->since.start();
  select(robot);
}

void ArenaView::leaveEvent(QEvent*) {
  scene_.hovered = -1;
  update();
}

bool ArenaView::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QWidget::event(event);
  const auto* help = static_cast<QHelpEvent*>(event);
  const int robot = robot_under(help->pos());
  if (robot < 0 || !scene_.record) {
    QToolTip::hideText();
    return true;
  }
  const auto i = static_cast<std::size_t>(robot);
  const core::Pose pose = scene_.pose(i).value_or(core::Pose{});
  QToolTip::showText(
      help->globalPos(),
      tr("<b>Robot %1</b> (tag %2): %3<br>x %4 m, y %5 m, heading %6°<br>%7")
          .arg(robot + 1)
          .arg(scene_.experiment.robots[i].tag)
          .arg(mode_text(scene_.record->robots[i].mode))
          .arg(pose.x, 0, 'f', 3)
          .arg(pose.y, 0, 'f', 3)
          .arg(pose.theta * 180.0 / core::pi, 0, 'f', 0)
          .arg(movable(robot) ? tr("Drag to move it, wheel to turn it (Shift: 1° a notch).") : why_not(robot)),
      this);
  return true;
}

}  // namespace skein::ui
