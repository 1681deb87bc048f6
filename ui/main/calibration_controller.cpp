#include "ui/main/calibration_controller.h"

#include <fmt/format.h>

#include <QDir>
#include <utility>

#include "app/experiment/control_settings.h"
#include "app/experiment/hardware.h"
#include "ui/calibration/calibration_dialog.h"

namespace skein::ui {

CalibrationController::CalibrationController(LiveRun& live, const Messages& messages, QObject* parent)
    : QObject(parent), live_(live), messages_(messages) {}

/// What the lens of the experiment's camera does, with a board that somebody shows it.
void CalibrationController::calibrate(bool floor) {
  const app::Experiment& experiment = live_.experiment();
  const app::CameraSpec& spec = experiment.camera;
  app::CalibratedCamera camera{app::is_hardware(spec.kind()) ? spec.source : "v4l2:/dev/video0"};
  for (const auto& [name, value] : app::control_settings(spec))
    camera.settings.push_back(fmt::format("{}={}", name, value));
  const QString name = QString::fromStdString(spec.calibration);
  auto* dialog = new CalibrationDialog(camera,
                                       QDir(QString::fromStdString(experiment.directory))
                                           .filePath(name.isEmpty() ? QStringLiteral("camera.toml") : name),
                                       messages_.window());
  connect(dialog, &CalibrationDialog::camera_wanted, this, [this, dialog] { take_camera(dialog); });
  connect(dialog, &CalibrationDialog::saved, this,
          [this](const QString& file) { messages_.note(tr("Calibration written to %1").arg(file), Severity::good); });
  if (floor) dialog->show_floor();
  dialog->show();
}

void CalibrationController::take_camera(CalibrationDialog* dialog) {
  const bool has_it = live_.is_open() && live_.experiment().camera.kind() == app::CameraKind::live;
  if (has_it && live_.is_under_way()) return dialog->refuse(tr("The run needs the camera: stop it first"));
  if (has_it) {
    messages_.note(tr("The experiment is ended: its camera is being calibrated"), Severity::notice);
    emit session_ends();
    live_.end();
  }
  waiting_ = dialog;
}

void CalibrationController::refresh() {
  if (waiting_ && !live_.is_busy()) std::exchange(waiting_, nullptr)->use_camera();
}

}  // namespace skein::ui
