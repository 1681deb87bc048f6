#include "ui/arena/arena_view.h"

#include <QApplication>
#include <QHelpEvent>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QToolTip>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>
#include <optional>

#include "ui/arena/arena_painter.h"
#include "ui/base/picture.h"
#include "ui/base/told.h"

namespace skein::ui {
namespace {

constexpr double zoom_step = 1.2;
constexpr double notch = 120.0;        // of a mouse wheel, in Qt's unit
constexpr qint64 same_nudge_ms = 400;  // the wheel keeps to a robot that drives away from under the pointer

/// Keys 1 to 9 mean the robots 0 to 8.
std::optional<int> robot_of(const QKeyEvent& key) {
  if (key.key() < Qt::Key_1 || key.key() > Qt::Key_9) return {};
  return key.key() - Qt::Key_1;
}

}  // namespace

ArenaView::ArenaView(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("arena"));
  tell(this, QAccessible::Canvas, [this] { return spoken(); });
  setAccessibleName(tr("Arena"));
  setAccessibleDescription(
      tr("The robots seen from above. Drag a simulated robot to move it, turn it with the wheel. With the keyboard: a "
         "number or N selects a robot, arrows move it, Page Up and Page Down turn it. With the tools kick, measure and "
         "obstacle, arrows move a cross, and Return presses there and lets go."));
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setAttribute(Qt::WA_OpaquePaintEvent);
}

void ArenaView::show_experiment(const app::Experiment& experiment) {
  end_gesture();
  nudge_.reset();
  scene_.reset(experiment);
  ground_ = {};
  camera_ = nullptr;
  choose_sheet();
}

void ArenaView::set_camera(ArenaMap::Camera camera) {
  camera_ = std::move(camera);
  choose_sheet();
}

