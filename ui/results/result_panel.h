#pragma once

#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QWidget>
#include <memory>
#include <optional>
#include <vector>

#include "ui/results/run_results.h"

namespace skein::ui {

/// The results of the experiment, live and at the end. With other runs, the differences to them.
class ResultPanel final : public QWidget {
  Q_OBJECT

 public:
  explicit ResultPanel(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void show_record(const app::TickRecord& record);
  /// A run to compare with.
  struct Beside {
    QString letter, name;
    std::shared_ptr<const RunResults> results;
  };
  void compare(std::vector<Beside> others);  ///< none: the comparison is over
  void show_kept(const QString& folder);     ///< where this run is kept
  void show_timing(const QString& text);     ///< how punctual its ticks were; empty: not known
  void refresh();                            ///< at intervals; costs nothing while hidden
  const RunResults* results() const { return results_ ? &*results_ : nullptr; }
  QSize sizeHint() const override { return {300, 140}; }
  QSize minimumSizeHint() const override { return {120, 60}; }

 signals:
  void save_wanted();

 protected:
  void changeEvent(QEvent*) override;
  void showEvent(QShowEvent*) override;

 private:
  enum Column { time, what, formation, tracking, order, closest, largest, against, columns };
  void show_kicks();
  void show_rest();
  void copy(const QString& text);

  QString name_;
  QString kept_;  // empty: nowhere
  QString timing_;
  std::unique_ptr<RunResults> results_;
  std::vector<Beside> others_;
  QTableWidget* table_;
  QLabel* rest_;
  QPushButton *copy_text_, *copy_latex_, *save_;
  bool dirty_ = false;
};

}  // namespace skein::ui
