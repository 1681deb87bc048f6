#include "ui/main/camera_controller.h"

#include <QDir>
#include <utility>

#include "app/experiment/control_settings.h"
#include "app/experiment/toml_places.h"
#include "ui/main/editor_controller.h"

namespace skein::ui {

CameraController::CameraController(Runs& runs, EditorController& editor, const Messages& messages, QObject* parent)
    : QObject(parent), runs_(runs), live_(runs.live()), editor_(editor), messages_(messages) {
  connect(&live_, &LiveRun::opened, this, [this] {
    if (page_ && run_has_picture()) show_camera();
  });
}

/// The chosen source is the run's first camera.
bool CameraController::run_has_picture() const {
  return live_.has_camera() && page_->source().toStdString() == live_.experiment().camera.source;
}

void CameraController::show() {
  if (page_) {
    page_->raise();
    return page_->activateWindow();
  }
  const app::Experiment& experiment = runs_.shown().experiment();
  const app::CameraSpec& spec = experiment.camera;
  const bool absent = spec.kind() == app::CameraKind::absent;
  page_ = new CameraPage(absent ? QString() : QString::fromStdString(spec.source),
                         QString::fromStdString(experiment.calibration_file(0)), messages_.window());
  connect(page_, &CameraPage::look_wanted, this, &CameraController::show_camera);
  connect(page_, &CameraPage::values_wanted, this, &CameraController::put);
  page_->show();
  if (run_has_picture()) show_camera();
}

void CameraController::show_camera() {
  const app::Experiment& experiment = runs_.shown().experiment();
  const std::string source = page_->source().toStdString();
  if (source.empty()) return page_->refuse(tr("Choose a camera: Search lists those that are connected"));
  app::WatchedCamera camera{.source = source, .calibration = page_->calibration().toStdString()};
  camera.of_run = run_has_picture();
  if (!camera.of_run && app::camera_kind(source) == app::CameraKind::synthetic)
    return page_->refuse(tr("The synthetic camera shows the robots of a run: open an experiment that has it"));
  for (std::size_t number = 0; number < experiment.cameras(); ++number) {
    const app::CameraSpec& spec = experiment.camera_at(number);
    if (spec.source != source) continue;
    if (number > 0 && live_.is_open())
      return page_->refuse(tr("The run reads this camera, and shows the pictures of its first camera only"));
    camera.trigger = spec.trigger;
    camera.settings = app::control_settings(spec);
    break;  // synthetic ones have one source
  }
  page_->show_camera(experiment, camera);
}

void CameraController::let_go() {
  if (page_) page_->let_go(tr("An experiment is opened, which may need the camera"));
}

void CameraController::show_picture(const app::Picture& picture) {
  if (page_) page_->show_picture(picture);
}

void CameraController::put(const CameraPage::Values& values) {
  const QDir directory(QString::fromStdString(runs_.shown().experiment().directory));
  std::vector<std::pair<QString, QString>> keys;
  for (const auto& [key, value] : values) {
    const bool is_file = key == QStringLiteral("calibration");
    keys.emplace_back(
        QStringLiteral("camera.") + key,
        is_file ? QString::fromStdString(app::toml_string(directory.relativeFilePath(value).toStdString())) : value);
  }
  editor_.edit_with(keys);
}

}  // namespace skein::ui
