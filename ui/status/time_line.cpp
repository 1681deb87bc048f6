#include "ui/status/time_line.h"

#include <QHelpEvent>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QToolTip>
#include <algorithm>
#include <cmath>

#include "ui/base/number_text.h"
#include "ui/base/palette.h"
#include "ui/base/sentence.h"
#include "ui/base/told.h"

namespace skein::ui {
namespace {

constexpr double end = 10;  // free at either end, for half a mark [px]
constexpr double bar_height = 8;

}  // namespace

TimeLine::TimeLine(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("time_line"));
  tell(this, QAccessible::ProgressBar,
       [this] { return tr("%1 s of %2 s").arg(t_, 0, 'f', 1).arg(duration_, 0, 'f', 1); });
  setAccessibleName(tr("Progress of the run"));
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Preferred);
}

void TimeLine::set_flat(bool flat) {
  flat_ = flat;
  setSizePolicy(QSizePolicy::Expanding, flat ? QSizePolicy::Fixed : QSizePolicy::Preferred);
  updateGeometry();
}

void TimeLine::show_experiment(const app::Experiment& experiment) {
  duration_ = experiment.duration;
  t_ = 0.0;
  marks_.clear();
  for (const app::Perturbation& p : experiment.perturbations)
    marks_.push_back({p.t, static_cast<int>(p.robot),
                      tr("%1 s: robot %2 is moved by (%3, %4) cm, %5°")
                          .arg(p.t)
                          .arg(p.robot + 1)
                          .arg(fixed(p.dx * 100, 1), fixed(p.dy * 100, 1), fixed(p.dtheta * 180 / core::pi, 0))});
  for (const app::GainChange& change : experiment.gain_changes)
    marks_.push_back({change.t, -1, tr("%1 s: the gains change").arg(change.t)});
  for (const app::OperatorAction& action : experiment.actions) {
    const bool of_robot = app::is<app::events::Move, app::events::Kick>(action.event);
    marks_.push_back({action.t, of_robot ? static_cast<int>(*app::robot_of(action.event)) : -1,
                      tr("%1 s: %2").arg(action.t).arg(sentence(action.event))});
  }
  update();
}

void TimeLine::set_scrubbable(bool on, const RunHistory::Rows& rows) {
  scrubbable_ = on;
  setFocusPolicy(on ? Qt::StrongFocus : Qt::NoFocus);
  setCursor(on ? Qt::PointingHandCursor : Qt::ArrowCursor);
  setAccessibleName(on ? tr("Time of the replay: arrow keys move forward and back") : tr("Progress of the run"));
  events_.clear();
  if (!on) return update();
  for (const auto& row : rows)
    if (!row->events.empty() && (events_.empty() || row->t > events_.back())) events_.push_back(row->t);
  if (!rows.empty()) duration_ = std::max(rows.back()->t, 1e-3);
  std::erase_if(marks_, [this](const Mark& mark) { return mark.t > duration_; });  // the run ended before it
  update();
}

void TimeLine::mousePressEvent(QMouseEvent* event) {
  if (scrubbable_ && event->button() == Qt::LeftButton) emit time_wanted(time_at(event->position().x()));
}

void TimeLine::mouseMoveEvent(QMouseEvent* event) {
  if (scrubbable_ && (event->buttons() & Qt::LeftButton)) emit time_wanted(time_at(event->position().x()));
}

