#pragma once

#include <QAbstractTableModel>
#include <QPushButton>
#include <QTableView>
#include <QWidget>
#include <array>
#include <optional>
#include <vector>

#include "app/experiment/experiment.h"

namespace skein::ui {

/// The experiment's changes of its gains, one per row: time, values, duration. An empty cell: unchanged.
class ScheduleModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { t, k_xx, k_tt, k_yy, ramp, columns };

  using QAbstractTableModel::QAbstractTableModel;
  void show(const app::Experiment& experiment);
  /// Adds a row that changes nothing yet: it has the values that the gains have by then.
  void add(double at);
  void remove(int row);
  void take_back();  ///< all changes since the experiment was shown
  /// As the value of the file's key gain_change; rows in the order of t.
  QString as_toml() const;
  /// Some change is more than the columns show: gains that differ between pairs, slopes and weights, tracking gains.
  bool has_more() const { return not_shown_; }

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return parent.isValid() ? 0 : columns; }
  QVariant data(const QModelIndex& index, int role) const override;
  bool setData(const QModelIndex& index, const QVariant& value, int role) override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;
  Qt::ItemFlags flags(const QModelIndex& index) const override;

 signals:
  void edited();
  void refused(const QString& why);

 private:
  std::vector<std::array<std::optional<double>, columns>> rows_, first_rows_;
  std::array<double, 3> start_{};  // the gains that the run begins with, in the order of core::gain_names
  bool not_shown_ = false;
};

/// Lets the operator change the schedule before the start.
class ScheduleEditor final : public QWidget {
  Q_OBJECT

 public:
  explicit ScheduleEditor(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  /// Changes are possible only before the start; afterwards the file's values hold.
  void set_editable(bool editable);

 signals:
  void wanted(const QString& gain_change);  ///< the value of the file's key
  void refused(const QString& why);

 private:
  void dress();

  ScheduleModel model_;
  QTableView* table_;
  QPushButton *add_, *remove_, *apply_;
  bool editable_ = true, edited_ = false;
};

}  // namespace skein::ui
