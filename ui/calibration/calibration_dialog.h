#pragma once

#include <QAbstractTableModel>
#include <QComboBox>
#include <QDialog>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTabWidget>
#include <QTableView>
#include <QTimer>
#include <memory>

#include "app/tools/camera_calibration.h"
#include "ui/base/number_field.h"
#include "ui/base/palette.h"
#include "ui/calibration/calibration_picture.h"
#include "ui/calibration/floor_page.h"

namespace skein::ui {

/// The views that were kept, one per row, with the residual of the result.
class ViewModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { name, corners, error, columns };
  using QAbstractTableModel::QAbstractTableModel;
  void show(const std::vector<app::CalibrationProgress::View>& views);
  void set_colours(const Colours& colours) { colours_ = colours; }

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return parent.isValid() ? 0 : columns; }
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  std::vector<app::CalibrationProgress::View> views_;
  Colours colours_;
};

/// Calibrates a camera: its lens, from a board that somebody holds up, with guidance and residuals; then its place,
/// from tags on the floor. Both go into one file.
class CalibrationDialog final : public QDialog {
  Q_OBJECT

 public:
  /// `camera`: the one that is offered; its settings are those of every v4l2 camera. `file`: where the calibration is
  /// written to.
  CalibrationDialog(const app::CalibratedCamera& camera, const QString& file, QWidget* parent);
  ~CalibrationDialog() override;
  /// The camera is free: shows its pictures from now on.
  void use_camera();
  /// Begins with the floor.
  void show_floor() { tabs_->setCurrentWidget(floor_); }
  /// The camera is not free, and why.
  void refuse(const QString& why);

 signals:
  /// The dialog needs the camera: call `look` once nothing else uses it.
  void camera_wanted();
  void saved(const QString& file);

 protected:
  void changeEvent(QEvent*) override;

 private:
  QWidget* build_form();
  QWidget* build_lens();
  void press_look();
  void refresh();
  void dress(const app::CalibrationProgress& progress);
  void save();
  app::CalibratedCamera camera() const;
  QString advice(const app::CalibrationProgress& progress) const;

  CalibrationPicture* picture_;
  std::vector<std::string> settings_;
  QLineEdit *source_, *size_, *file_;
  QComboBox* kind_;
  NumberField *columns_, *rows_, *square_, *marker_;
  QPushButton *look_, *remove_, *save_;
  QLabel *advice_, *result_;
  QTableView* table_;
  QTabWidget* tabs_;
  FloorPage* floor_;
  ViewModel views_;
  QTimer timer_;
  QString note_;  // of the last attempt to save
  bool looks_ = false, wants_floor_ = false;
  std::unique_ptr<app::CameraCalibration> calibration_;
};

}  // namespace skein::ui
