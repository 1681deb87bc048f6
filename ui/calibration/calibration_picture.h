#pragma once

#include <QImage>
#include <QWidget>

#include "app/tools/camera_calibration.h"

namespace skein::ui {

/// The camera's picture with the board's corners in it, and shaded where no board has been seen yet.
class CalibrationPicture final : public QWidget {
  Q_OBJECT

 public:
  explicit CalibrationPicture(QWidget* parent = nullptr);
  void set_picture(const app::Picture& picture);
  void show_progress(const app::CalibrationProgress& progress);
  QSize sizeHint() const override { return {560, 420}; }
  QSize minimumSizeHint() const override { return {320, 240}; }

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  QImage picture_;
  app::CalibrationProgress progress_;
};

/// Where the board should be shown next, in words; empty: the picture is covered.
QString next_place(const app::CalibrationProgress& progress);

}  // namespace skein::ui
