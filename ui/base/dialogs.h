#pragma once

#include <QDialog>
#include <QFileDialog>
#include <QTextBrowser>
#include <functional>

namespace skein::ui {

/// What a file dialog asks for.
struct FileQuestion {
  QString title, name;   ///< `name`: of the dialog as an object
  QString filter;        ///< as QFileDialog's
  QString directory;     ///< where it begins; empty: where the program was started
  QString save_as;       ///< to write a file: the name that is proposed; empty: a file that exists is chosen
  QStringList places{};  ///< folders that are offered at the side, if they exist
};

/// A dialog that never blocks the window, so that STOP can be clicked beside it, and that is Qt's own, never the
/// desktop's, so that Space and Esc reach the program. To be connected, then shown; it deletes itself.
QFileDialog* file_dialog(QWidget* parent, const FileQuestion& question);

/// Ctrl+W closes it: while a run is on, Esc is STOP.
void close_by_key(QDialog* dialog);

/// Shows a dialog without blocking the window.
template <typename Dialog>
void show_beside(Dialog* dialog) {
  close_by_key(dialog);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowModality(Qt::NonModal);
  dialog->show();
}

/// Asks for a name, beside the window: `named` gets one that is not blank. `name`: of the dialog as an object.
void ask_name(QWidget* parent, const QString& name, const QString& title,
              const std::function<void(const QString&)>& named);

/// The size, limited to the screen that the parent is on: longer contents scroll.
QSize fitting(const QSize& wanted, const QWidget* parent);

/// Moves a window, and makes it smaller if need be, so that all of it is on one screen: it was placed on another one.
void keep_on_screen(QWidget* window);

/// A place for a dialog where it hides no part of the button: its own place if possible, otherwise the nearest one with
/// room; smaller only if there is no room for its full size.
QRect clear_of(const QRect& dialog, const QRect& button, const QRect& screen);
/// The same, with what a window manager adds to it, for a dialog that is about to be shown.
void keep_clear_of(QWidget* dialog, const QWidget& button);

/// A text with a Close button; a long one scrolls. The parent's shortcuts work in it, too: a message must not disable
/// F5.
class MessageDialog final : public QDialog {
  Q_OBJECT

 public:
  MessageDialog(const QString& name, const QString& title, const QString& rich_text, QWidget* parent);
  QString text() const;  ///< as it is read, without markup

 private:
  QTextBrowser* text_;
};

}  // namespace skein::ui
