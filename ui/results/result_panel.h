#pragma once

#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QWidget>
#include <optional>

#include "ui/results/run_results.h"

namespace skein::ui {

/// The results of the experiment, live and at the end. With a second run, the differences to it.
class ResultPanel final : public QWidget {
  Q_OBJECT

 public:
  explicit ResultPanel(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record);
  /// A second run to compare with; no rows: none.
  void compare(const QString& name, const app::Experiment& experiment, const std::vector<app::TickRecord>& rows);
  void end_comparison();
  void refresh();  ///< at intervals; costs nothing while hidden
  const RunResults* results() const { return results_ ? &*results_ : nullptr; }
  QSize sizeHint() const override { return {300, 140}; }
  QSize minimumSizeHint() const override { return {120, 60}; }

 protected:
  void showEvent(QShowEvent*) override;

 private:
  enum Column { time, what, formation, tracking, order, closest, largest, against, columns };
  void show_kicks();
  void show_rest();
  void copy(const QString& text);

  QString name_;
  std::unique_ptr<RunResults> results_, other_;
  QString other_name_;
  QTableWidget* table_;
  QLabel* rest_;
  QPushButton *copy_text_, *copy_latex_;
  bool dirty_ = false;
};

}  // namespace skein::ui
