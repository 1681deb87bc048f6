#pragma once

#include <QAbstractTableModel>
#include <set>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "app/session/session.h"
#include "ui/palette.h"

namespace skein::ui {

/// The robots, one a row: link, mode, tag, how it was found, wheels, firmware.
class RobotsModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { robot, tag, link, round_trip, battery, mode, found, tag_age, wheels, firmware, columns };

  using QAbstractTableModel::QAbstractTableModel;

  static QString nothing() { return QStringLiteral("–"); }  ///< stands where there is no value

  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record, const std::vector<app::RobotStatus>& links, bool stop_asked,
            const std::set<int>& held = {});
  void set_colours(const Colours& colours);

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override;
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  QString text(std::size_t i, int column) const;
  QString tip(std::size_t i, int column) const;
  QVariant ink(std::size_t i, int column) const;

  std::vector<app::RobotSpec> specs_;
  std::vector<app::RobotRecord> robots_;
  std::vector<app::RobotStatus> links_;
  Colours colours_;
  std::set<int> held_;
  bool stop_asked_ = false;
};

}  // namespace skein::ui
