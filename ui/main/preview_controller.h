#pragma once

#include <QElapsedTimer>
#include <QObject>
#include <optional>

#include "ui/run/look_ahead.h"
#include "ui/run/runs.h"

namespace skein::ui {

class ArenaView;
class GainsPanel;
class PlotsPanel;

/// While the slider of a gain, or of a law's parameter, is held, shows the next seconds with its value: pale, in arena
/// and plots.
class PreviewController final : public QObject {
  Q_OBJECT

 public:
  PreviewController(const Runs& runs, GainsPanel* gains, ArenaView* arena, PlotsPanel* plots,
                    QObject* parent = nullptr);
  void refresh();  ///< thirty times a second
  /// What the pale lines are, or why there are none; empty: no slider is held.
  QString hint() const { return hint_; }
  /// What is shown; null: nothing.
  const LookAhead::Rows& shown() const { return shown_; }

 private:
  void hold(const app::OperatorCommand& wish, const QString& what);
  void hold_gain(core::GainName gain, double value);
  void hold_parameter(const QString& name, double value);
  void let_go();
  void show(const LookAhead::Rows& rows, bool exact);
  void fail(const QString& why);
  void ask();

  const Runs& runs_;
  GainsPanel* gains_;
  ArenaView* arena_;
  PlotsPanel* plots_;
  LookAhead look_ahead_;
  std::optional<app::OperatorCommand> held_;
  QString what_;  // the slider that is held, with its value
  QElapsedTimer since_asked_;
  QString asked_what_;  // what was held then
  bool waits_ = false;  // for the answer
  bool newer_ = false;  // another value is held meanwhile
  LookAhead::Rows shown_;
  QString hint_;
};

}  // namespace skein::ui
