#pragma once

#include <QAbstractTableModel>
#include <QCheckBox>
#include <QComboBox>
#include <QDialog>
#include <QElapsedTimer>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTableView>
#include <QTimer>
#include <array>
#include <future>
#include <memory>
#include <utility>
#include <vector>

#include "app/tools/camera_list.h"
#include "app/tools/camera_viewer.h"
#include "ui/base/number_field.h"
#include "ui/base/palette.h"
#include "ui/camera/camera_picture.h"

namespace skein::ui {

/// The tags in a camera's picture and the robots' tags that are not in it, one per row.
class CameraTagModel final : public QAbstractTableModel {
  Q_OBJECT

 public:
  enum Column { tag, size, verdict, columns };
  using QAbstractTableModel::QAbstractTableModel;
  void show(const std::vector<app::WatchedTag>& tags);
  void set_colours(const Colours& colours) { colours_ = colours; }

  int rowCount(const QModelIndex& parent = {}) const override;
  int columnCount(const QModelIndex& parent = {}) const override { return parent.isValid() ? 0 : columns; }
  QVariant data(const QModelIndex& index, int role) const override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;

 private:
  std::vector<app::WatchedTag> tags_;
  Colours colours_;
};

/// Shows the connected cameras, the picture of the chosen one, each tag in it and why it is not taken, and its
/// exposure, gain and focus. Nothing here waits for a camera.
class CameraPage final : public QDialog {
  Q_OBJECT

 public:
  /// `source`, `calibration`: the ones offered first.
  CameraPage(const QString& source, const QString& calibration, QWidget* parent);
  ~CameraPage() override;

  QString source() const;
  QString calibration() const { return calibration_->text().trimmed(); }
  /// Shows this camera from now on.
  void show_camera(const app::Experiment& experiment, const app::WatchedCamera& camera);
  /// Whether it shows the run's camera, whose pictures it is given.
  bool wants_run() const { return watch_ && of_run_; }
  void show_picture(const app::Picture& picture);
  /// Releases a camera that is not the run's.
  void let_go(const QString& why);
  /// The camera cannot be shown, and why.
  void refuse(const QString& why);

  /// Keys of [camera] with their values as TOML has them.
  using Values = std::vector<std::pair<QString, QString>>;

 signals:
  void look_wanted();
  void values_wanted(const skein::ui::CameraPage::Values& values);  ///< are to be put into the experiment

 protected:
  void changeEvent(QEvent*) override;

 private:
  struct Control {
    const char* name;
    QString shown;
    QLabel *label = nullptr, *range = nullptr;
    NumberField* field = nullptr;
    QCheckBox* automatic = nullptr;  // exposure only
  };
  QWidget* build_controls();
  void search();
  void refresh();
  void show_age(const app::CameraView* view);
  void show_settings(const app::CameraView& view);
  void show_status(const app::CameraView& view);
  void show_status_text(const QString& text);
  void end(const QString& why);
  Values values() const;

  CameraPicture* picture_;
  QComboBox* cameras_;
  QLineEdit* calibration_;
  QPushButton *search_, *look_, *put_;
  QLabel *status_, *settings_note_;
  QTableView* table_;
  CameraTagModel tags_;
  std::array<Control, 3> controls_;
  QTimer timer_;
  std::future<app::FoundCameras> found_;
  std::unique_ptr<app::CameraViewer> watch_;
  std::vector<app::CameraSetting> present_;
  QString watched_;                     // the source that is shown
  bool comes_again_and_again_ = false;  // no still
  app::CameraView newest_;
  double pictured_at_ = app::none;  // of the picture that is shown [s]
  QElapsedTimer shown_for_;         // since it came
  QString refused_;                 // what was typed into a setting last, and why it is not taken; empty: it is
  bool of_run_ = false;
};

}  // namespace skein::ui
