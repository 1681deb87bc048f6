// What the window shows is what is so: gains in force, robots that nobody knows to stand, runs that cannot start.
#include <QAbstractButton>
#include <QAbstractItemView>
#include <QAction>
#include <QComboBox>
#include <QDir>
#include <QDoubleSpinBox>
#include <QHelpEvent>
#include <QImage>
#include <QLabel>
#include <QLineEdit>
#include <QPointer>
#include <QProcess>
#include <QSlider>
#include <QTabBar>
#include <QTabWidget>
#include <QToolTip>
#include <cmath>
#include <csignal>
#include <fstream>

#include "app/record/csv_file.h"
#include "operator.h"
#include "tests/places.h"
#include "ui/base/dialogs.h"
#include "ui/gains/gains_panel.h"
#include "ui/plots/plot_view.h"
#include "ui/robots/robots_model.h"

namespace skein::ui::test {
namespace {

class Display : public Operator {
 protected:
  void type(const char* name, const QString& text) {
    auto* spin = find<QDoubleSpinBox>(name);
    spin->setFocus();
    ASSERT_TRUE(eventually([&] { return spin->hasFocus(); }));
    spin->selectAll();
    QTest::keyClicks(spin, text);
    QTest::keyClick(spin, Qt::Key_Return);
  }
  double target(core::GainName gain) { return live().gain_target(gain, 0, 1); }
  double shown(const char* name) { return find<QDoubleSpinBox>(name)->value(); }
  QString alert() { return find<QLabel>("alert")->text(); }
  QString robot_cell(int robot, RobotsModel::Column column) {
    return find<QAbstractItemView>("robots")->model()->index(robot, column).data().toString();
  }
  /// Emulated robots behind serial lines, under a camera that shows an empty floor.
  void start_emulator(int robots = 1) {
    emulator.start(QString::fromStdString(skein::test::program()),
                   {QStringLiteral("emulate"), QStringLiteral("--robots"), QString::number(robots),
                    QStringLiteral("--directory"), dir.path()});
    ASSERT_TRUE(eventually([&] { return QFile::exists(device()); }));
  }
  QString device(int robot = 1) { return dir.filePath(QStringLiteral("robot%1").arg(robot)); }
  app::Experiment linked(int robots = 1) {
    QImage floor(1280, 960, QImage::Format_Grayscale8);
    floor.fill(128);
    for (int k = 0; k < 60; ++k) EXPECT_TRUE(floor.save(dir.filePath(QStringLiteral("floor%1.png").arg(k, 3))));
    QString text;
    for (int k = 1; k <= robots; ++k)
      text += QStringLiteral("[[robot]]\ntag = %1\nlink = \"serial:%2\"\n").arg(k).arg(device(k));
    text += QStringLiteral("[camera]\nsource = \"images:%1\"\ncalibration = \"overhead.toml\"\n").arg(dir.path());
    auto experiment = app::parse_experiment(text.toStdString(), "linked.toml");
    EXPECT_TRUE(experiment.has_value());
    experiment->directory = skein::test::in_source("resources/cameras");
    return *experiment;
  }
  void end_emulator() {
    window.close();
    EXPECT_TRUE(eventually([&] { return !window.isVisible(); }));
    ::kill(static_cast<pid_t>(emulator.processId()), SIGCONT);
    emulator.terminate();
    EXPECT_TRUE(emulator.waitForFinished());
  }
  /// The paper's experiment on the virtual clock, recorded; `sets`: keys of its file.
  QString recorded(const std::vector<std::string>& sets = {"duration=12"}) {
    const auto experiment = app::parse_experiment(app::paper_experiment().source, "platoon.toml", sets);
    EXPECT_TRUE(experiment.has_value());
    QString file = dir.filePath(QStringLiteral("run.csv"));
    app::CsvFile csv(file.toStdString(), *experiment);
    (*app::Session::open(*experiment, app::Session::Clock::virtual_, {false, {&csv}}))->run();
    csv.finish();
    return file;
  }
  void replay(const QString& file) {
    window.resize(1280, 800);
    window.show();
    window.activateWindow();
    window.open_recording(file);
    ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
    ASSERT_TRUE(eventually([&] { return window.replay().is_loaded(); }));
    window.go();
    ASSERT_FALSE(window.replay().is_playing());
  }
  QTemporaryDir dir;
  QProcess emulator;
};

TEST_F(Display, AGainThatIsTypedIsTakenWithEitherDecimalSignAndHeldAtItsLimit) {
  start();
  type("spin_k_yy", QStringLiteral("0,05"));
  EXPECT_TRUE(eventually([&] { return std::abs(target(core::GainName::k_yy) - 0.05) < 1e-9; }))
      << target(core::GainName::k_yy);
  type("spin_k_yy", QStringLiteral("0.3"));
  const double limit = live().gain_limit(core::GainName::k_yy);
  ASSERT_LT(limit, 0.3);
  EXPECT_TRUE(eventually([&] { return std::abs(target(core::GainName::k_yy) - limit) < 1e-6; }))
      << target(core::GainName::k_yy);
  EXPECT_TRUE(eventually([&] { return alert().contains(QStringLiteral("k_yy is held at")); })) << alert().toStdString();
  EXPECT_TRUE(eventually([&] { return std::abs(shown("spin_k_yy") - limit) < 1e-3; })) << shown("spin_k_yy");
  type("spin_k_yy", QStringLiteral("-0.1"));
  EXPECT_TRUE(eventually([&] { return target(core::GainName::k_yy) == 0.0; }));
  EXPECT_TRUE(eventually([&] { return alert().contains(QStringLiteral("clamped at 0, its limit")); }))
      << alert().toStdString();
}

TEST_F(Display, ASliderThatIsHeldPastItsLimitShowsWhatIsInForceOnceItIsLetGo) {
  start();
  auto* slider = find<QSlider>("slider_k_tt");
  slider->setSliderDown(true);
  slider->setValue(slider->maximum());
  const double limit = live().gain_limit(core::GainName::k_tt);
  ASSERT_TRUE(eventually([&] { return std::abs(target(core::GainName::k_tt) - limit) < 1e-6; }));
  QTest::qWait(200);  // the rows with the event have come by now
  slider->setSliderDown(false);
  EXPECT_TRUE(eventually([&] { return std::abs(shown("spin_k_tt") - target(core::GainName::k_tt)) < 1e-4; }))
      << shown("spin_k_tt") << " is shown, " << target(core::GainName::k_tt) << " is in force";
}

TEST_F(Display, ARobotWhoseStopNobodyAcknowledgedMayBeDriving) {
  start_emulator();
  open_and_wait(linked());
  ASSERT_TRUE(eventually([&] { return robot_cell(0, RobotsModel::link) == QStringLiteral("up"); }));
  ASSERT_EQ(::kill(static_cast<pid_t>(emulator.processId()), SIGSTOP), 0);  // it hears nothing any more
  QTest::mouseClick(find<QPushButton>("stop"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  const QString said = QStringLiteral("may be driving");
  EXPECT_TRUE(eventually([&] { return robot_cell(0, RobotsModel::mode) == said; }))
      << robot_cell(0, RobotsModel::mode).toStdString();
  const Colours c = colours(window.palette());
  EXPECT_EQ(
      find<QAbstractItemView>("robots")->model()->index(0, RobotsModel::mode).data(Qt::ForegroundRole).value<QColor>(),
      c.alarm);
  EXPECT_TRUE(eventually([&] { return arena().scene().banner.contains(QStringLiteral("MAY BE DRIVING")); }))
      << arena().scene().banner.toStdString();
  EXPECT_TRUE(arena().scene().banner_alarms);
  EXPECT_EQ(arena().scene().style_of(0, c).name, said);
  ASSERT_EQ(::kill(static_cast<pid_t>(emulator.processId()), SIGCONT), 0);
  EXPECT_TRUE(eventually([&] { return robot_cell(0, RobotsModel::mode) != said; })) << "it has acknowledged";
  EXPECT_TRUE(eventually([&] { return !arena().scene().banner.contains(QStringLiteral("MAY BE DRIVING")); }));
  end_emulator();
}

TEST_F(Display, ARobotThatIsOutOfReachAsTheRunEndsByItselfMayBeDriving) {
  start_emulator();
  app::Experiment brief = linked();
  brief.duration = 1.0;  // it is over before the link counts as lost
  open_and_wait(brief);
  ASSERT_TRUE(eventually([&] { return robot_cell(0, RobotsModel::link) == QStringLiteral("up"); }));
  ASSERT_TRUE(const_cast<LiveRun&>(live()).start());  // the check list would ask for a tag
  ASSERT_TRUE(eventually([&] { return running(); }));
  ASSERT_EQ(::kill(static_cast<pid_t>(emulator.processId()), SIGSTOP), 0);
  ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::finished; }));
  EXPECT_TRUE(eventually([&] { return arena().scene().banner.contains(QStringLiteral("MAY BE DRIVING")); }))
      << arena().scene().banner.toStdString();
  ASSERT_EQ(::kill(static_cast<pid_t>(emulator.processId()), SIGCONT), 0);
  EXPECT_TRUE(eventually([&] { return arena().scene().banner.contains(QStringLiteral("Finished")); }))
      << "it has acknowledged: " << arena().scene().banner.toStdString();
  end_emulator();
}

TEST_F(Display, RobotsThatAreSwitchedOffAfterTheirStopRaiseNoAlarm) {
  const auto says = [&](const QString& text) { return arena().scene().banner.contains(text); };
  const auto both_are = [&](const QString& link) {
    return robot_cell(0, RobotsModel::link).startsWith(link) && robot_cell(1, RobotsModel::link).startsWith(link);
  };
  start_emulator(2);
  open_and_wait(linked(2));
  ASSERT_TRUE(eventually([&] { return both_are(QStringLiteral("up")); }));
  ASSERT_EQ(::kill(static_cast<pid_t>(emulator.processId()), SIGSTOP), 0);
  QTest::mouseClick(find<QPushButton>("stop"), Qt::LeftButton);
  EXPECT_TRUE(eventually([&] { return says(QStringLiteral("Robots 1, 2 MAY BE DRIVING")); }))
      << "the control: " << arena().scene().banner.toStdString();
  EXPECT_TRUE(eventually([&] { return alert().contains(QStringLiteral("robots 1, 2: they may be driving")); }))
      << alert().toStdString();
  ASSERT_EQ(::kill(static_cast<pid_t>(emulator.processId()), SIGCONT), 0);
  ASSERT_TRUE(eventually([&] { return alert().contains(QStringLiteral("All robots have acknowledged")); }))
      << alert().toStdString();
  // Names that lead nowhere: the kernel would soon give the killed program's terminals to another one.
  for (const int robot : {1, 2}) EXPECT_TRUE(QFile::remove(device(robot)));
  emulator.kill();
  ASSERT_TRUE(emulator.waitForFinished());
  ASSERT_TRUE(eventually([&] { return both_are(QStringLiteral("down")); }))
      << robot_cell(0, RobotsModel::link).toStdString();
  EXPECT_TRUE(alert().contains(QStringLiteral("All robots have acknowledged"))) << alert().toStdString();
  EXPECT_FALSE(says(QStringLiteral("MAY BE DRIVING"))) << arena().scene().banner.toStdString();
  window.close();
  EXPECT_TRUE(eventually([&] { return !window.isVisible(); }));
}

TEST_F(Display, RobotsThatAnEarlierRunLeftBehindAreStoppedFromTheWindow) {
  start_emulator();
  const EnvironmentVariable state_home("XDG_STATE_HOME", dir.filePath(QStringLiteral("state")).toUtf8());
  ASSERT_TRUE(QDir(dir.path()).mkpath(QStringLiteral("state/skein")));
  std::ofstream(dir.filePath(QStringLiteral("state/skein/run-999999")).toStdString())
      << "skein run lab\nserial:" << device().toStdString() << "\n";
  open_and_wait();
  auto* bar = find("left_behind");
  ASSERT_TRUE(eventually([&] { return bar->isVisible(); })) << "nothing is said of robots that may be driving";
  EXPECT_TRUE(find<QLabel>("left_behind_text")->text().contains(QStringLiteral("lab")));
  EXPECT_TRUE(eventually([&] { return alert() == QStringLiteral("Robots of an earlier run may be driving"); }))
      << alert().toStdString();
  QTest::mouseClick(find<QPushButton>("stop_left_behind"), Qt::LeftButton);
  EXPECT_TRUE(eventually([&] { return !bar->isVisible(); })) << find<QLabel>("left_behind_text")->text().toStdString();
  EXPECT_FALSE(QFile::exists(dir.filePath(QStringLiteral("state/skein/run-999999"))));
  end_emulator();
}

// Their batteries are empty, or they were taken away: no stop will ever be acknowledged.
TEST_F(Display, RobotsLeftBehindThatDoNotAnswerAreForgottenByTheOperator) {
  const EnvironmentVariable state_home("XDG_STATE_HOME", dir.filePath(QStringLiteral("state")).toUtf8());
  ASSERT_TRUE(QDir(dir.path()).mkpath(QStringLiteral("state/skein")));
  std::ofstream(dir.filePath(QStringLiteral("state/skein/run-999999")).toStdString())
      << "skein run lab\nserial:" << device().toStdString() << "\n";
  open_and_wait();
  auto* forget = find<QPushButton>("forget_left_behind");
  ASSERT_TRUE(eventually([&] { return find("left_behind")->isVisible(); }));
  EXPECT_FALSE(forget->isVisible()) << "before a stop was tried";
  QTest::mouseClick(find<QPushButton>("stop_left_behind"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return forget->isVisible(); }))
      << find<QLabel>("left_behind_text")->text().toStdString();
  // One that ends badly at this moment: the operator has not seen its name yet.
  const QString unseen = dir.filePath(QStringLiteral("state/skein/run-999998"));
  std::ofstream(unseen.toStdString()) << "skein run another\nserial:" << device(2).toStdString() << "\n";
  QTest::mouseClick(forget, Qt::LeftButton);
  EXPECT_TRUE(eventually([&] { return !QFile::exists(dir.filePath(QStringLiteral("state/skein/run-999999"))); }));
  EXPECT_TRUE(eventually([&] {
    const QString text = find<QLabel>("left_behind_text")->text();
    return text.contains(QStringLiteral("another")) && !text.contains(QStringLiteral("lab"));
  })) << find<QLabel>("left_behind_text")->text().toStdString();
  EXPECT_TRUE(QFile::remove(unseen));
  EXPECT_TRUE(eventually([&] { return !find("left_behind")->isVisible(); }));
}

