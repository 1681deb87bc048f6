#include "ui/status/stop_guard.h"

#include <QAbstractButton>
#include <QApplication>
#include <QDialog>
#include <QKeyEvent>
#include <QLineEdit>
#include <QMenu>
#include <QMouseEvent>
#include <QPlainTextEdit>
#include <QToolButton>
#include <QWindow>

#include "ui/base/dialogs.h"

namespace skein::ui {

namespace {

/// Return presses the button that has the focus: Space, which would elsewhere, is STOP here.
bool press_focused_button() {
  auto* button = qobject_cast<QAbstractButton*>(QApplication::focusWidget());
  if (!button || !button->isEnabled()) return false;
  auto* tool = qobject_cast<QToolButton*>(button);
  if (tool && tool->menu() && tool->popupMode() == QToolButton::InstantPopup)
    tool->showMenu();
  else
    button->click();
  return true;
}

/// True where a key that arrives at `watched`, a widget or a window of the system, goes to `window` itself and not to a
/// dialog in front of it.
bool is_in(const QObject* watched, const QWidget* window) {
  const auto* widget = qobject_cast<const QWidget*>(watched);
  return widget ? widget->window() == window : watched == window->windowHandle();
}

}  // namespace

StopGuard::StopGuard(Calls calls, QWidget* button, QObject* parent)
    : QObject(parent), calls_(std::move(calls)), button_(button) {
  qApp->installEventFilter(this);
}

bool StopGuard::stop() {
  if (!calls_.stop()) return false;
  while (QWidget* popup = QApplication::activePopupWidget()) {
    popup->close();
    if (popup == QApplication::activePopupWidget()) break;  // it does not close
  }
  return true;
}

bool StopGuard::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::KeyPress && (watched->isWidgetType() || watched->isWindowType())) {
    const auto* key = static_cast<const QKeyEvent*>(event);
    if (key->key() == Qt::Key_Return || key->key() == Qt::Key_Enter)
      return watched->isWidgetType() && !QApplication::activePopupWidget() && !key->isAutoRepeat() &&
             key->modifiers() == Qt::NoModifier && press_focused_button();
    if (key->key() != Qt::Key_Space && key->key() != Qt::Key_Escape) return false;
    const bool closes_something = QApplication::activePopupWidget() || (button_ && !is_in(watched, button_->window()));
    if (key->key() == Qt::Key_Escape && closes_something && calls_.all_stand()) return false;
    const bool stopped_something = !key->isAutoRepeat() && stop();  // a key held down stops once
    if (stopped_something) return true;
    // Space must not press a button: held down for STOP, it would go on to press whichever has the focus.
    const QWidget* focus = QApplication::focusWidget();
    const bool types = qobject_cast<const QLineEdit*>(focus) || qobject_cast<const QPlainTextEdit*>(focus);
    if (key->key() != Qt::Key_Space || types) return false;
    if (!key->isAutoRepeat()) calls_.space();
    return true;
  }
  if (event->type() == QEvent::Show && !event->spontaneous() && button_ && button_->isVisible()) {
    auto* dialog = qobject_cast<QDialog*>(watched);
    if (dialog && dialog->isWindow()) keep_clear_of(dialog, *button_);
  }
  // A window that was opened with a file is placed, and sized, after the dialog that it opens with.
  const bool is_placed = event->type() == QEvent::Move || event->type() == QEvent::Resize;
  if (is_placed && button_ && watched == button_->window() && button_->isVisible())
    for (auto* dialog : button_->window()->findChildren<QDialog*>())
      if (dialog->isWindow() && dialog->isVisible()) keep_clear_of(dialog, *button_);
  if (event->type() == QEvent::EnabledChange)
    if (auto* menu = qobject_cast<QMenu*>(watched); menu && menu->isVisible() && !menu->isEnabled()) menu->close();
  if (event->type() == QEvent::MouseButtonPress && button_ && button_->isVisible() && watched != button_) {
    // An open menu would take the press only to close itself.
    const auto* press = static_cast<const QMouseEvent*>(event);
    const QPoint where = button_->mapFromGlobal(press->globalPosition().toPoint());
    if (QApplication::activePopupWidget() && button_->rect().contains(where)) stop();
  }
  return false;
}

}  // namespace skein::ui