void ArenaView::set_picture(const app::Picture& picture) {
  const bool first = scene_.picture.isNull();
  scene_.picture = image_of(picture);
  scene_.pictured_at = picture.captured_at;
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

void ArenaView::set_others(std::vector<OtherRun> others) {
  if (others.empty() && scene_.compared.empty()) return;
  scene_.compared = std::move(others);
  update();
}

void ArenaView::set_foreseen(std::vector<std::vector<core::Pose>> ways) {
  if (ways.empty() && scene_.foreseen.empty()) return;
  scene_.foreseen = std::move(ways);
  update();
}

void ArenaView::set_may_be_driving(std::vector<std::size_t> robots) {
  if (scene_.may_be_driving == robots) return;
  scene_.may_be_driving = std::move(robots);
  update();
}

void ArenaView::set_banner(const QString& text, bool alarms) {
  if (scene_.banner == text && scene_.banner_alarms == alarms) return;
  scene_.banner = text;
  scene_.banner_alarms = alarms;
  update();
}

void ArenaView::set_alert(const QString& text, const QColor& colour) {
  if (scene_.alert == text && scene_.alert_colour == colour) return;
  scene_.alert = text;
  scene_.alert_colour = colour;
  update();
}

void ArenaView::set_hint(const QString& text, bool gives_way) {
  if (scene_.hint == text && scene_.hint_gives_way == gives_way) return;
  scene_.hint = text;
  scene_.hint_gives_way = gives_way;
  update();
}

void ArenaView::set_circumstances(const Circumstances& circumstances) {
  scene_.circumstances = circumstances;
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

void ArenaView::show_couplings(bool on) {
  scene_.show_couplings = on;
  update();
}

void ArenaView::set_coupling(std::size_t i, std::size_t j, double strength) {
  const std::size_t pair = i * scene_.experiment.robots.size() + j;
  if (pair < scene_.couplings.size()) scene_.couplings[pair] = strength;
}

void ArenaView::show_grid(bool on) {
  scene_.show_grid = on;
  ground_ = {};
  update();
}

void ArenaView::set_tool(ArenaTool tool) {
  end_gesture();
  if (!kind(tool).measures) scene_.ruler.reset();
  scene_.cross.reset();
  tool_ = tool;
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
  if (robot >= 0) scene_.selected_obstacle = -1;  // keys go to one of them
  if (scene_.selected == robot) return;
  scene_.selected = robot;
  emit selected(robot);
  update();
}

void ArenaView::refresh() {
  if (nudge_ && (nudge_->turn != 0.0 || !nudge_->way.isNull()))
    request(*nudge_);
  else if (nudge_ && nudge_->since.elapsed() > same_nudge_ms)
    nudge_.reset();
  if (!scene_.record || scene_.record->now == painted_t_) return;
  painted_t_ = scene_.record->now;
  follow_tip();
  update();
}

void ArenaView::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setFont(font());
  const Colours c = colours(palette());
  ArenaPainter arena(painter, scene_, map_, c);
  if (map_.shows_picture())
    arena.paint_ground(rect());
  else
    painter.drawPixmap(0, 0, ground(c));
  arena.paint(rect());
}

/// Drawn once for many frames: it costs a quarter of one.
const QPixmap& ArenaView::ground(const Colours& colours) {
  const QSize pixels = (devicePixelRatioF() * QSizeF(size())).toSize();
  if (ground_.size() == pixels && ground_of_ == map_.sheet()) return ground_;
  ground_ = QPixmap(pixels);
  ground_.setDevicePixelRatio(devicePixelRatioF());
  ground_of_ = map_.sheet();
  QPainter painter(&ground_);
  painter.setFont(font());
  ArenaPainter(painter, scene_, map_, colours).paint_ground(rect());
  return ground_;
}

void ArenaView::changeEvent(QEvent* event) {
  ground_ = {};  // of other colours, or in another font
  QWidget::changeEvent(event);
}

void ArenaView::resizeEvent(QResizeEvent*) {
  map_.resize(size());
}

std::unique_ptr<ArenaGesture> ArenaView::begin_gesture(QPointF screen, Qt::KeyboardModifiers modifiers, QPoint global) {
  const QPointF floor = map_.to_floor(screen);
  if (kind(tool_).measures) return measure(scene_, floor);
  const int robot = robot_under(screen), obstacle = obstacle_under(screen);
  const bool takes_obstacle = obstacle >= 0 && (robot < 0 || kind(tool_).sets_obstacles);
  scene_.selected_obstacle = takes_obstacle ? obstacle : -1;
  if (takes_obstacle) return drag_obstacle(scene_, obstacle, floor);
  if (kind(tool_).sets_obstacles) return drop_obstacle(scene_, floor);
  select(robot);
  if (robot >= 0) {
    if (!may_take(robot, global)) return nullptr;
    const bool kicks = kind(tool_).kicks || modifiers & Qt::ShiftModifier;
    return kicks ? kick_robot(scene_, robot) : drag_robot(scene_, robot, floor);
  }
  if (const auto pair = coupling_under(screen)) emit coupling_clicked((*pair)[0], (*pair)[1]);
  return nullptr;
}

void ArenaView::mousePressEvent(QMouseEvent* event) {
  if (event->button() == Qt::MiddleButton || event->button() == Qt::RightButton) {
    end_gesture();
    panned_ = event->position();
    setCursor(Qt::SizeAllCursor);
    return;
  }
  if (event->button() != Qt::LeftButton) return;
  pressed_ = event->position().toPoint();
  moving_ = false;
  gesture_ = begin_gesture(event->position(), event->modifiers(), event->globalPosition().toPoint());
  if (gesture_ && kind(tool_).grasps) setCursor(Qt::ClosedHandCursor);
  update();
}

void ArenaView::mouseMoveEvent(QMouseEvent* event) {
  if (panned_) {
    map_.pan(event->position() - *panned_);
    panned_ = event->position();
    update();
    return;
  }
  if (!gesture_) return hover(event->position());
  moving_ =
      moving_ || (event->position().toPoint() - pressed_).manhattanLength() >= QApplication::startDragDistance() / 2;
  if (!moving_) return;
  gesture_->move(map_.to_floor(event->position()));
  update();
}

void ArenaView::hover(QPointF screen) {
  const int robot = robot_under(screen);
  const auto coupling = robot < 0 && kind(tool_).grasps && obstacle_under(screen) < 0
                            ? coupling_under(screen)
                            : std::optional<std::array<int, 2>>();
  if (kind(tool_).aims)
    setCursor(Qt::CrossCursor);
  else if (robot >= 0)
    setCursor(movable(robot) ? Qt::OpenHandCursor : Qt::ForbiddenCursor);
  else if (obstacle_under(screen) >= 0)
    setCursor(Qt::OpenHandCursor);
  else
    setCursor(coupling ? Qt::PointingHandCursor : Qt::ArrowCursor);
  if (robot == scene_.hovered && coupling == scene_.hovered_coupling) return;
  scene_.hovered = robot;
  scene_.hovered_coupling = coupling;
  update();
}

void ArenaView::mouseReleaseEvent(QMouseEvent* event) {
  if (panned_ && event->button() != Qt::LeftButton) {
    panned_.reset();
    unsetCursor();
    return;
  }
  if (!gesture_ || event->button() != Qt::LeftButton) return;
  gesture_->release(requests());
  end_gesture();
}

ArenaRequests ArenaView::requests() {
  return {[this](int robot, const core::Pose& pose) { emit move_wanted(robot, pose); },
          [this](int robot, QPointF velocity) { emit kick_wanted(robot, velocity); },
          [this](int number, const core::Obstacle& o) { emit obstacle_wanted(number, o); },
          [this](const QString& why) { emit refused(why); }};
}

void ArenaView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton && kind(tool_).grasps && robot_under(event->position()) < 0 &&
      obstacle_under(event->position()) < 0)
    fit();
  else
    mousePressEvent(event);
}

