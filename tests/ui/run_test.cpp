// The run bar: pause, step, speed, recording; and a window that hangs or a disk that is full.
#include <QComboBox>
#include <QDir>
#include <QDockWidget>
#include <QSettings>
#include <QSignalSpy>
#include <QThread>
#include <chrono>
#include <fstream>
#include <thread>

#include "app/replay/replay.h"
#include "operator.h"
#include "tests/places.h"
#include "tests/small_disk.h"

namespace skein::ui::test {
namespace {

class Run : public Operator {
 protected:
  void SetUp() override {
    QSettings(QSettings::IniFormat, QSettings::UserScope, "skein", "skein").setValue("recordings", recordings());
  }
  QString recordings() const { return directory_.filePath(QStringLiteral("runs")); }
  QStringList recorded_files() const { return QDir(recordings()).entryList({QStringLiteral("*.csv")}); }

  void choose_speed(double speed) {
    auto* box = find<QComboBox>("speed");
    const int index = box->findData(speed);
    ASSERT_GE(index, 0);
    emit box->activated(index);
  }
  void pause() {
    window.go();
    ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; }));
  }
  app::ReplayResult replayed(const QString& file) {
    std::ifstream in(file.toStdString());
    auto result = app::replay(in, file.toStdString());
    EXPECT_TRUE(result.has_value()) << result.error();
    return result.value_or(app::ReplayResult{});
  }

 private:
  QTemporaryDir directory_;
};

TEST_F(Run, StepsTickByTick) {
  start();
  pause();
  auto* step = find<QPushButton>("step");
  ASSERT_TRUE(eventually([&] { return step->isEnabled(); }));
  const std::int64_t before = record().tick;
  for (int k = 1; k <= 3; ++k) {
    QTest::mouseClick(step, Qt::LeftButton);
    ASSERT_TRUE(eventually([&] { return record().tick == before + k && live().phase() == app::Phase::paused; })) << k;
  }
  key(Qt::Key_F6);
  ASSERT_TRUE(eventually([&] { return record().tick == before + 4 && live().phase() == app::Phase::paused; }));
  for (const app::RobotRecord& robot : record().robots) EXPECT_EQ(robot.wheels, core::WheelSpeeds{});
}

TEST_F(Run, GoesFiftyTimesFasterAndLosesNoTick) {
  start();
  choose_speed(50.0);
  ASSERT_TRUE(eventually([&] { return record().t > 40.0; })) << "it got to " << record().t;
  EXPECT_EQ(live().speed(), 50.0);
  choose_speed(1.0);
  ASSERT_TRUE(eventually([&] { return find<QComboBox>("speed")->currentData().toDouble() == 1.0; }));
  const auto rows = live().history().rows();
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const bool missed = rows[k]->tick != rows[k - 1]->tick + 1;
    // In real time the machine may be late; faster, never.
    if (missed) {
      ASSERT_LT(rows[k]->t, 2.0) << "a tick was skipped at " << rows[k]->t;
    }
  }
}

TEST_F(Run, ObeysStopAtOnceInSlowMotion) {
  start();
  choose_speed(0.1);
  ASSERT_TRUE(eventually([&] { return live().speed() == 0.1; }));
  const double t = record().t;
  QTest::qWait(500);
  EXPECT_LT(record().t, t + 0.5);
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
}

TEST_F(Run, SaysWhyARealTimeRunHasNoOtherSpeed) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment.has_value());
  start(*experiment);
  for (const char* name : {"step", "speed"}) {
    ASSERT_TRUE(eventually([&] { return !find(name)->isEnabled(); })) << name;
    EXPECT_TRUE(find(name)->toolTip().contains(QStringLiteral("real time"))) << find(name)->toolTip().toStdString();
  }
  // On a loaded machine a missed deadline may be the greater alert at first.
  EXPECT_TRUE(eventually([&] {
    window.set_speed(10.0);
    return find<QLabel>("alert")->text().contains(QStringLiteral("real time"));
  }));
  EXPECT_EQ(live().speed(), 1.0);
}

TEST_F(Run, SaysHowLateItsTicksAreBesideABareThread) {
  std::uint64_t shown = 0;  // those before the start as well, which are no rows of the run
  QObject::connect(&live(), &LiveRun::record_shown, &window, [&] { ++shown; });
  start();
  const auto tip = [&] { return find<QLabel>("pace")->toolTip(); };
  EXPECT_TRUE(eventually([&] { return tip().contains(QStringLiteral("; a bare thread by ")); })) << tip().toStdString();
  EXPECT_TRUE(tip().contains(QStringLiteral("Ticks late by "))) << tip().toStdString();
  EXPECT_TRUE(tip().contains(QStringLiteral("real-time priority"))) << tip().toStdString();
  find<QDockWidget>("results_dock")->raise();
  EXPECT_TRUE(
      eventually([&] { return find<QLabel>("result_text")->text().contains(QStringLiteral("Ticks late by ")); }));
  const auto timing = live().timing();
  ASSERT_TRUE(timing);
  EXPECT_GT(timing->tick.total(), 0U);
  QSignalSpy polls(&live(), &LiveRun::frame);  // of the control thread, which may be ahead on a loaded machine
  ASSERT_TRUE(polls.wait(deadline_ms));
  EXPECT_LE(timing->tick.total(), shown + 1);
}