TEST_F(Display, ARunThatCannotStartIsNotSaidToBeReady) {
  app::Experiment blind = app::paper_experiment();
  blind.simulation.dropout = 1.0;  // no pose ever comes
  open_and_wait(blind);
  ASSERT_TRUE(eventually([&] { return find("check_list")->isVisible(); }));
  EXPECT_TRUE(eventually([&] { return find<QLabel>("check_tags")->text().contains(QStringLiteral("robot")); }))
      << find<QLabel>("check_tags")->text().toStdString();
  EXPECT_TRUE(eventually([&] { return arena().scene().banner.isEmpty(); }))
      << "the list says it: " << arena().scene().banner.toStdString();
  EXPECT_TRUE(find<QLabel>("phase")->text().contains(QStringLiteral("Not ready")))
      << find<QLabel>("phase")->text().toStdString();
  EXPECT_TRUE(eventually([&] { return find<QLabel>("alert")->text().startsWith(QStringLiteral("Not ready: ")); }))
      << "while it says: " << find<QLabel>("alert")->text().toStdString();
  EXPECT_FALSE(find<QLabel>("check_mark_places")->text().contains(QStringLiteral("✓")))
      << find<QLabel>("check_places")->text().toStdString();
  EXPECT_FALSE(find<QLabel>("check_places")->text().contains(QStringLiteral("all robots")));
}

