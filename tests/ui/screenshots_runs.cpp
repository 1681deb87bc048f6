// Takes the pictures of what is done with runs: a replay with a second run behind it, all plots, the editor, a
// camera that is calibrated, one that is looked through, robots that are set up.
// skein_screenshots_runs DIR
#include <QAbstractItemView>
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDir>
#include <QDoubleSpinBox>
#include <QImage>
#include <QLabel>
#include <QLineEdit>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QTableView>
#include <QTemporaryDir>
#include <QTest>
#include <array>
#include <cstdio>

#include "app/calibration/calibration_file.h"
#include "app/experiment/experiment_file.h"
#include "app/record/csv_file.h"
#include "app/session/session.h"
#include "own_home.h"
#include "shown_board.h"
#include "ui/arena/arena_view.h"
#include "ui/calibration/calibration_dialog.h"
#include "ui/camera/camera_page.h"
#include "ui/connect/connect_page.h"
#include "ui/editor/experiment_editor.h"
#include "ui/main/main_window.h"
#include "ui/plots/plots_panel.h"
#include "ui/status/time_line.h"
#include "ui/window.h"
#include "vision/synthetic/synthetic_camera.h"

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

/// A camera's picture with a tag of each kind: two robots', one that is too small, and nobody's.
bool camera_page(MainWindow& window, const QDir& dir) {
  const auto calibration = app::load_calibration("resources/cameras/overhead.toml");
  if (!calibration) return false;
  vision::SyntheticCamera camera(*calibration);
  vision::Frame frame;
  const double size = calibration->tag_size;
  const std::array tags{
      vision::SyntheticTag{1, {0.45, 0.25, 0.5}, size}, vision::SyntheticTag{2, {-0.4, 0.3, 1.0}, 0.8 * size},
      vision::SyntheticTag{4, {-0.1, -0.05, 2.2}, size}, vision::SyntheticTag{9, {0.35, -0.35, 0.0}, size}};
  camera.render(tags, 0.0, frame);
  const QTemporaryDir views;
  QImage(frame.grey.data(), frame.width, frame.height, frame.width, QImage::Format_Grayscale8)
      .save(views.filePath(QStringLiteral("a.png")));
  window.findChild<QAction*>(QStringLiteral("camera"))->trigger();
  auto* page = window.findChild<CameraPage*>();
  auto* source = page->findChild<QComboBox*>(QStringLiteral("camera_source"));
  source->setEditText(QStringLiteral("images:") + views.path());
  auto* file = page->findChild<QLineEdit*>(QStringLiteral("camera_calibration"));
  file->setText(QStringLiteral("resources/cameras/overhead.toml"));
  page->findChild<QPushButton*>(QStringLiteral("camera_look"))->click();
  const auto* table = page->findChild<QAbstractItemView*>(QStringLiteral("camera_tags"))->model();
  auto* status = page->findChild<QLabel*>(QStringLiteral("camera_status"));
  const bool seen = QTest::qWaitFor(
      [&] { return table->rowCount() == 5 && status->text().contains(QStringLiteral("no more")); }, 30000);
  source->setEditText(QStringLiteral("images:pictures"));
  status->setText(status->text().replace(views.path(), QStringLiteral("pictures")));
  QTest::qWait(300);  // the layout
  const bool saved = page->grab().save(dir.filePath(QStringLiteral("camera-page.png")));
  delete page;
  return seen && saved;
}

/// Two emulated robots that were pinged, and one of them tested.
bool connect_page(MainWindow& window, const QDir& dir) {
  window.open(*app::parse_experiment("[camera]\nsource = \"synthetic\"\n[robot_defaults]\nlink = \"loopback\"\n"
                                     "[[robot]]\nname = \"anna\"\nstart = [-0.4, 0.2, 0.5]\n"
                                     "[[robot]]\nname = \"bert\"\nstart = [0.3, -0.2, 2.0]\n",
                                     "two.toml"),
              false);
  const auto wait = [](const std::function<bool()>& holds) { return QTest::qWaitFor(holds, 60000); };
  const LiveRun& live = window.live();
  if (!wait([&] { return live.is_open() && live.latest() != nullptr; })) return false;
  window.findChild<QAction*>(QStringLiteral("connect_robots_page"))->trigger();
  auto* page = window.findChild<ConnectPage*>();
  auto* table = page->findChild<QTableView*>(QStringLiteral("connect_robots"));
  auto* ping = page->findChild<QPushButton*>(QStringLiteral("connect_ping"));
  const auto carried_out = [&](const char* button) {
    page->findChild<QPushButton*>(QLatin1String(button))->click();
    return wait([&] { return ping->isEnabled(); });
  };
  table->selectAll();
  bool done = carried_out("connect_ping");
  table->selectRow(0);
  page->findChild<QPushButton*>(QStringLiteral("connect_test"))->click();
  done = carried_out("connect_drive") && done;
  page->resize(page->sizeHint().expandedTo({1000, 380}));
  QTest::qWait(300);  // the layout
  done = page->grab().save(dir.filePath(QStringLiteral("connect-page.png"))) && done;
  delete page;
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
  calibration->findChild<QDoubleSpinBox*>(QStringLiteral("calibration_columns"))->setValue(test::board::columns);
  calibration->findChild<QDoubleSpinBox*>(QStringLiteral("calibration_rows"))->setValue(test::board::rows);
  calibration->findChild<QPushButton*>(QStringLiteral("calibration_look"))->click();
  done = wait([&] { return calibration->findChild<QPushButton*>(QStringLiteral("calibration_save"))->isEnabled(); }) &&
         done;
  QTest::qWait(1000);  // the last view is solved with the others
  enter("calibration_source", QStringLiteral("v4l2:/dev/video0"));
  enter("calibration_file", QStringLiteral("camera.toml"));
  done = calibration->grab().save(dir.filePath(QStringLiteral("calibration.png"))) && done;
  done = camera_page(window, dir) && done;
  done = connect_page(window, dir) && done;
  window.close();
  static_cast<void>(wait([&] { return !window.isVisible(); }));
  return done ? 0 : 3;
}

}  // namespace
}  // namespace skein::ui

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  const skein::ui::test::OwnHome home;
  skein::ui::prepare(application);
  const QStringList words = QApplication::arguments();
  if (words.size() == 2) return skein::ui::take(QDir(words[1]));
  std::fprintf(stderr, "usage: skein_screenshots_runs DIR\n");
  return 2;
}