void ArenaView::end_gesture() {
  gesture_.reset();
  scene_.forget_gesture();
  unsetCursor();
  update();
}

void ArenaView::keyPressEvent(QKeyEvent* event) {
  // What the mouse does to the robot or obstacle that is selected, for those who have none.
  const bool fine = event->modifiers() & Qt::ShiftModifier;
  const double way = fine ? 0.002 : 0.02, angle = (fine ? 1.0 : 15.0) * core::pi / 180.0;
  const int robot = scene_.selected, robots = static_cast<int>(scene_.experiment.robots.size());
  const auto step = event->key() == Qt::Key_Left    ? QPointF(-way, 0)
                    : event->key() == Qt::Key_Right ? QPointF(way, 0)
                    : event->key() == Qt::Key_Up    ? QPointF(0, way)
                    : event->key() == Qt::Key_Down  ? QPointF(0, -way)
                                                    : QPointF();
  if (event->modifiers() & Qt::AltModifier && !step.isNull()) {
    constexpr double pan = 40.0;  // [px]
    map_.pan(QPointF(-step.x(), step.y()) / way * pan);
    return update();
  }
  if (!kind(tool_).grasps && point(*event, step)) return update();
  if (const auto asked = robot_of(*event)) {
    if (*asked < robots) select(*asked);
    return;
  }
  if (event->key() == Qt::Key_N && robots > 0)
    return select((std::max(robot, fine ? 0 : -1) + (fine ? robots - 1 : 1)) % robots);
  if (robot >= 0 && !step.isNull()) return nudge(robot, step);
  if (work_obstacle(*event)) return;
  if (robot >= 0 && (event->key() == Qt::Key_PageUp || event->key() == Qt::Key_PageDown)) {
    if (may_take(robot, {})) turn(robot, event->key() == Qt::Key_PageUp ? angle : -angle);
    return;
  }
  QWidget::keyPressEvent(event);
}

/// A tool without a mouse: false if the key is none of its.
bool ArenaView::point(const QKeyEvent& event, QPointF step) {
  if (const auto asked = robot_of(event)) {
    if (*asked >= static_cast<int>(scene_.experiment.robots.size())) return true;
    select(*asked);
    scene_.cross = {scene_.cross_at(), *asked};
    move_cross({});
    return true;
  }
  if (!step.isNull()) {
    move_cross(step);
    return true;
  }
  if (event.key() == Qt::Key_Return || event.key() == Qt::Key_Enter) {
    if (!event.isAutoRepeat()) press_at_cross();
    return true;
  }
  if (event.key() == Qt::Key_Backspace && gesture_) {
    end_gesture();
    return true;
  }
  return false;
}

void ArenaView::move_cross(QPointF step) {
  if (!scene_.cross) scene_.cross = {{}, scene_.selected};
  // A kick is drawn out of a robot that drives on: its arrow goes with the robot, and so does the cross.
  QPointF from = scene_.cross_at();
  if (scene_.kick)
    if (const auto pose = scene_.pose(static_cast<std::size_t>(scene_.kick->robot)))
      from = QPointF(pose->x, pose->y) + scene_.kick->way;
  if (!step.isNull()) scene_.cross = {inside_arena(scene_, from + step, 0.0), -1};
  if (gesture_) gesture_->move(scene_.cross_at());
}

void ArenaView::press_at_cross() {
  if (gesture_) {
    gesture_->release(requests());
    return end_gesture();
  }
  move_cross({});
  const QPointF floor = scene_.cross_at();
  gesture_ = begin_gesture(map_.to_screen(floor), Qt::NoModifier, {});
  if (gesture_ && kind(tool_).kicks) gesture_->move(floor);
}

