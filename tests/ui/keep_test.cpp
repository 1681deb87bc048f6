// Runs of the window that are kept, each in a folder of its own.
#include <QAction>
#include <QDir>
#include <QDockWidget>
#include <QFileDialog>
#include <QLabel>
#include <QSignalSpy>
#include <algorithm>
#include <filesystem>

#include "app/calibration/calibration_file.h"
#include "app/runs/find_run.h"
#include "app/runs/run_folder.h"
#include "app/runs/verify.h"
#include "app/session/experiment_cameras.h"
#include "operator.h"
#include "tests/app/film_copy.h"
#include "tests/places.h"
#include "tests/vision/half_as_fine.h"
#include "ui/base/settings.h"
#include "ui/main/result_controller.h"
#include "ui/status/alert_strip.h"

namespace skein::ui::test {
namespace {

class Keep : public Operator {
 protected:
  void SetUp() override { find<QAction>("keep_runs")->setChecked(true); }
  void TearDown() override {
    find<QAction>("keep_films")->setChecked(false);
    find<QAction>("keep_runs")->setChecked(false);  // the other tests' setting
    Operator::TearDown();
  }
  static app::Experiment seconds(const char* duration) {
    const auto experiment = app::parse_experiment(app::paper_experiment().source, "short.toml", {duration});
    EXPECT_TRUE(experiment);
    return experiment.value_or(app::Experiment{});
  }
  QStringList folders() const {
    return QDir(QString::fromStdString(app::runs_directory({}).value())).entryList(QDir::Dirs | QDir::NoDotAndDotDot);
  }
  /// Beside the folders of runs.
  static QStringList other_films() {
    return QDir(QString::fromStdString(app::runs_directory({}).value()))
        .entryList({QStringLiteral("*.mkv")}, QDir::Files | QDir::Hidden);
  }
  static std::string state_of(const QString& folder) {
    const auto story = app::read_story(folder.toStdString());
    return story ? (*story)["state"].get<std::string>() : story.error();
  }

  QTemporaryDir directory_;
  EnvironmentVariable data_home_{"XDG_DATA_HOME", directory_.path().toUtf8()};
};

TEST_F(Keep, ARunThatEndsHasAFolderThatIsFoundAndVerified) {
  QSignalSpy kept(&live(), &LiveRun::kept);
  start(seconds("duration=2"));
  ASSERT_EQ(folders().size(), 1);
  EXPECT_TRUE(logged().contains(QStringLiteral("This run is kept in ") + directory_.path())) << logged().toStdString();
  ASSERT_TRUE(eventually([&] { return kept.size() == 1; }));
  const QString folder = kept[0][0].toString();
  EXPECT_EQ(state_of(folder), "finished");
  find<QDockWidget>("results_dock")->raise();
  EXPECT_TRUE(eventually([&] { return find<QLabel>("result_text")->text().contains(folder); }));
  EXPECT_EQ(app::find_run("last", app::runs_directory({}).value()).value_or(""), folder.toStdString());
  const auto found = app::verify_run(folder.toStdString());
  ASSERT_TRUE(found) << found.error();
  for (const auto& step : found->steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
  EXPECT_TRUE(logged().contains(QStringLiteral("Kept in ") + folder)) << logged().toStdString();

  // What is shown afterwards is a replay: no run of its own.
  window.open_recording(folder + QStringLiteral("/run.csv"));
  ASSERT_TRUE(eventually([&] { return window.windowTitle().contains(QStringLiteral("replay")); }));
  EXPECT_EQ(folders().size(), 1);
  EXPECT_TRUE(window.windowTitle().contains(QDir(folder).dirName())) << "the record of every kept run is run.csv";
}

TEST_F(Keep, RunsAreFoundAtTheSideOfEveryDialogThatOpensOne) {
  start(seconds("duration=60"));
  const QUrl runs = QUrl::fromLocalFile(QString::fromStdString(app::runs_directory({}).value()));
  for (const auto& [action, name] :
       {std::pair{"open", "open_dialog"}, {"open_recording", "open_recording_dialog"}, {"compare", "compare_dialog"}}) {
    find<QAction>(action)->trigger();
    EXPECT_TRUE(find<QFileDialog>(name)->sidebarUrls().contains(runs)) << name;
  }
}

TEST_F(Keep, ARunThatAnotherOneEndsIsCompletedToo) {
  QSignalSpy kept(&live(), &LiveRun::kept);
  start(seconds("duration=60"));
  window.new_run();
  ASSERT_TRUE(eventually([&] { return kept.size() == 1; }));
  EXPECT_EQ(state_of(kept[0][0].toString()), "stopped");
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() && !live().is_busy(); }));
  EXPECT_EQ(folders().size(), 1) << "the new one has not begun";
}

