#include "ui/main/file_controller.h"

#include <QFileInfo>
#include <QUrl>

#include "app/experiment/experiment_file.h"
#include "app/experiment/hardware.h"
#include "app/experiment/rehearsal.h"
#include "app/experiment/text_file.h"
#include "ui/base/dialogs.h"
#include "ui/base/number_text.h"
#include "ui/base/settings.h"
#include "ui/main/recording_controller.h"
#include "ui/run/run_name.h"

namespace skein::ui {
namespace {

constexpr qsizetype most_recent = 8;

QStringList lines_of(const std::vector<app::Problem>& problems) {
  QStringList lines;
  for (const app::Problem& problem : problems) lines << QString::fromStdString(problem.message());
  return lines;
}

QStringList recent_files() {
  return settings().value(QStringLiteral("recent")).toStringList();
}

}  // namespace

FileController::FileController(LiveRun& live, const Messages& messages, QObject* parent)
    : QObject(parent), live_(live), messages_(messages) {}

void FileController::build_menu(QMenu* file) {
  QAction* open_action = file->addAction(tr("&Open experiment …"), this, &FileController::ask);
  open_action->setObjectName(QStringLiteral("open"));
  open_action->setShortcut(QKeySequence::Open);
  QMenu* recent = file->addMenu(tr("Open re&cent"));
  recent->setObjectName(QStringLiteral("recent"));
  connect(recent, &QMenu::aboutToShow, this, [this, recent] {
    recent->clear();
    for (const QString& path : recent_files()) {
      if (!QFileInfo::exists(path)) continue;
      QAction* entry = recent->addAction(run_name(path), this, [this, path] { open(path); });
      entry->setToolTip(path);
    }
    if (recent->isEmpty()) recent->addAction(tr("No file has been opened yet"))->setEnabled(false);
  });
  recent->setToolTipsVisible(true);
}

void FileController::ask() {
  QFileDialog* dialog =
      file_dialog(messages_.window(), {tr("Open experiment"),
                                       QStringLiteral("open_dialog"),
                                       tr("Experiments and recorded runs (*.toml *.csv);;All files (*)"),
                                       QFileInfo(recent_files().value(0)).path(),
                                       {},
                                       RecordingController::places()});
  connect(dialog, &QFileDialog::fileSelected, this, &FileController::open);
  dialog->show();
}

bool FileController::cannot_open() const {
  if (real_robots_move()) return true;
  if (live_.is_busy())
    messages_.problem(tr("Not yet"),
                      tr("The previous experiment is still being opened or closed: try again in a moment."));
  return live_.is_busy();
}

bool FileController::real_robots_move() const {
  if (!live_.is_under_way() || live_.real_time_reason().isEmpty()) return false;
  messages_.problem(tr("Not while robots drive"), tr("Stop the run first, then open the file."));
  return true;
}

void FileController::open(const QString& file) {
  const QString kind = QFileInfo(file).suffix().toLower();
  if (kind == QStringLiteral("csv")) return open_recording(file);
  if (kind != QStringLiteral("toml")) {
    messages_.problem(tr("Skein cannot open this file"),
                      tr("Found %1, allowed: an experiment (.toml) or a recorded run (.csv).").arg(file));
    return;
  }
  emit superseded();
  file_ = run_name(file);
  messages_.say(reading_text(file_), Severity::note);
  reading_.run([file](const std::stop_token&) { return read(file); });
}

void FileController::drop() {
  reading_.drop();
  emit superseded();
}

FileController::Read FileController::read(const QString& file) {
  const std::string path = file.toStdString();
  auto text = app::read_text(path);
  if (!text) return {file, {}, std::move(text.error()), {}};
  // The editor would show something else than such a file has, and write that.
  if (text->find('\0') != std::string::npos || !QUtf8StringView(*text).isValidUtf8())
    return {file, {}, {{path, 0, 0, tr("found no text, allowed: an experiment as UTF-8").toStdString()}}, {}};
  auto experiment = app::parse_experiment(*text, path);
  return {file, std::move(*text), {}, std::move(experiment)};
}

void FileController::refresh() {
  if (live_.is_busy()) return;  // the session before is still being opened or closed
  const auto done = reading_.take();
  if (!done) return;
  const auto found_in = [&](const std::vector<app::Problem>& problems) {
    return tr("%1 has %2")
        .arg(QFileInfo(done->file).fileName(), counted(static_cast<qsizetype>(problems.size()), "problem"));
  };
  if (!done->unreadable.empty())
    return messages_.problem(tr("This experiment cannot be run"), found_in(done->unreadable),
                             lines_of(done->unreadable).join(QLatin1Char('\n')));
  if (!done->experiment) {
    const std::vector<app::Problem>& problems = done->experiment.error();
    messages_.note(found_in(problems) + QStringLiteral(": ") + lines_of(problems).first(), Severity::warning);
    emit broken(QString::fromStdString(done->text), done->file);
    return;
  }
  if (real_robots_move()) return;
  emit experiment_wanted(*done->experiment);
  set_file(done->file, QString::fromStdString(done->text));
}

void FileController::rehearse() {
  const app::Experiment& experiment = live_.experiment();
  if (!app::has_hardware(experiment))
    return messages_.problem(tr("There is nothing to rehearse"),
                             tr("This experiment has neither real robots nor a real camera: start it as it is."));
  if (cannot_open()) return;
  const auto rehearsal = app::rehearsal(experiment);
  if (!rehearsal)
    return messages_.problem(tr("This experiment cannot be rehearsed"),
                             tr("Without its hardware its file has problems:"),
                             lines_of(rehearsal.error()).join(QLatin1Char('\n')));
  emit experiment_wanted(*rehearsal);
}

void FileController::open_recording(const QString& file) {
  if (real_robots_move()) return;
  reading_.drop();
  emit recording_wanted(file);
}

void FileController::set_experiment_file(const QString& file) {
  if (file.isEmpty()) return live_.set_file({}, {});
  if (QFileInfo(file).absoluteFilePath() == live_.file()) return;
  const auto text = app::read_text(file.toStdString());
  set_file(file, text ? QString::fromStdString(*text) : QString());
}

void FileController::set_file(const QString& file, const QString& text) {
  live_.set_file(QFileInfo(file).absoluteFilePath(), text);
  remember(live_.file());
}

void FileController::remember(const QString& file) {
  const QString path = QFileInfo(file).absoluteFilePath();
  QStringList files = recent_files();
  files.removeAll(path);
  files.prepend(path);
  settings().setValue(QStringLiteral("recent"), files.mid(0, most_recent));
}

QString FileController::dragged(const QMimeData* data) {
  const QList<QUrl> urls = data->urls();
  return urls.size() == 1 ? urls.first().toLocalFile() : QString();
}

}  // namespace skein::ui