/// The selected obstacle by keys: false if the key is none for it, or none is selected.
bool ArenaView::work_obstacle(const QKeyEvent& event) {
  const int obstacle = scene_.selected_obstacle;
  if (obstacle < 0) return false;
  if (event.key() == Qt::Key_Delete) {
    emit obstacle_wanted(obstacle, {});
    scene_.selected_obstacle = -1;
    return true;
  }
  if (event.key() != Qt::Key_PageUp && event.key() != Qt::Key_PageDown) return false;
  resize_obstacle(obstacle, event.key() == Qt::Key_PageUp ? 1.1 : 1 / 1.1);
  return true;
}

void ArenaView::focusInEvent(QFocusEvent* event) {
  scene_.has_keys = event->reason() != Qt::MouseFocusReason;
  QWidget::focusInEvent(event);
}

void ArenaView::focusOutEvent(QFocusEvent* event) {
  scene_.has_keys = false;
  QWidget::focusOutEvent(event);
}

QPoint ArenaView::place_of_keys() const {
  if (scene_.cross) return map_.to_screen(scene_.cross_at()).toPoint();
  if (scene_.selected >= 0)
    if (const auto pose = scene_.pose(static_cast<std::size_t>(scene_.selected)))
      return map_.to_screen({pose->x, pose->y}).toPoint();
  return rect().center();
}

ArenaView::Nudge& ArenaView::nudged(int robot) {
  if (!nudge_ || nudge_->robot != robot) nudge_ = Nudge{robot, 0.0, {}, {}, {}, {}};
  nudge_->since.start();
  return *nudge_;
}

void ArenaView::request(Nudge& nudge) {
  const auto robot = static_cast<std::size_t>(nudge.robot);
  const auto pose = scene_.pose(robot);
  if (!pose) return;
  if (nudge.turn != 0.0) nudge.heading = core::wrap_angle(nudge.heading.value_or(pose->theta) + nudge.turn);
  if (!nudge.way.isNull())
    nudge.place =
        inside_arena(scene_, nudge.place.value_or(QPointF(pose->x, pose->y)) + nudge.way, scene_.radius(robot));
  nudge.turn = 0.0;
  nudge.way = {};
  const QPointF place = nudge.place.value_or(QPointF(pose->x, pose->y));
  emit move_wanted(nudge.robot, {place.x(), place.y(), nudge.heading.value_or(pose->theta)});
}

void ArenaView::nudge(int robot, QPointF by) {
  if (may_take(robot, {})) nudged(robot).way += by;
}

void ArenaView::resize_obstacle(int number, double factor) {
  core::Obstacle obstacle = scene_.circumstances.obstacles[static_cast<std::size_t>(number)];
  constexpr double smallest = 0.01, largest = 0.3;  // by hand; the file's may be larger [m]
  const double before = obstacle.radius, asked = before * factor;
  obstacle.radius =
      factor > 1.0 ? std::max(before, std::min(asked, largest)) : std::min(before, std::max(asked, smallest));
  if (obstacle.radius != before) return emit obstacle_wanted(number, obstacle);
  emit refused((factor > 1.0 ? tr("Obstacle %1 stays as it is: by hand none gets a radius of more than %2 cm")
                             : tr("Obstacle %1 stays as it is: by hand none gets a radius of less than %2 cm"))
                   .arg(number + 1)
                   .arg(100 * (factor > 1.0 ? largest : smallest)));
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
  const int robot = nudge_ && (nudge_->heading || nudge_->turn != 0.0) ? nudge_->robot : robot_under(event->position());
  if (const int obstacle = obstacle_under(event->position()); robot < 0 && obstacle >= 0)
    return resize_obstacle(obstacle, std::pow(1.1, notches));
  if (robot < 0 || !may_take(robot, {})) return;
  const double degrees = event->modifiers() & Qt::ShiftModifier ? 1.0 : 15.0;
  turn(robot, notches * degrees * core::pi / 180.0);
}

void ArenaView::turn(int robot, double by) {
  nudged(robot).turn += by;
  select(robot);
}

void ArenaView::leaveEvent(QEvent*) {
  tip_.reset();  // whatever follows would keep it there
  scene_.hovered = -1;
  scene_.hovered_coupling.reset();
  update();
}

bool ArenaView::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QWidget::event(event);
  begin_tip(static_cast<QHelpEvent*>(event)->pos());
  return true;
}

}  // namespace skein::ui
