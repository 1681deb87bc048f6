#pragma once

#include <QWidget>

#include "ui/run/runs.h"

namespace skein::ui {

class AlertStrip;
class EventPanel;

/// What is said while a file is being read.
QString reading_text(const QString& file);

/// How the window talks to the operator: in the alert strip, in the log, in a dialog beside the window.
class Messages final {
 public:
  Messages(const Runs& runs, AlertStrip* alert, EventPanel* log, QWidget* window)
      : runs_(runs), alert_(alert), log_(log), window_(window) {}

  void say(const QString& text, Severity severity) const;                ///< in the alert strip, for a while
  void say_beside_banner(const QString& text, Severity severity) const;  ///< the arena's banner says it as well
  void note(const QString& text, Severity severity) const;               ///< there and in the log
  /// There, in the log, and as long as the run lasts: not all of it is kept.
  void note_unkept(const QString& text) const;
  /// Shows why a request was refused, if it was.
  void tell(const RunSource::Done& done) const;
  void problem(const QString& title, const QString& text, const QString& details = {}) const;       ///< in a dialog
  void show_problem(const QString& title, const QString& text, const QString& details = {}) const;  ///< only there
  QWidget* window() const { return window_; }  ///< parent for dialogs

 private:
  const Runs& runs_;
  AlertStrip* alert_;
  EventPanel* log_;
  QWidget* window_;
};

}  // namespace skein::ui