TEST_F(Display, OfAReplayIsThatOfTheRun) {
  replay(recorded());
  auto* tabs = find<QTabWidget>("gain_tabs");
  ASSERT_TRUE(tabs->isEnabled()) << "the margins cannot be opened";
  QTest::mouseClick(tabs->tabBar(), Qt::LeftButton, {}, tabs->tabBar()->tabRect(1).center());
  ASSERT_EQ(tabs->currentIndex(), 1);
  const auto* pairs = find<QAbstractItemView>("pair_table")->model();
  EXPECT_TRUE(eventually([&] { return pairs->index(0, 1).data().toString() == QStringLiteral("0.008"); }))
      << pairs->index(0, 1).data().toString().toStdString();
  EXPECT_FALSE(pairs->flags(pairs->index(0, 1)) & Qt::ItemIsEditable);
}

TEST_F(Display, OfAReplayTheTimeThatIsLeftAndWhatIsToComeAreThoseOfTheRecording) {
  const QString file = dir.filePath(QStringLiteral("stopped.csv"));
  const app::Experiment experiment = app::paper_experiment();
  app::CsvFile csv(file.toStdString(), experiment);
  auto session = app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}});
  int asked = 0;
  (*session)->run([&] { return ++asked < 8; });  // long before its end, and before the first kick
  csv.finish();
  replay(file);
  const double end = window.replay().recording()->rows.back().t;
  ASSERT_LT(end, experiment.perturbations.front().t);
  auto* line = find("time_line");
  QTest::keyClick(line, Qt::Key_Home);
  const QString all = QStringLiteral("−%1 s").arg(end - window.replay().t(), 0, 'f', 1);
  EXPECT_TRUE(eventually([&] { return find<QLabel>("time")->text().endsWith(all); }))
      << find<QLabel>("time")->text().toStdString() << ", of " << end << " s";
  const QPoint at(line->width() - 10, line->height() / 2);
  QHelpEvent tip(QEvent::ToolTip, at, line->mapToGlobal(at));
  QCoreApplication::sendEvent(line, &tip);
  EXPECT_FALSE(QToolTip::text().contains(QStringLiteral("robot"))) << "never came: " << QToolTip::text().toStdString();
}

