#include "ui/main/recording_controller.h"

#include <QCoreApplication>
#include <QDateTime>
#include <QDir>
#include <QFile>
#include <QRegularExpression>
#include <QStandardPaths>
#include <chrono>

#include "app/runs/run_folder.h"
#include "ui/base/dialogs.h"
#include "ui/base/settings.h"

namespace skein::ui {
namespace {

const QString keep_key = QStringLiteral("keep_runs"), films_key = QStringLiteral("keep_films");

/// A free name in this folder, of the experiment and the moment.
QString free_name(const QDir& folder, const QString& beginning, const app::Experiment& experiment,
                  const QString& ending) {
  QString name = QString::fromStdString(experiment.name);
  name.replace(QRegularExpression(QStringLiteral("[^\\w-]+")), QStringLiteral("_"));
  const QString stamp = QDateTime::currentDateTime().toString(QStringLiteral("yyyyMMdd-HHmmss"));
  QString file = folder.filePath(QStringLiteral("%1-%2%3").arg(beginning + name, stamp, ending));
  for (int k = 2; QFile::exists(file); ++k)
    file = folder.filePath(QStringLiteral("%1-%2-%3%4").arg(beginning + name, stamp).arg(k).arg(ending));
  return file;
}

}  // namespace

RecordingController::RecordingController(LiveRun& live, const Messages& messages, QObject* parent)
    : QObject(parent),
      live_(live),
      messages_(messages),
      keeps_(settings().value(keep_key, true).toBool()),
      keeps_films_(settings().value(films_key, false).toBool()) {
  connect(&live_, &LiveRun::starting, this, &RecordingController::record_if_wanted);
  connect(&live_, &LiveRun::starting, this, &RecordingController::keep_if_wanted);
  connect(&live_, &LiveRun::kept, this, [this](const QString& folder, const QString& problem) {
    // Its files take a moment, in which the next run may have been set up.
    const QString kept = folder == live_.kept_folder() ? tr("Kept in %1") : tr("The run before is kept in %1");
    if (problem.isEmpty())
      messages_.note(kept.arg(folder), Severity::good);
    else
      messages_.note(tr("%1, but incomplete: %2").arg(kept.arg(folder), problem), Severity::warning);
  });
  connect(&live_, &LiveRun::keeping_failed, this, [this](const QString& problem) {
    messages_.note_unkept(tr("the kept record of this run ends here, the run goes on: %1").arg(problem));
  });
  connect(&live_, &LiveRun::recorded, this, [this](const QString& file, const QString& problem) {
    if (problem.isEmpty())
      messages_.note(tr("Recorded %1").arg(file), Severity::good);
    else
      messages_.note(problem, Severity::alarm);
  });
  connect(&live_, &LiveRun::film_failed, this, [this](const QString& problem) {
    messages_.note_unkept(tr("the film of this run ends here, the run goes on: %1").arg(problem));
  });
}

void RecordingController::keep(bool on) {
  keeps_ = on;
  settings().setValue(keep_key, on);
}

void RecordingController::keep_films(bool on) {
  keeps_films_ = on;
  settings().setValue(films_key, on);
}

void RecordingController::keep_if_wanted() {
  if (!keeps_ || live_.keeps()) return;
  const app::Experiment& experiment = live_.experiment();
  app::KeepRequest request;
  const auto directory = app::runs_directory({});
  if (!directory)
    return messages_.note_unkept(tr("this run is not kept: %1").arg(QString::fromStdString(directory.error())));
  request.directory = *directory;
  if (QFile::exists(live_.file())) request.experiment = live_.file().toStdString();
  request.text = experiment.source;
  for (const QString& word : QCoreApplication::arguments()) request.words.push_back(word.toStdString());
  request.real_time = true;
  const QString problem = live_.keep(request);
  if (!problem.isEmpty()) return messages_.note_unkept(tr("this run is not kept: %1").arg(problem));
  messages_.note(tr("This run is kept in %1").arg(live_.kept_folder()), Severity::note);
  if (const auto little = app::little_room(request.directory))
    messages_.note(QString::fromStdString(*little), Severity::warning);
  emit keeping(live_.kept_folder());
}

QString RecordingController::directory() {
  const QString usual =
      QDir(QStandardPaths::writableLocation(QStandardPaths::DocumentsLocation)).filePath(QStringLiteral("skein"));
  return settings().value(QStringLiteral("recordings"), usual).toString();
}

QStringList RecordingController::places() {
  QStringList folders{directory()};
  if (const auto kept = app::runs_directory({})) folders << QString::fromStdString(*kept);
  return folders;
}

void RecordingController::record(bool on) {
  records_ = on;
  live_.set_records_next(on);
  if (!on && !live_.record_file().isEmpty()) {
    const QString file = live_.record_file(), problem = live_.record_to({});
    messages_.note(problem.isEmpty() ? tr("recorded %1").arg(file) : problem,
                   problem.isEmpty() ? Severity::good : Severity::alarm);
  }
  const bool runs = live_.phase() == app::Phase::running || live_.phase() == app::Phase::paused;
  if (on && runs) record_if_wanted();
}

/// Named after the experiment and the moment.
QString RecordingController::path(const app::Experiment& experiment, const QString& ending) {
  const QDir folder(directory());
  if (!folder.mkpath(QStringLiteral("."))) return {};
  return free_name(folder, {}, experiment, ending);
}

/// One that is only kept grows beside the folders of the runs, so that its folder gets the same bytes by another name.
FilmOfRun RecordingController::film(const app::Experiment& experiment) const {
  if (experiment.camera.kind() == app::CameraKind::absent) return {};
  const QString ending = QStringLiteral(".mkv");
  const bool of_kept_run = keeps_ && keeps_films_;
  if (records_) return {path(experiment, ending), of_kept_run, false};
  const auto directory = app::runs_directory({});
  if (!of_kept_run || !directory) return {};
  const QDir runs(QString::fromStdString(*directory));
  if (!runs.mkpath(QStringLiteral("."))) return {};
  return {free_name(runs, QStringLiteral(".film-"), experiment, ending), true, true};
}

void RecordingController::record_if_wanted() {
  if (!records_ || !live_.record_file().isEmpty()) return;
  const QString file = path(live_.experiment(), QStringLiteral(".csv"));
  if (!file.isEmpty()) return record_to(file);
  records_ = false;
  live_.set_records_next(false);
  messages_.problem(tr("The run is not recorded"), tr("%1 cannot be made.").arg(directory()));
}

void RecordingController::record_to(const QString& file) {
  const QString problem = live_.record_to(file);
  records_ = problem.isEmpty();
  live_.set_records_next(records_);
  if (problem.isEmpty())
    messages_.note(tr("Recording to %1").arg(file), Severity::note);
  else
    messages_.problem(tr("The run is not recorded"), problem);
}

void RecordingController::ask_save() {
  QFileDialog* dialog =
      file_dialog(messages_.window(), {tr("Save CSV"),
                                       QStringLiteral("save_csv_dialog"),
                                       tr("CSV (*.csv);;All files (*)"),
                                       {},
                                       QString::fromStdString(live_.experiment().name) + QStringLiteral(".csv")});
  connect(dialog, &QFileDialog::fileSelected, this, &RecordingController::save);
  dialog->show();
}

void RecordingController::save(const QString& file) {
  if (saving_) return;
  // Aside: thousands of rows of a hundred numbers take longer than a frame.
  saving_ = Saving{file, std::async(std::launch::async, [rows = live_.rows(), experiment = live_.experiment(), file] {
                     return write_csv(rows, experiment, file);
                   })};
}

void RecordingController::refresh() {
  if (!saving_ || saving_->problem.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const QString file = saving_->file, problem = saving_->problem.get();
  saving_.reset();
  if (!problem.isEmpty())
    messages_.problem(tr("The run was not saved"), problem);
  else if (const auto gone = live_.history().dropped())
    messages_.say(tr("Saved %1 without its first %2 rows, which were no longer in memory").arg(file).arg(gone),
                  Severity::warning);
  else
    messages_.say(tr("Saved %1").arg(file), Severity::good);
  emit saved(file, problem);
}

}  // namespace skein::ui
