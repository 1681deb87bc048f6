#pragma once

#include <QPointer>

#include "ui/main/messages.h"

namespace skein::ui {

class CalibrationDialog;

/// Opens the calibration of the experiment's camera, and releases that camera for it.
class CalibrationController final : public QObject {
  Q_OBJECT

 public:
  CalibrationController(LiveRun& live, const Messages& messages, QObject* parent = nullptr);
  /// `floor`: only the camera's pose, by the tags of its calibration.
  void calibrate(bool floor = false);
  void refresh();  ///< thirty times a second

 signals:
  void session_ends();  ///< references to its parts must be dropped

 private:
  void take_camera(CalibrationDialog* dialog);

  LiveRun& live_;
  const Messages& messages_;
  QPointer<CalibrationDialog> waiting_;  // until the session has released the camera
};

}  // namespace skein::ui