TEST_F(Display, OfARunThatIsOverNothingCanBeChangedAndNoTimeIsLeft) {
  start();
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  EXPECT_TRUE(eventually([&] { return !find("spin_k_xx")->isEnabled(); })) << "a gain that nothing will ever follow";
  EXPECT_FALSE(find<QLabel>("time")->text().contains(QStringLiteral("−")))
      << find<QLabel>("time")->text().toStdString();
  const core::Pose before = record().robots[1].truth;
  const double now = record().now;
  drag(robot(1), robot(1) + QPoint(40, 30));
  EXPECT_TRUE(eventually([&] { return alert().contains(QStringLiteral("run is over")); })) << alert().toStdString();
  ASSERT_TRUE(eventually([&] { return record().now > now + 0.4; }));
  EXPECT_EQ(core::distance(record().robots[1].truth, before), 0.0);
  EXPECT_EQ(count(saved_events(), "move r2"), 0) << "the run would have a kick after its end";
}

TEST_F(Display, WithoutAnExperimentNothingIsSaidToHaveFailed) {
  const QString file = dir.filePath(QStringLiteral("broken.toml"));
  std::ofstream(file.toStdString()) << "rate = -3\n";
  window.resize(1280, 800);
  window.show();
  window.open_file(file);
  EXPECT_TRUE(eventually([&] { return find<QLabel>("phase")->text().contains(QStringLiteral("No experiment")); }))
      << find<QLabel>("phase")->text().toStdString();
  EXPECT_EQ(find<QLabel>("time")->text().toStdString(), "") << "of nothing";
}