void TimeLine::keyPressEvent(QKeyEvent* event) {
  constexpr double small = 1.0, big = 10.0;  // [s]
  const int key = event->key();
  const bool control = event->modifiers() & Qt::ControlModifier;
  if (!scrubbable_) return QWidget::keyPressEvent(event);
  if (control && key == Qt::Key_Right) {
    const auto next = std::upper_bound(events_.begin(), events_.end(), t_ + 1e-6);
    if (next != events_.end()) emit time_wanted(*next);
  } else if (control && key == Qt::Key_Left) {
    const auto next = std::lower_bound(events_.begin(), events_.end(), t_ - 1e-6);
    if (next != events_.begin()) emit time_wanted(*std::prev(next));
  } else if (key == Qt::Key_Right || key == Qt::Key_Left) {
    emit time_wanted(t_ + (key == Qt::Key_Right ? small : -small));
  } else if (key == Qt::Key_PageUp || key == Qt::Key_PageDown) {
    emit time_wanted(t_ + (key == Qt::Key_PageUp ? big : -big));
  } else if (key == Qt::Key_Home || key == Qt::Key_End) {
    emit time_wanted(key == Qt::Key_Home ? 0.0 : duration_);
  } else {
    QWidget::keyPressEvent(event);
  }
}

void TimeLine::show_record(const app::TickRecord& record) {
  if (record.t == t_) return;
  t_ = record.t;
  update();
}

double TimeLine::x(double t) const {
  return end + std::clamp(t / duration_, 0.0, 1.0) * (width() - 2 * end);
}

double TimeLine::time_at(double pixel) const {
  return std::clamp((pixel - end) / std::max(1.0, width() - 2 * end), 0.0, 1.0) * duration_;
}

void TimeLine::paintEvent(QPaintEvent*) {
  QPainter p(this);
  p.setRenderHint(QPainter::Antialiasing);
  const Colours c = colours(palette());
  const double middle = height() / 2.0;
  const QRectF bar(end, middle - bar_height / 2, width() - 2 * end, bar_height);
  p.setPen(Qt::NoPen);
  p.setBrush(c.dark ? c.panel.lighter(150) : c.panel.darker(112));
  p.drawRoundedRect(bar, bar_height / 2, bar_height / 2);
  p.setBrush(c.accent);
  if (t_ > 0) p.drawRoundedRect(QRectF(bar.topLeft(), QPointF(x(t_), bar.bottom())), bar_height / 2, bar_height / 2);

  p.setPen(QPen(c.axis, 1));
  for (const double t : events_) p.drawLine(QPointF(x(t), bar.top() - 4), QPointF(x(t), bar.bottom() + 4));
  p.setPen(Qt::NoPen);

  QFont small = font();
  small.setPointSizeF(std::max(9.0, font().pointSizeF() - 1));
  small.setBold(true);
  p.setFont(small);
  for (const Mark& mark : marks_) {
    const QPointF at(x(mark.t), middle);
    const QColor colour = mark.robot >= 0 ? c.robot(static_cast<std::size_t>(mark.robot)) : c.faint_text;
    const double r = mark.robot >= 0 ? 8.5 : 5.0;
    p.setPen(QPen(c.panel, 1.5));
    p.setBrush(colour);
    p.drawEllipse(at, r, r);
    if (mark.robot < 0) continue;
    p.setPen(ink_on(colour));
    p.drawText(QRectF(at - QPointF(r, r), QSizeF(2 * r, 2 * r)), Qt::AlignCenter, QString::number(mark.robot + 1));
  }
  if (!scrubbable_) return;
  p.setPen(QPen(c.panel, 2));  // the handle
  p.setBrush(c.accent);
  const double tall = std::min(13.0, middle);
  p.drawRoundedRect(QRectF(x(t_) - 5, middle - tall, 10, 2 * tall), 4, 4);
  if (hasFocus()) {
    p.setPen(QPen(c.accent, 1, Qt::DotLine));
    p.setBrush(Qt::NoBrush);
    p.drawRoundedRect(QRectF(rect()).adjusted(1, 1, -1, -1), 4, 4);
  }
}

bool TimeLine::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QWidget::event(event);
  const auto* help = static_cast<QHelpEvent*>(event);
  for (const Mark& mark : marks_)
    if (std::abs(help->pos().x() - x(mark.t)) < 9) {
      QToolTip::showText(help->globalPos(), mark.text, this);
      return true;
    }
  QToolTip::showText(help->globalPos(), tr("%1 s of %2 s").arg(t_, 0, 'f', 1).arg(duration_), this);
  return true;
}

}  // namespace skein::ui