TEST_F(Run, RecordsARunThatCanBeReplayed) {
  start();
  choose_speed(10.0);
  ASSERT_TRUE(eventually([&] { return record().t > 5.0; }));
  QTest::mouseClick(find<QPushButton>("record"), Qt::LeftButton);  // what was before is in it all the same
  ASSERT_TRUE(eventually([&] { return recorded_files().size() == 1; }));
  ASSERT_TRUE(eventually([&] { return record().t > 20.0; }));
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped() && live().record_file().isEmpty(); })) << "the file is not finished";
  const app::ReplayResult result = replayed(QDir(recordings()).filePath(recorded_files().first()));
  EXPECT_TRUE(eventually([&] { return result.ticks == static_cast<std::int64_t>(live().history().size()); }))
      << result.ticks << " " << live().history().size();
  EXPECT_EQ(result.different, 0) << result.first;
}

TEST_F(Run, RecordsTheNextRunToAFileOfItsOwn) {
  start();
  window.record(true);
  ASSERT_TRUE(eventually([&] { return recorded_files().size() == 1; }));
  window.new_run();
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  EXPECT_EQ(recorded_files().size(), 1) << "before anything happened";
  window.go();
  ASSERT_TRUE(eventually([&] { return running(); }));
  EXPECT_TRUE(eventually([&] { return recorded_files().size() == 2; }));
}

TEST_F(Run, SaysAtOnceThatADiskTakesNothing) {
  start();
  window.record_to(QStringLiteral("/dev/full"));
  auto* box = find<QWidget>("problem_dialog");
  ASSERT_NE(box, nullptr);
  delete box;
  EXPECT_TRUE(running()) << "nothing was recorded yet: nothing was lost";
  EXPECT_TRUE(live().record_file().isEmpty());
}

TEST_F(Run, StopsWhenTheDiskFillsUp) {
  start();
  choose_speed(10.0);
  window.record(true);
  ASSERT_TRUE(eventually([&] { return recorded_files().size() == 1; }));
  bool over = false;
  {
    const skein::test::SmallDisk disk(200000);
    over = eventually([&] { return stopped(); });
  }
  ASSERT_TRUE(over) << "the robots drive on without a record";
  EXPECT_TRUE(eventually([&] {
    return find<QLabel>("alert")->text().contains(QStringLiteral("could not be recorded"));
  })) << find<QLabel>("alert")->text().toStdString();
}

TEST_F(Run, GoesOnWithoutAFilmWhenTheDiskFillsUp) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment.has_value());
  window.record(true);  // log and film: the film is by far the larger one
  bool told = false;
  {
    const skein::test::SmallDisk disk(1000000);
    start(*experiment);
    told = eventually([&] { return logged().contains(QStringLiteral("the film of this run ends here")); });
  }
  EXPECT_TRUE(told) << logged().toStdString();
  const std::int64_t tick = record().tick;
  EXPECT_TRUE(eventually([&] { return record().tick >= tick + 25; })) << "the run ended with its film";
  EXPECT_TRUE(running());
}

TEST_F(Run, GoesOnUnderAWindowThatHangs) {
  start();
  const std::int64_t before = record().tick;
  QThread::msleep(1500);  // what a driver, a dialog or a bug may do to the window's thread
  ASSERT_TRUE(eventually([&] { return record().tick >= before + 30; }));
  EXPECT_TRUE(running());
  EXPECT_TRUE(logged().contains(QStringLiteral("The window stalled")));
}

TEST_F(Run, StopsRobotsWithLinksUnderAWindowThatHangs) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment.has_value());
  start(*experiment);
  QThread::msleep(3600);  // five seconds would only make the test longer
  ASSERT_TRUE(eventually([&] { return stopped(); })) << "nobody could have stopped them";
  EXPECT_TRUE(eventually(
      [&] { return live().failure().value_or(QString()).contains(QStringLiteral("the window has not responded")); }));
}

TEST_F(Run, StopsRobotsWithLinksWhenTheDisplayStalls) {
  // Of a server of our own (tests/ui/on_x_server, on_wayland), which may be stalled.
  const auto server = static_cast<pid_t>(qEnvironmentVariableIntValue("SKEIN_DISPLAY_SERVER"));
  if (server <= 0) GTEST_SKIP() << "not on a display server of its own";
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment.has_value());
  start(*experiment);
  ASSERT_EQ(::kill(server, SIGSTOP), 0);
  std::thread mend([server] {
    std::this_thread::sleep_for(std::chrono::seconds(5));
    ::kill(server, SIGCONT);
  });
  EXPECT_TRUE(eventually([&] { return stopped(); })) << "nobody could have stopped them";
  mend.join();
  EXPECT_TRUE(eventually([&] { return logged().contains(QStringLiteral("The window stalled")); }));
  EXPECT_TRUE(eventually([&] {
    return live().failure().value_or(QString()).contains(QStringLiteral("the window has not responded"));
  })) << "but: "
      << live().failure().value_or(QString()).toStdString() << "\n"
      << logged().toStdString();
}

}  // namespace
}  // namespace skein::ui::test
