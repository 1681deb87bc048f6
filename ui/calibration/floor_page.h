#pragma once

#include <QAbstractTableModel>
#include <QLabel>
#include <QPushButton>
#include <QTableView>
#include <QTimer>
#include <QWidget>
#include <atomic>
#include <future>
#include <optional>

#include "app/tools/camera_calibration.h"
#include "app/tools/floor_survey.h"
#include "ui/base/number_field.h"

namespace skein::ui {

/// The tags on the floor with their places and the residuals of the result.
class FloorModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { id, x, y, z, off, columns };

  explicit FloorModel(QObject* parent = nullptr);
  const std::vector<app::FloorTag>& tags() const { return tags_; }
  void show(const std::vector<app::FloorTag>& tags);
  void add();
  void remove(int row);

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return parent.isValid() ? 0 : columns; }
  QVariant data(const QModelIndex& index, int role) const override;
  bool setData(const QModelIndex& index, const QVariant& value, int role) override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;
  Qt::ItemFlags flags(const QModelIndex& index) const override;

 signals:
  void refused(const QString& why);

 private:
  std::vector<app::FloorTag> tags_;
};

/// Determines the camera's place from tags on the floor whose places were measured.
class FloorPage final : public QWidget {
  Q_OBJECT

 public:
  explicit FloorPage(QWidget* parent = nullptr);
  ~FloorPage() override;
  /// The camera is free: observes the floor now.
  void use_camera(const app::CalibratedCamera& camera, const QString& calibration);
  void refuse(const QString& why);
  /// Shows the tags of the last calibration.
  void show_known(const app::KnownFloor& floor);
  bool looks() const { return survey_.valid(); }

 signals:
  void camera_wanted();
  void saved();

 private:
  void settle();

  FloorModel tags_;
  QTableView* table_;
  NumberField *size_, *height_;
  QPushButton *add_, *remove_, *look_;
  QLabel* result_;
  QTimer timer_;
  std::atomic<bool> ends_{false};
  std::future<tl::expected<app::FloorSurvey, std::string>> survey_;  // last: it uses ends_
};

}  // namespace skein::ui
