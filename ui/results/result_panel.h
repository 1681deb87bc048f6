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

/// The results of the experiment, live and at the end. Each kick has a row of numbers, and below it one of sentences as
/// wide as the table: what it was, what settled first, and the differences to other runs.
class ResultPanel final : public QWidget {
  Q_OBJECT

 public:
  explicit ResultPanel(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void show_record(const app::TickRecord& record);
  void compare(std::vector<RunBeside> others);  ///< none: the comparison is over
  const std::vector<RunBeside>& others() const { return others_; }
  void show_kept(const QString& folder);  ///< where this run is kept
  void show_timing(const QString& text);  ///< how punctual its ticks were; empty: not known
  void refresh();                         ///< at intervals; costs nothing while hidden
  const RunResults* results() const { return results_ ? &*results_ : nullptr; }
  QSize sizeHint() const override { return {300, 140}; }
  QSize minimumSizeHint() const override { return {120, 60}; }

 signals:
  void save_wanted();

 protected:
  void changeEvent(QEvent*) override;
  void resizeEvent(QResizeEvent*) override;
  void showEvent(QShowEvent*) override;

 private:
  enum Column { time, formation, tracking, closest, largest, columns };
  void show_kicks();
  void keep_sentences_whole();
  void show_rest();
  void copy(const QString& text);

  QString name_;
  QString kept_;  // empty: nowhere
  QString timing_;
  std::unique_ptr<RunResults> results_;
  std::vector<RunBeside> others_;
  QTableWidget* table_;
  QLabel* rest_;
  QPushButton *copy_text_, *copy_latex_, *save_;
  bool dirty_ = false;
};

}  // namespace skein::ui