TEST_F(Display, TextsAreRenewedFiveTimesASecondHoweverRareFramesAre) {
  start();
  auto* pace = find<QLabel>("pace");
  const auto renewed_at = [&](double now) {
    pace->setText(QStringLiteral("old"));
    emit const_cast<LiveRun&>(live()).frame(now);
    return pace->text() != QStringLiteral("old");
  };
  constexpr double later = 1e6;  // than any frame of this run [s]
  for (const double t : {0.0, 0.2, 0.9, 3.0, 3.5}) EXPECT_TRUE(renewed_at(later + t)) << t;
  for (const double t : {3.53, 3.56, 3.6})
    EXPECT_FALSE(renewed_at(later + t)) << "control: too often to be read, " << t;
  EXPECT_TRUE(renewed_at(later + 3.7));
}

TEST_F(Display, NumbersThatAreNotKnownAreNotShown) {
  QStringList said;
  const auto listen = [&] { said << find<QLabel>("pace")->text(); };
  const auto listening = QObject::connect(&window.live(), &LiveRun::frame, &window, listen);
  replay(recorded());
  listen();  // of the first tick, which has no period
  QObject::disconnect(listening);
  for (const QString& text : said) EXPECT_FALSE(text.contains(QStringLiteral("nan"))) << text.toStdString();
  EXPECT_TRUE(said.last().contains(QStringLiteral("closest pair"))) << said.last().toStdString();
}

