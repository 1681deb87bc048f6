// Experiments and recordings as files: opened, dropped onto the window, remembered, and refused with a reason.
#include <fmt/format.h>

#include <QDragEnterEvent>
#include <QLabel>
#include <QMenu>
#include <QMimeData>
#include <QProcess>
#include <csignal>

#include "app/record/csv_file.h"
#include "operator.h"
#include "tests/places.h"
#include "ui/base/dialogs.h"
#include "ui/editor/experiment_editor.h"

namespace skein::ui::test {
namespace {

class Files : public Operator {
 protected:
  QString written(const char* name, const std::string& text) {
    QString path = dir.filePath(QString::fromLatin1(name));
    QFile file(path);
    EXPECT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(text.data(), static_cast<qint64>(text.size()));
    return path;
  }
  QString experiment(const char* name) {
    std::string text = app::paper_experiment().source;
    text.replace(text.find("\"platoon\""), 9, "\"mine\"");
    return written(name, text);
  }
  QString recording() {
    const auto short_run = app::parse_experiment(app::paper_experiment().source, "platoon.toml", {"duration=4"});
    QString path = dir.filePath(QStringLiteral("run.csv"));
    app::CsvFile csv(path.toStdString(), *short_run);
    auto session = app::Session::open(*short_run, app::Session::Clock::virtual_, {false, {&csv}});
    (*session)->run();
    csv.finish();
    return path;
  }
  bool drop(const QString& path) {
    QMimeData data;
    data.setUrls({QUrl::fromLocalFile(path)});
    QDragEnterEvent enter({400, 300}, Qt::CopyAction, &data, Qt::LeftButton, {});
    enter.ignore();
    QCoreApplication::sendEvent(&window, &enter);
    if (!enter.isAccepted()) return false;
    QDropEvent drop({400, 300}, Qt::CopyAction, &data, Qt::LeftButton, {});
    QCoreApplication::sendEvent(&window, &drop);
    return true;
  }
  QString problem() {
    MessageDialog* box = nullptr;
    EXPECT_TRUE(eventually([&] { return (box = window.findChild<MessageDialog*>(QStringLiteral("problem_dialog"))); }));
    QString text = box ? box->text() : QString();
    delete box;
    return text;
  }
  QStringList recent(MainWindow& of) {
    auto* menu = of.findChild<QMenu*>(QStringLiteral("recent"));
    emit menu->aboutToShow();
    QStringList names;
    for (const QAction* action : menu->actions())
      if (action->isEnabled()) names << action->text();
    return names;
  }
  QTemporaryDir dir;
};

TEST_F(Files, AreDroppedOntoTheWindow) {
  start();
  ASSERT_TRUE(drop(experiment("mine.toml")));
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().experiment().name == "mine"; }));
  EXPECT_FALSE(running()) << "nothing moves before the operator starts it";
  ASSERT_TRUE(drop(recording()));
  ASSERT_TRUE(eventually([&] { return window.replay().is_loaded(); }));
  EXPECT_EQ(window.replay().recording()->rows.size(), 100u);
}

/// Takes a while to be read and checked: every robot on a path of its own, for hours.
std::string large_experiment() {
  std::string text =
      "name = \"large\"\nduration = 36000\n[arena]\nwidth = 20.0\nheight = 20.0\n[reference]\nkind = "
      "'independent'\nspeed = 0.05\n[controller.gains]\nk_xx = 0.0\nk_tt = 0.0\nk_yy = 0.0\n";
  for (int i = 0; i < 16; ++i) {
    const int column = i % 8, row = i / 8;
    text += "[[robot]]\ntag = " + std::to_string(i) +
            "\ntrajectory = { path = { shape = 'ellipse', width = 1.3, height = 0.9, centre = [" +
            std::to_string(2 * column - 7) + ", " + std::to_string(2 * row - 7) +
            "] }, speed = " + fmt::format("{}", 0.03 + 0.0002 * i) + " }\n";
  }
  return text;
}

