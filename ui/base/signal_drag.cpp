#include "ui/base/signal_drag.h"

#include <QApplication>
#include <QMouseEvent>
#include <utility>

namespace skein::ui {

SignalDrag::SignalDrag(QAbstractItemView* table, Target target)
    : QObject(table), table_(table), target_(std::move(target)) {
  table_->viewport()->installEventFilter(this);
}

bool SignalDrag::eventFilter(QObject* watched, QEvent* event) {
  const QEvent::Type type = event->type();
  if (type != QEvent::MouseButtonPress && type != QEvent::MouseMove && type != QEvent::MouseButtonRelease)
    return QObject::eventFilter(watched, event);
  const auto* const mouse = static_cast<const QMouseEvent*>(event);
  if (type == QEvent::MouseMove) return move(*mouse);
  const bool left = mouse->button() == Qt::LeftButton;
  if (type == QEvent::MouseButtonRelease) return left && end(mouse->globalPosition().toPoint());
  names_.clear();
  if (left) begin(mouse->position().toPoint());
  return false;
}

void SignalDrag::begin(const QPoint& where) {
  drags_ = false;
  pressed_at_ = where;
  names_ = table_->indexAt(where).data(plotted_role).toStringList();
}

/// From the first move on it is not the table's: that would select other rows on the way.
bool SignalDrag::move(const QMouseEvent& event) {
  if (names_.isEmpty() || !(event.buttons() & Qt::LeftButton)) return false;
  const QPoint way = event.position().toPoint() - pressed_at_;
  drags_ = drags_ || way.manhattanLength() >= QApplication::startDragDistance();
  if (!drags_) return true;
  const bool welcome = target_.over(names_, event.globalPosition().toPoint());
  table_->viewport()->setCursor(welcome ? Qt::DragCopyCursor : Qt::ClosedHandCursor);
  return true;
}

bool SignalDrag::end(const QPoint& where) {
  const QStringList names = std::exchange(names_, {});
  if (!std::exchange(drags_, false)) return false;
  table_->viewport()->unsetCursor();
  target_.drop(names, where);
  return true;
}

}  // namespace skein::ui