TEST_F(Keep, ARunWithACameraHasItsFilmIfThatIsWanted) {
  const std::string file = skein::test::in_source("resources/experiments/platoon-loopback.toml");
  const std::string camera = directory_.filePath(QStringLiteral("camera.toml")).toStdString();
  const auto finer = app::load_experiment(file);
  ASSERT_TRUE(finer);
  const auto calibration = app::camera_calibration(*finer);
  ASSERT_TRUE(calibration);
  ASSERT_TRUE(app::save_calibration(skein::test::half_as_fine(*calibration), camera));
  const auto experiment = app::load_experiment(file, {"duration=2", "camera.calibration=" + camera});
  ASSERT_TRUE(experiment);
  EXPECT_FALSE(find<QAction>("keep_films")->isChecked()) << "it is large";
  EXPECT_TRUE(find<QAction>("keep_films")->toolTip().contains(QStringLiteral("GB a minute")));
  find<QAction>("keep_films")->setChecked(true);
  EXPECT_TRUE(MainWindow().findChild<QAction*>(QStringLiteral("keep_films"))->isChecked()) << "remembered";
  QSignalSpy kept(&live(), &LiveRun::kept);
  start(*experiment);
  ASSERT_TRUE(eventually([&] { return kept.size() == 1; })) << "while the camera still looks";
  EXPECT_EQ(kept[0][1].toString().toStdString(), "");
  const QString folder = kept[0][0].toString();
  EXPECT_TRUE(QFile::exists(folder + QStringLiteral("/film.mkv")));
  EXPECT_TRUE(other_films().isEmpty()) << other_films().join(' ').toStdString();
  const auto found = app::verify_run(folder.toStdString());
  ASSERT_TRUE(found) << found.error();
  bool from_film = false;
  for (const auto& step : found->steps) {
    EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
    from_film = from_film || step.finding.find("frames of the film") != std::string::npos;
  }
  EXPECT_TRUE(from_film);

  // Without one frame: the film is not the run's any more, but it does not show other commands.
  const std::string film = folder.toStdString() + "/film.mkv";
  skein::test::copy_film(film, film + ".copy", {skein::test::frames_of(film) / 2});
  std::filesystem::rename(film + ".copy", film);
  const auto lacking = app::verify_run(folder.toStdString());
  ASSERT_TRUE(lacking) << lacking.error();
  for (const auto& step : lacking->steps) {
    EXPECT_EQ(step.holds, step.what != "files") << step.what << ": " << step.finding;
    if (step.what == "commands") {
      EXPECT_NE(step.finding.find("frames of the film; the film, which lacks frames, gives "), std::string::npos)
          << step.finding;
    }
  }

  // A film of the same experiment from another time, which lacks its first frame: nothing of it is compared bit for
  // bit.
  skein::test::copy_film(film, film + ".copy", {0}, 1000.0);
  std::filesystem::rename(film + ".copy", film);
  const auto other = app::verify_run(folder.toStdString());
  ASSERT_TRUE(other) << other.error();
  for (const auto& step : other->steps) {
    if (step.what != "commands") continue;
    EXPECT_FALSE(step.holds) << step.finding;
    EXPECT_NE(step.finding.find("it is that of another run"), std::string::npos) << step.finding;
  }
}