TEST_F(Files, AreReadWhileTheWindowGoesOn) {
  start();
  int frames = 0;
  bool told = false;
  QObject counts;  // as long as what it counts into
  QObject::connect(&window.live(), &LiveRun::frame, &counts, [&] { ++frames; });
  window.open_file(written("large.toml", large_experiment()));
  EXPECT_EQ(live().experiment().name, "platoon") << "it was opened before the window could do anything else";
  ASSERT_TRUE(eventually([&] {
    told = told || find<QLabel>("alert")->text().contains(QStringLiteral("Reading large.toml"));
    return live().experiment().name == "large" && live().is_open() && live().latest() != nullptr;
  }));
  EXPECT_GE(frames, 1) << "the window stood still until it was read";
  EXPECT_TRUE(told);
}

TEST_F(Files, CanBeOpenedAndRunsStoppedWhileAnotherIsRead) {
  start();
  window.open_file(written("large.toml", large_experiment()));
  window.stop();
  EXPECT_TRUE(eventually([&] { return stopped() || live().experiment().name != "platoon"; }));
  window.open_file(written("large.toml", large_experiment()));
  window.open_file(experiment("mine.toml"));
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() && live().experiment().name == "mine"; }));
  window.open_recording(recording());
  window.open_file(experiment("two.toml"));
  ASSERT_TRUE(eventually([&] { return live().file().endsWith(QStringLiteral("two.toml")) && live().is_open(); }));
  EXPECT_FALSE(window.replay().is_loaded()) << "what was opened last is wanted";
  window.open_file(written("large.toml", large_experiment()));  // and the window is closed meanwhile
}

TEST_F(Files, AreRemembered) {
  start();
  window.open_file(experiment("one.toml"));
  ASSERT_TRUE(eventually([&] { return live().file().endsWith(QStringLiteral("one.toml")) && live().latest(); }));
  window.open_file(experiment("two.toml"));
  ASSERT_TRUE(eventually([&] { return live().file().endsWith(QStringLiteral("two.toml")); }));
  EXPECT_EQ(recent(window).mid(0, 2), (QStringList{QStringLiteral("two.toml"), QStringLiteral("one.toml")}));
  MainWindow again;
  EXPECT_EQ(recent(again).mid(0, 2), (QStringList{QStringLiteral("two.toml"), QStringLiteral("one.toml")}));
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  find<QMenu>("recent")->actions().at(1)->trigger();
  ASSERT_TRUE(eventually([&] { return live().file().endsWith(QStringLiteral("one.toml")); }));
  EXPECT_EQ(recent(window).first(), QStringLiteral("one.toml"));
  QFile::remove(dir.filePath(QStringLiteral("two.toml")));
  EXPECT_FALSE(recent(window).contains(QStringLiteral("two.toml"))) << "it is gone";
  ASSERT_TRUE(eventually([&] { return live().is_open(); }));
}

TEST_F(Files, AreKnownToTheEditor) {
  start();
  window.open_file(experiment("known.toml"));
  ASSERT_TRUE(eventually([&] { return !live().file().isEmpty() && live().latest() != nullptr; }));
  find<QAction>("edit_experiment")->trigger();
  auto* editor = window.findChild<ExperimentEditor*>();
  ASSERT_NE(editor, nullptr);
  EXPECT_EQ(editor->windowTitle(), QStringLiteral("known.toml"));
}

