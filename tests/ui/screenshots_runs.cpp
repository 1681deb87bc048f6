// Takes the pictures of what is done with runs: a replay with a second run behind it, all plots, the editor, a
// camera that is calibrated.
// skein_screenshots_runs DIR
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDir>
#include <QLineEdit>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QSettings>
#include <QSpinBox>
#include <QTemporaryDir>
#include <QTest>
#include <cstdio>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_file.h"
#include "app/session/session.h"
#include "shown_board.h"
#include "ui/arena/arena_view.h"
#include "ui/base/settings.h"
#include "ui/calibration/calibration_dialog.h"
#include "ui/editor/experiment_editor.h"
#include "ui/main/main_window.h"
#include "ui/plots/plots_panel.h"
#include "ui/status/time_line.h"
#include "ui/window.h"

namespace skein::ui {
namespace {

/// The paper's experiment with another gain, recorded.
QString recorded(const QDir& dir, const char* name, const std::string& set) {
  const app::Experiment experiment = *app::parse_experiment(app::paper_experiment().source, "platoon.toml", {set});
  const QString file = dir.filePath(QString::fromLatin1(name));
  app::CsvFile csv(file.toStdString(), experiment);
  auto session = app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}});
  (*session)->run();
  csv.finish();
  return file;
}

bool save(QWidget& widget, const QDir& dir, const QString& name) {
  bool done = true;
  for (const auto& [theme, ending] : {std::pair{Theme::light, ".png"}, {Theme::dark, "-dark.png"}}) {
    apply(theme);
    QTest::qWait(300);  // two replots
    done = widget.grab().save(dir.filePath(name + QString::fromLatin1(ending))) && done;
  }
  apply(Theme::light);
  return done;
}

int take(const QDir& dir) {
  const QTemporaryDir runs;
  const QString one = recorded(QDir(runs.path()), "run-k_yy-0.08.csv", "controller.gains.k_yy=0.08");
  const QString two = recorded(QDir(runs.path()), "run-k_yy-0.02.csv", "controller.gains.k_yy=0.02");
  MainWindow window;
  window.resize(1280, 800);
  window.show();
  window.open_recording(one);
  const auto wait = [](const std::function<bool()>& holds) { return QTest::qWaitFor(holds, 20000); };
  if (!wait([&] { return window.replay().is_loaded(); })) return 3;
  window.go();  // pause
  window.compare_with(two);
  if (!wait([&] { return window.findChild<ArenaView*>()->scene().compared.size() == 1; })) return 3;
  emit window.findChild<TimeLine*>()->time_wanted(21.5);
  bool done = save(window, dir, QStringLiteral("replay"));
  auto* plots = window.findChild<PlotsPanel*>();
  plots->compare(std::vector<PlotsPanel::Compared>());
  plots->show_plots({"e_x", "V", "V_dot", "v", "omega", "min_distance", "period"});
  done = save(*plots, dir, QStringLiteral("plots")) && done;
  plots->show_plots({"e_x", "e_y", "V"});
  done = plots->show_over(QStringLiteral("e_y"), QStringLiteral("e_x")) && done;
  done = save(*plots, dir, QStringLiteral("plots-over")) && done;
  plots->show_over({}, {});
  plots->show_plots({});

  window.findChild<QAction*>(QStringLiteral("edit_experiment"))->trigger();
  auto* editor = window.findChild<ExperimentEditor*>();
  auto* text = editor->findChild<QPlainTextEdit*>();
  const QString paper = QString::fromStdString(app::paper_experiment().source);
  text->setPlainText(QString(paper).replace(QStringLiteral("rate = 25.0 "), QStringLiteral("rate = -3   ")));
  QTest::qWait(500);
  done = save(*editor, dir, QStringLiteral("editor")) && done;

  window.findChild<QAction*>(QStringLiteral("calibrate_camera"))->trigger();
  auto* calibration = window.findChild<CalibrationDialog*>();
  const QTemporaryDir views;
  done = test::board::save_views(QDir(views.path())) && done;
  const auto enter = [&](const char* name, const QString& value) {
    calibration->findChild<QLineEdit*>(QString::fromLatin1(name))->setText(value);
  };
  enter("calibration_source", QStringLiteral("images:") + views.path());
  calibration->findChild<QComboBox*>(QStringLiteral("calibration_board"))->setCurrentIndex(1);
  calibration->findChild<QSpinBox*>(QStringLiteral("calibration_columns"))->setValue(test::board::columns);
  calibration->findChild<QSpinBox*>(QStringLiteral("calibration_rows"))->setValue(test::board::rows);
  calibration->findChild<QPushButton*>(QStringLiteral("calibration_look"))->click();
  done = wait([&] { return calibration->findChild<QPushButton*>(QStringLiteral("calibration_save"))->isEnabled(); }) &&
         done;
  QTest::qWait(1000);  // the last view is solved with the others
  enter("calibration_source", QStringLiteral("v4l2:/dev/video0"));
  enter("calibration_file", QStringLiteral("camera.toml"));
  done = calibration->grab().save(dir.filePath(QStringLiteral("calibration.png"))) && done;
  window.close();
  static_cast<void>(wait([&] { return !window.isVisible(); }));
  return done ? 0 : 3;
}

}  // namespace
}  // namespace skein::ui

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  const QTemporaryDir settings;  // the user's own are none of this program's business
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, settings.path());
  skein::ui::settings().setValue(QStringLiteral("keep_runs"), false);
  skein::ui::prepare(application);
  const QStringList words = QApplication::arguments();
  if (words.size() == 2) return skein::ui::take(QDir(words[1]));
  std::fprintf(stderr, "usage: skein_screenshots_runs DIR\n");
  return 2;
}