TEST_F(Keep, ARunHasThePictureOfATagThatWasNotSeen) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"),
                                               {"duration=60", "operator.1={t=0.4, does=\"move r2 x=3 y=3 theta=0\"}"});
  ASSERT_TRUE(experiment) << "beyond what the camera sees";
  QSignalSpy kept(&live(), &LiveRun::kept);
  start(*experiment);
  ASSERT_TRUE(live().keeps());
  const QString folder = live().kept_folder(), sentence = QStringLiteral("no tag 2 is in the picture");
  ASSERT_TRUE(eventually([&] { return !live().crops().empty(); }));
  EXPECT_EQ(live().crops().front().robot, 1U);
  EXPECT_TRUE(QFile::exists(folder + QStringLiteral("/tag-2.png"))) << "at once";
  window.stop();

  // The report of the run that is shown, in a folder of its own.
  settings().setValue(QStringLiteral("recordings"), directory_.filePath(QStringLiteral("reports")));
  QSignalSpy saved(window.findChild<ResultController*>(), &ResultController::saved);
  find<QPushButton>("save_results")->click();
  ASSERT_TRUE(eventually([&] { return saved.size() == 1; }));
  EXPECT_EQ(saved[0][1].toStringList().join(' ').toStdString(), "");
  const auto shows_it = [&](const QString& report) {
    QFile page(report + QStringLiteral("/report.html"));
    EXPECT_TRUE(page.open(QIODevice::ReadOnly)) << report.toStdString();
    const QString html = QString::fromUtf8(page.readAll());
    return html.contains(QStringLiteral("data:image/png;base64,")) && html.contains(sentence);
  };
  settings().remove(QStringLiteral("recordings"));
  EXPECT_TRUE(shows_it(saved[0][0].toString()));

  ASSERT_TRUE(eventually([&] { return kept.size() == 1; }));
  const auto found = app::verify_run(folder.toStdString());
  ASSERT_TRUE(found) << found.error();
  for (const auto& step : found->steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
  const auto story = app::read_story(folder.toStdString());
  ASSERT_TRUE(story && story->contains("not_seen"));
  EXPECT_EQ((*story)["not_seen"][0]["sentence"], sentence.toStdString());

  // That of its replay, in its own.
  window.open_recording(folder + QStringLiteral("/run.csv"));
  ASSERT_TRUE(eventually([&] { return window.windowTitle().contains(QStringLiteral("replay")); }));
  find<QPushButton>("save_results")->click();
  ASSERT_TRUE(eventually([&] { return saved.size() == 2; }));
  EXPECT_EQ(saved[1][0].toString(), folder);
  EXPECT_TRUE(shows_it(folder));
}

TEST_F(Keep, AFilmOfARunThatNeverBeganIsRemoved) {
  const auto experiment =
      app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"), {"duration=2"});
  ASSERT_TRUE(experiment);
  find<QAction>("keep_films")->setChecked(true);
  open_and_wait(*experiment);
  EXPECT_EQ(other_films().size(), 1);
  window.open(seconds("duration=60"), false);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() && !live().is_busy(); }));
  EXPECT_TRUE(other_films().isEmpty()) << other_films().join(' ').toStdString();
  EXPECT_TRUE(folders().isEmpty());
}

TEST_F(Keep, IsSwitchedOffAndThatIsRemembered) {
  find<QAction>("keep_runs")->setChecked(false);
  EXPECT_FALSE(MainWindow().findChild<QAction*>(QStringLiteral("keep_runs"))->isChecked());
  start(seconds("duration=60"));
  EXPECT_FALSE(live().keeps());
  EXPECT_TRUE(folders().isEmpty());
  find<QAction>("keep_runs")->setChecked(true);
  EXPECT_TRUE(MainWindow().findChild<QAction*>(QStringLiteral("keep_runs"))->isChecked());
  EXPECT_FALSE(live().keeps()) << "from the next run on";
  settings().remove(QStringLiteral("keep_runs"));
  EXPECT_TRUE(MainWindow().findChild<QAction*>(QStringLiteral("keep_runs"))->isChecked()) << "the default";
}

TEST_F(Keep, ThatIsNotPossibleIsAnAlarmAndTheRunGoesOn) {
  const EnvironmentVariable data_home("XDG_DATA_HOME", "/proc/none");
  start(seconds("duration=60"));
  EXPECT_FALSE(live().keeps());
  EXPECT_TRUE(logged().contains(QStringLiteral("this run is not kept: /proc/none"))) << logged().toStdString();
  const double t = record().t;
  EXPECT_TRUE(eventually([&] { return running() && record().t > t; }));
  auto* alert = find<AlertStrip>("alert");
  alert->say(QStringLiteral("other news"), Severity::alarm);
  EXPECT_TRUE(eventually([&] { return alert->text().contains(QStringLiteral("not kept")); }))
      << "all is well as soon as it was said: " << alert->text().toStdString();
  window.new_run();
  EXPECT_TRUE(eventually([&] { return live().is_open() && !alert->text().contains(QStringLiteral("not kept")); }));
}

}  // namespace
}  // namespace skein::ui::test
