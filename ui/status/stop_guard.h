#pragma once

#include <QObject>
#include <QPointer>
#include <QWidget>
#include <functional>

namespace skein::ui {

/// Sees every key and every press of the mouse before any widget does, and turns Space, Esc and a press on the STOP
/// button into STOP: whatever has the focus, whatever dialog or menu is open. A shortcut is not enough: a spin box, a
/// menu or a button with the focus may take the key first. Because Space presses no button then, Return does. No dialog
/// opens over the STOP button; and an open menu is closed when it is disabled, as at the end of a run: it would go on
/// to take every key and every press of the mouse, without closing.
class StopGuard final : public QObject {
  Q_OBJECT

 public:
  struct Calls {
    /// Called for every such press; returns whether robots could have been moving. If so, the key is consumed; if not,
    /// Esc goes on to its own receiver and Space to a text that is being typed (a blank in a file name).
    std::function<bool()> stop;
    /// Nothing moves or is about to: then Esc closes the dialog or menu that is open, and stops nothing.
    std::function<bool()> all_stand;
    /// Called for Space when nothing could be stopped and no text is being typed.
    std::function<void()> space;
  };
  StopGuard(Calls calls, QWidget* button, QObject* parent);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  /// Calls `stop`; where it stopped something, open menus and lists are closed: they would take the keys that follow.
  bool stop();

  Calls calls_;
  QPointer<QWidget> button_;
};

}  // namespace skein::ui
