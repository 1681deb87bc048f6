// Experiments and recordings as files: opened, dropped onto the window, remembered.
#include <QDragEnterEvent>
#include <QFileDialog>
#include <QFileInfo>
#include <QMenu>
#include <QMimeData>
#include <QUrl>

#include "app/experiment/experiment_file.h"
#include "ui/main/main_window.h"
#include "ui/settings.h"

namespace skein::ui {
namespace {

constexpr qsizetype most_recent = 8;

QStringList recent_files() {
  return settings().value(QStringLiteral("recent")).toStringList();
}

/// The file that is dragged; empty: none, or more than one.
QString dragged_file(const QMimeData* data) {
  const QList<QUrl> urls = data->urls();
  return urls.size() == 1 ? urls.first().toLocalFile() : QString();
}

}  // namespace

void MainWindow::build_files_menu(QMenu* file) {
  QAction* open = file->addAction(tr("&Open experiment …"), this, [this] { ask_open(); });
  open->setObjectName(QStringLiteral("open"));
  open->setShortcut(QKeySequence::Open);
  QMenu* recent = file->addMenu(tr("Open re&cent"));
  recent->setObjectName(QStringLiteral("recent"));
  connect(recent, &QMenu::aboutToShow, this, [this, recent] {
    recent->clear();
    for (const QString& path : recent_files()) {
      if (!QFileInfo::exists(path)) continue;
      QAction* entry = recent->addAction(QFileInfo(path).fileName(), this, [this, path] { open_file(path); });
      entry->setToolTip(path);
    }
    if (recent->isEmpty()) recent->addAction(tr("No file has been opened yet"))->setEnabled(false);
  });
  recent->setToolTipsVisible(true);
}

void MainWindow::ask_open() {
  auto* dialog = new QFileDialog(this, tr("Open experiment"), QFileInfo(recent_files().value(0)).path(),
                                 tr("Experiments and recorded runs (*.toml *.csv);;All files (*)"));
  dialog->setObjectName(QStringLiteral("open_dialog"));
  dialog->setOption(QFileDialog::DontUseNativeDialog);  // so that Space and Esc reach the program
  dialog->setFileMode(QFileDialog::ExistingFile);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowModality(Qt::NonModal);
  connect(dialog, &QFileDialog::fileSelected, this, &MainWindow::open_file);
  dialog->show();
}

bool MainWindow::real_robots_move() {
  const bool moves = live_.phase() == app::Phase::running || live_.phase() == app::Phase::paused ||
                     live_.phase() == app::Phase::staging;
  if (!moves || live_.real_time_reason().isEmpty()) return false;
  show_problem(tr("Not while robots are under way"), tr("Stop the run first, then open the file."));
  return true;
}

void MainWindow::open_file(const QString& file) {
  const QString kind = QFileInfo(file).suffix().toLower();
  if (kind == QStringLiteral("csv")) return open_recording(file);
  if (kind != QStringLiteral("toml")) {
    show_problem(tr("This is no file for Skein"),
                 tr("Found %1, allowed: an experiment (.toml) or a recorded run (.csv).").arg(file));
    return;
  }
  const auto experiment = app::load_experiment(file.toStdString());
  if (!experiment) {
    QStringList problems;
    for (const app::Problem& problem : experiment.error()) problems << QString::fromStdString(problem.message());
    show_problem(
        tr("This experiment cannot be run"),
        tr("%1 has %n problem(s):", nullptr, static_cast<int>(problems.size())).arg(QFileInfo(file).fileName()),
        problems.join(QLatin1Char('\n')));
    return;
  }
  if (real_robots_move()) return;
  if (live_.is_busy()) {
    show_problem(tr("Not yet"), tr("The experiment before is still being opened or closed: try again in a moment."));
    return;
  }
  open(*experiment, false);
  set_experiment_file(file);
}

void MainWindow::set_experiment_file(const QString& file) {
  experiment_file_ = file.isEmpty() ? QString() : QFileInfo(file).absoluteFilePath();
  if (!experiment_file_.isEmpty()) remember_file(experiment_file_);
}

void MainWindow::remember_file(const QString& file) {
  const QString path = QFileInfo(file).absoluteFilePath();
  QStringList files = recent_files();
  files.removeAll(path);
  files.prepend(path);
  settings().setValue(QStringLiteral("recent"), files.mid(0, most_recent));
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (!dragged_file(event->mimeData()).isEmpty()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QString file = dragged_file(event->mimeData());
  if (file.isEmpty()) return;
  event->acceptProposedAction();
  // Once the drop is over: whoever drags waits for it.
  QMetaObject::invokeMethod(
      this, [this, file] { open_file(file); }, Qt::QueuedConnection);
}

}  // namespace skein::ui