TEST_F(Display, ARobotThatIsHeldIsDrawnCoupledToNobody) {
  start();
  find<QAbstractItemView>("robots")->setCurrentIndex(find<QAbstractItemView>("robots")->model()->index(1, 0));
  arena().select(1);
  ASSERT_TRUE(eventually([&] { return find<QAbstractButton>("hold_robot")->isEnabled(); }));
  find<QAbstractButton>("hold_robot")->click();
  EXPECT_TRUE(eventually([&] { return arena().scene().is_out_of_group(1); }));
  EXPECT_FALSE(arena().scene().is_out_of_group(0));
}

TEST_F(Display, AfterANewRunPlotsKeepTheirAxesAndOldNumbersAreGone) {
  start();
  ASSERT_TRUE(eventually([&] { return !find<QLabel>("pace")->text().isEmpty() && record().t > 0.5; }));
  ASSERT_TRUE(eventually([&] { return !live().is_busy(); }));
  window.new_run();
  EXPECT_EQ(find<QLabel>("pace")->text(), QString());
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  QTest::qWait(300);  // pictures of the plots are due
  auto* plot = find<QCustomPlot>("plot");
  int axes = 0;
  for (const QCPAxisRect* rect : plot->axisRects()) axes += rect->visible() ? 1 : 0;
  EXPECT_GT(axes, 1) << "the plots have lost their axes";
}

TEST_F(Display, AFreshRowOfTheScheduleChangesNothing) {
  open_and_wait();
  find<QTabWidget>("gain_tabs")->setCurrentIndex(2);
  ASSERT_TRUE(eventually([&] { return find<QPushButton>("schedule_add")->isEnabled(); }));
  QTest::mouseClick(find<QPushButton>("schedule_add"), Qt::LeftButton);
  QTest::mouseClick(find<QPushButton>("schedule_apply"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().experiment().gain_changes.size() == 1; }));
  const app::GainChange& change = live().experiment().gain_changes.front();
  for (const core::GainName gain : core::gain_names)
    EXPECT_EQ(change[gain]->largest(), core::table(live().experiment().controller.gains, gain).largest());
}

TEST_F(Display, ARecordingWithATornLastLineIsPlayedWithoutIt) {
  const QString file = recorded({"duration=4"});
  QFile csv(file);
  ASSERT_TRUE(csv.open(QIODevice::ReadWrite));
  const QByteArray all = csv.readAll();
  ASSERT_TRUE(csv.resize(all.size() - 40));
  csv.close();
  replay(file);
  EXPECT_EQ(window.replay().recording()->rows.size(), 99u);
  EXPECT_TRUE(alert().contains(QStringLiteral("torn"))) << alert().toStdString();
}