TEST_F(Files, AreRefusedWithPlaceValueAndWhatIsAllowed) {
  start();
  window.open_file(written("wrong.toml", "duration = 10\n[controller]\nv_max = -1\n"));
  EXPECT_TRUE(eventually([&] {  // the editor shows the rest
    return find<QLabel>("alert")->text().contains(
        QStringLiteral("wrong.toml:3:9: controller.v_max: found -1, allowed: "));
  })) << find<QLabel>("alert")->text().toStdString();
  ASSERT_TRUE(drop(written("notes.txt", "hello")));
  const QString notes = problem();
  EXPECT_TRUE(notes.contains(QStringLiteral("notes.txt"))) << notes.toStdString();
  EXPECT_TRUE(notes.contains(QStringLiteral("(.toml)"))) << notes.toStdString();
  window.open_file(dir.filePath(QStringLiteral("nowhere.toml")));
  EXPECT_TRUE(problem().contains(QStringLiteral("cannot be read")));
  window.open_file(written("broken.csv", "# skein 0.1.0\nt,tick,r1_x\n0,0,zebra\n"));
  const QString broken = problem();
  EXPECT_TRUE(broken.contains(QStringLiteral("broken.csv:")) || broken.contains(QStringLiteral("experiment")))
      << broken.toStdString();
  EXPECT_TRUE(running()) << "what ran went on";
}

TEST_F(Files, ThatAreNoExperimentAreRefusedInADialogAndNeverEdited) {
  start();
  const QString picture = written("picture.toml", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16));
  const QString latin = written("latin.toml",
                                "name = \"Stra\xDF"
                                "e\"\n");
  const QString large = dir.filePath(QStringLiteral("large.toml")),
                folder = dir.filePath(QStringLiteral("folder.toml"));
  QFile sparse(large);
  ASSERT_TRUE(sparse.open(QIODevice::WriteOnly) && sparse.resize(200'000'000));
  ASSERT_TRUE(QDir().mkdir(folder));
  for (const auto& [file, said] : {std::pair{picture, "no text"}, std::pair{latin, "no text"},
                                   std::pair{large, "200000000 bytes"}, std::pair{folder, "it is a folder"}}) {
    window.open_file(file);
    const QString told = problem();
    EXPECT_TRUE(told.contains(QLatin1String(said))) << told.toStdString();
    EXPECT_EQ(window.findChild<ExperimentEditor*>(), nullptr) << file.toStdString();
  }
  EXPECT_TRUE(running());
}

TEST_F(Files, ThatVanishOrAreEmptyAreRefusedWithAReason) {
  start();
  const QString gone = experiment("gone.toml");
  window.open_file(gone);
  QFile::remove(gone);  // before or after it is read: either way the window goes on
  EXPECT_TRUE(eventually([&] {
    return live().experiment().name == "mine" || window.findChild<MessageDialog*>(QStringLiteral("problem_dialog"));
  }));
  delete window.findChild<MessageDialog*>(QStringLiteral("problem_dialog"));
  window.open_file(written("empty.csv", ""));
  EXPECT_TRUE(problem().contains(QStringLiteral("empty.csv")));
  std::string zeros;
  zeros.resize(10'000'000);
  window.open_file(written("zeros.csv", zeros));
  EXPECT_TRUE(problem().contains(QStringLiteral("zeros.csv")));
}

TEST_F(Files, AreNotOpenedWhileRealRobotsDrive) {
  const auto loopback = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(loopback.has_value());
  start(*loopback);
  window.open_file(experiment("mine.toml"));
  EXPECT_TRUE(problem().contains(QStringLiteral("Stop the run first")));
  EXPECT_TRUE(running());
}

