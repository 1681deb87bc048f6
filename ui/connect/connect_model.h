#pragma once

#include <QAbstractTableModel>
#include <vector>

#include "app/tools/robot_setup.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// Robots that are being set up, one per row: the findings so far, and the next step.
class ConnectModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { robot, paired, answers, battery, firmware, wheels, tag, verdict, columns };
  using QAbstractTableModel::QAbstractTableModel;
  /// `camera`: the experiment has one.
  void show(const std::vector<app::RobotSetup>& robots, bool camera);
  void set_colours(const Colours& colours) { colours_ = colours; }

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return parent.isValid() ? 0 : columns; }
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

  QString details(int row) const;  ///< all that was found, a line each; empty: nothing was

 private:
  /// What a cell shows, and why.
  struct Cell {
    QString text, tip;
  };
  Cell cell(const app::RobotSetup& of, int column) const;
  Cell linked(const app::RobotSetup& of, int column) const;

  std::vector<app::RobotSetup> robots_;
  bool camera_ = false;
  Colours colours_;
};

}  // namespace skein::ui