TEST_F(Display, ARecordingThatCannotBeReadIsNotBeingReadForEver) {
  const QString file = dir.filePath(QStringLiteral("broken.csv"));
  std::ofstream(file.toStdString()) << "# skein 0.1.0\nt,tick,r1_x\n0,0,zebra\n";
  start();
  window.open_recording(file);
  ASSERT_TRUE(eventually([&] { return window.findChild<MessageDialog*>() != nullptr; }));
  EXPECT_FALSE(alert().contains(QStringLiteral("Reading"))) << alert().toStdString();
}

TEST_F(Display, EscapeClosesAMessageBeforeAStartAndStopsNothing) {
  open_and_wait();
  find<QAction>("shortcuts")->trigger();
  auto* dialog = find<QDialog>("shortcuts_dialog");
  dialog->activateWindow();
  ASSERT_TRUE(QTest::qWaitForWindowActive(dialog));
  QPointer<QDialog> open = dialog;
  key(Qt::Key_Escape, dialog);
  EXPECT_TRUE(eventually([&] { return !open; })) << "the dialog is open";
  EXPECT_EQ(live().phase(), app::Phase::ready) << "nothing moved, and a new run is needed all the same";
  EXPECT_FALSE(live().stop_asked());
}

TEST_F(Display, F5SetsARunUpAgainThatIsOver) {
  start();
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  ASSERT_TRUE(eventually([&] { return find<QAction>("go_action")->isEnabled(); })) << "F5 does nothing";
  key(Qt::Key_F5);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() && live().phase() == app::Phase::ready; }));
  QTest::qWait(200);
  EXPECT_EQ(live().phase(), app::Phase::ready) << "after STOP nothing starts by one key";
}

TEST_F(Display, KeysOfTheRunWorkWhileAMessageHasTheFocus) {
  open_and_wait();
  ASSERT_TRUE(eventually([&] { return find<QAction>("go_action")->isEnabled(); }));
  find<QAction>("about")->trigger();
  auto* dialog = find<QDialog>("about_dialog");
  dialog->activateWindow();
  ASSERT_TRUE(QTest::qWaitForWindowActive(dialog));
  ASSERT_TRUE(eventually([&] { return arena().scene().banner.startsWith(QStringLiteral("Ready")); }));
  key(Qt::Key_F5, dialog);
  EXPECT_TRUE(eventually([&] { return running(); })) << "F5 is dead in a message";
  delete dialog;
}

TEST_F(Display, SpacePausesAReplayAndPlaysIt) {
  replay(recorded());
  key(Qt::Key_Space);
  EXPECT_TRUE(window.replay().is_playing());
  key(Qt::Key_Space);
  EXPECT_FALSE(window.replay().is_playing());
}

TEST_F(Display, ARobotIsNotDroppedOntoAnother) {
  start();
  const QPoint there = robot(2);
  const core::Pose before = *arena().scene().pose(0);
  drag(robot(0), there);
  EXPECT_TRUE(eventually([&] { return alert().contains(QStringLiteral("robot 3 is ")); })) << alert().toStdString();
  const core::Pose now = *arena().scene().pose(0);
  EXPECT_LT(std::hypot(now.x - before.x, now.y - before.y), 0.05);
}

TEST_F(Display, WithoutItsCameraAnExperimentOpensAndSaysWhatIsMissing) {
  app::Experiment experiment = app::paper_experiment();
  experiment.camera.source = "v4l2:/dev/no-such-camera";
  experiment.camera.calibration = "overhead.toml";
  experiment.directory = skein::test::in_source("resources/cameras");
  open_and_wait(experiment);
  EXPECT_TRUE(live().is_open());
  EXPECT_TRUE(eventually([&] {
    return find<QLabel>("check_camera")->text().contains(QStringLiteral("no-such-camera"));
  })) << find<QLabel>("check_camera")->text().toStdString();
  EXPECT_GT(find<QAbstractItemView>("robots")->model()->rowCount(), 0);
  EXPECT_GT(live().gain_limit(core::GainName::k_xx), 0.0);
  window.go();
  QTest::qWait(100);
  EXPECT_EQ(live().phase(), app::Phase::ready) << "nobody drives blind";
}

}  // namespace
}  // namespace skein::ui::test