TEST_F(Files, ThatNeedHardwareAreRehearsedWithoutIt) {
  const QDir cameras(QString::fromStdString(skein::test::in_source("resources/cameras")));
  ASSERT_TRUE(QFile::copy(cameras.filePath(QStringLiteral("overhead.toml")), dir.filePath(QStringLiteral("cal.toml"))));
  const QString file = written("lab.toml",
                               "name = \"lab\"\n[[robot]]\ntag = 4\nlink = \"serial:/dev/nowhere\"\n"
                               "[camera]\nsource = \"v4l2:/dev/nowhere\"\ncalibration = \"cal.toml\"\n"
                               "[failure]\nlink_bridge = 10.0\n");
  start();
  find<QAction>("rehearse")->trigger();
  EXPECT_TRUE(problem().contains(QStringLiteral("nothing to rehearse"))) << "the paper's experiment has no hardware";
  window.open_file(file);
  ASSERT_TRUE(eventually([&] { return live().experiment().name == "lab" && !live().is_busy(); }));
  const QString neither_robot_nor_camera = problem();
  EXPECT_TRUE(neither_robot_nor_camera.contains(QStringLiteral("Rehearse"))) << neither_robot_nor_camera.toStdString();
  find<QAction>("rehearse")->trigger();
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }))
      << live().failure().value_or(QString()).toStdString();
  EXPECT_EQ(live().experiment().name, "lab (rehearsal)");
  EXPECT_TRUE(window.windowTitle().contains(QStringLiteral("rehearsal"))) << window.windowTitle().toStdString();
  EXPECT_EQ(live().file(), file) << "the editor has the experiment, not its rehearsal";
  EXPECT_FALSE(running()) << "nothing moves before the operator starts it";
  ASSERT_TRUE(eventually([&] { return arena().scene().banner.startsWith(QStringLiteral("Ready")); }))
      << arena().scene().banner.toStdString();
  window.go();
  EXPECT_TRUE(eventually([&] { return running() && record().t >= 0.2; }));
}

/// The program itself, for a second and a half.
class Program : public Files {
 protected:
  void run(const QStringList& words) {
    QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
    environment.insert(QStringLiteral("QT_QPA_PLATFORM"), QStringLiteral("offscreen"));
    environment.insert(QStringLiteral("XDG_CONFIG_HOME"), dir.path());
    environment.insert(QStringLiteral("XDG_DATA_HOME"), dir.path());
    environment.insert(QStringLiteral("ASAN_OPTIONS"), QStringLiteral("detect_leaks=0"));  // Qt's are not ours
    process.setProcessEnvironment(environment);
    process.start(QString::fromStdString(skein::test::program()), words);
    ASSERT_TRUE(process.waitForStarted(patience_ms));
  }
  void TearDown() override {
    if (process.state() != QProcess::NotRunning) process.kill();
    process.waitForFinished(patience_ms);
  }
  static constexpr int patience_ms = 30000;
  QProcess process;
};

TEST_F(Program, PlaysARecordedRunThatIsNamed) {
  const QString file = recording();
  run({file});
  EXPECT_TRUE(QTest::qWaitFor(
      [&] {
        QFile settings(dir.filePath(QStringLiteral("skein/skein.ini")));
        return settings.open(QIODevice::ReadOnly) && settings.readAll().contains("run.csv");
      },
      patience_ms))
      << "it was not opened: " << process.readAllStandardError().toStdString();
  ::kill(static_cast<pid_t>(process.processId()), SIGTERM);
  ASSERT_TRUE(process.waitForFinished(patience_ms));
  EXPECT_EQ(process.exitCode(), 0) << process.readAllStandardError().toStdString();
}

TEST_F(Program, SaysThatARecordedRunIsNotThere) {
  run({dir.filePath(QStringLiteral("nowhere.csv"))});
  ASSERT_TRUE(process.waitForFinished(patience_ms));
  EXPECT_EQ(process.exitCode(), 2);
  EXPECT_TRUE(process.readAllStandardError().contains("nowhere.csv: cannot be opened"));
}

TEST_F(Files, AreNotSaidToBeWellWhereNoneIsOpen) {
  window.show();
  ASSERT_TRUE(eventually([&] { return find<QLabel>("phase")->text().contains(QStringLiteral("No experiment")); }));
  EXPECT_TRUE(eventually([&] { return find<QLabel>("alert")->text().startsWith(QStringLiteral("No experiment")); }))
      << find<QLabel>("alert")->text().toStdString();
}

}  // namespace
}  // namespace skein::ui::test
