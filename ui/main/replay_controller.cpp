#include "ui/main/replay_controller.h"

#include "ui/base/dialogs.h"
#include "ui/main/recording_controller.h"
#include "ui/run/run_name.h"

namespace skein::ui {

ReplayController::ReplayController(Runs& runs, FileController& files, const Messages& messages, QObject* parent)
    : QObject(parent), runs_(runs), files_(files), messages_(messages) {
  connect(&files_, &FileController::recording_wanted, this, &ReplayController::load);
  connect(&files_, &FileController::superseded, this, [this] { loader_.drop(); });
}

void ReplayController::build_menu(QMenu* file) {
  QAction* open = file->addAction(tr("Open &recording …"), this, [this] {
    QFileDialog* dialog = file_dialog(messages_.window(), {tr("Open recording"),
                                                           QStringLiteral("open_recording_dialog"),
                                                           tr("Recorded runs (*.csv);;All files (*)"),
                                                           RecordingController::directory(),
                                                           {},
                                                           RecordingController::places()});
    connect(dialog, &QFileDialog::fileSelected, &files_, &FileController::open_recording);
    dialog->show();
  });
  open->setObjectName(QStringLiteral("open_recording"));
  open->setShortcut(QKeySequence(tr("Ctrl+Shift+O")));
}

void ReplayController::load(const QString& file) {
  file_ = run_name(file);
  messages_.say(reading_text(file_), Severity::note);
  loader_.load(file.toStdString());
}

void ReplayController::refresh() {
  if (auto run = loader_.take()) {
    if (!*run) return messages_.problem(tr("This recording cannot be read"), QString::fromStdString(run->error()));
    files_.remember(QString::fromStdString((*run)->file));
    runs_.show_recording(std::make_shared<const app::RecordedRun>(std::move(**run)));
  }
  runs_.refresh();
}

}  // namespace skein::ui
