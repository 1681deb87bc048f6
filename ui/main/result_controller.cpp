#include "ui/main/result_controller.h"

#include <QDir>
#include <QFileInfo>
#include <QSaveFile>
#include <chrono>

#include "app/record/report.h"
#include "app/runs/kept_run.h"
#include "app/runs/run_folder.h"
#include "app/runs/run_page.h"
#include "ui/main/recording_controller.h"
#include "ui/results/result_panel.h"
#include "ui/run/run_name.h"

namespace skein::ui {

ResultController::ResultController(const Runs& runs, const Messages& messages, ResultPanel* results, QObject* parent)
    : QObject(parent), runs_(runs), messages_(messages), results_(results) {
  connect(results, &ResultPanel::save_wanted, this, &ResultController::save);
}

void ResultController::save() {
  if (saving_.valid()) return;
  const RunSource& run = runs_.shown();
  RunHistory::Rows rows = run.rows();
  if (rows.empty()) return messages_.say(tr("There is no run yet to save"), Severity::notice);
  const QString recording = run.is_complete() ? QString::fromStdString(runs_.replay().recording()->file) : QString();
  const bool kept = is_kept_record(recording);
  const QString folder = kept ? QFileInfo(recording).absolutePath() : RecordingController::path(run.experiment(), {});
  if (folder.isEmpty() || !QDir().mkpath(folder))
    return messages_.problem(
        tr("The report was not saved"),
        tr("%1 cannot be made.").arg(folder.isEmpty() ? RecordingController::directory() : folder));
  messages_.say(tr("Saving the report …"), Severity::note);
  std::vector<app::TagCrop> crops;  // a kept run has its own
  if (!run.is_complete()) crops = runs_.live().crops();
  saving_ = std::async(std::launch::async,
                       [folder, kept, rows = std::move(rows), experiment = run.experiment(), crops = std::move(crops),
                        others = results_->others()] { return write(folder, kept, rows, experiment, crops, others); });
}

/// Aside: gnuplot draws for a second. Whatever fails, the rest is written.
ResultController::Saved ResultController::write(const QString& folder, bool kept, const RunHistory::Rows& rows,
                                                const app::Experiment& experiment,
                                                const std::vector<app::TagCrop>& crops,
                                                const std::vector<RunBeside>& others) {
  Saved saved{folder, {}};
  const auto place = [&](const char* name) { return folder + QLatin1Char('/') + QLatin1String(name); };
  const auto note = [&](const std::string& sentence) { saved.problems << QString::fromStdString(sentence); };
  QStringList written;
  const auto put = [&](const char* name, const QByteArray& text) {
    QSaveFile out(place(name));
    if (!out.open(QIODevice::WriteOnly) || out.write(text) < 0 || !out.commit())
      saved.problems << tr("Could not write %1: %2.").arg(out.fileName(), out.errorString());
    else
      written << QLatin1String(name);
  };
  RunResults results(experiment);
  app::Statistics statistics(experiment);
  for (const auto& row : rows) {
    results.add_record(*row);
    statistics.record(*row);
  }
  put("results.txt", as_text(QString::fromStdString(experiment.name), results, others).toUtf8());
  put("results.tex", as_latex(results, others).toUtf8());
  const std::string csv = place(app::run_files::record).toStdString();
  if (!kept) {  // a kept run has both
    if (const QString problem = write_csv(rows, experiment, QString::fromStdString(csv)); !problem.isEmpty())
      saved.problems << problem;
    auto figures = app::check_report(folder.toStdString());
    if (figures) figures = app::write_report(folder.toStdString(), experiment, statistics.summary());
    if (!figures) note(figures.error());
    for (const app::TagCrop& crop : crops)
      if (const auto drawn = app::write_crop(crop, folder.toStdString()); !drawn) note(drawn.error());
  }
  if (const auto page = app::page_of_run(csv, kept ? folder.toStdString() : std::string(), crops)) {
    put("report.html", QByteArray::fromStdString(page->html));
    for (const std::string& warning : page->warnings) note(warning);
  } else {
    note(page.error());
  }
  if (kept) {
    std::vector<std::string> names;
    for (const QString& name : written) names.push_back(name.toStdString());
    if (const auto added = app::add_to_kept_run(folder.toStdString(), names); !added) note(added.error());
  }
  return saved;
}

void ResultController::refresh() {
  if (!saving_.valid() || saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const Saved done = saving_.get();
  if (done.problems.isEmpty())
    messages_.say(tr("Saved the report in %1").arg(done.folder), Severity::good);
  else
    messages_.problem(tr("The report in %1 is not complete").arg(done.folder), done.problems.join(QLatin1Char('\n')));
  emit saved(done.folder, done.problems);
}

}  // namespace skein::ui
