#pragma once

#include <QAbstractTableModel>
#include <QStringList>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "app/session/session.h"
#include "ui/base/circumstances.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// The robots, one per row: link, mode, tag, how it was found, wheels, firmware.
class RobotsModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { robot, tag, link, round_trip, battery, mode, found, tag_age, wheels, firmware, columns };

  using QAbstractTableModel::QAbstractTableModel;

  static QString nothing() { return QStringLiteral("–"); }  ///< stands where there is no value

  void show_experiment(const app::Experiment& experiment);
  /// Facts about the robots that the record does not have.
  struct Known {
    std::vector<app::RobotStatus> links;
    bool stop_asked = false;
    Circumstances circumstances{};
    std::vector<std::size_t> may_be_driving{};  ///< from 0: commanded to stand, and not acknowledged
    bool recorded = false;                      ///< a replay
  };
  void show_record(const app::TickRecord& record, const Known& known);
  void set_colours(const Colours& colours);
  bool has_links() const;  ///< whether any robot has one

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override;
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  QString text(std::size_t i, int column) const;
  QString tip(std::size_t i, int column) const;
  QString why_nothing(std::size_t i, int column) const;
  bool may_be_driving(std::size_t i) const;
  QVariant ink(std::size_t i, int column) const;

  std::vector<app::RobotSpec> specs_;
  std::vector<app::RobotRecord> robots_;
  Known known_;
  QStringList why_;  // of each robot, what it does and why
  Colours colours_;
};

}  // namespace skein::ui
