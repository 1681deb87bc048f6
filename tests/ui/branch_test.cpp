// "Go on from here": the past comes out the same, and the rest is the operator's.
#include <fmt/format.h>

#include <QSignalSpy>
#include <functional>

#include "app/record/csv_file.h"
#include "large_experiment.h"
#include "operator.h"
#include "ui/gains/gains_panel.h"
#include "ui/main/branch_controller.h"
#include "ui/results/result_panel.h"

namespace skein::ui::test {
namespace {

class Branch : public Operator {
 protected:
  bool paused() { return live().latest() != nullptr && live().phase() == app::Phase::paused; }
  void go_on_from_here() {
    repeat([this] { key(Qt::Key_B, nullptr, Qt::ControlModifier); });
  }
  void repeat(const std::function<void()>& ask) {
    again_ = false;
    const auto opened = QObject::connect(&live(), &LiveRun::opened, &window, [this] { again_ = true; });
    ask();
    EXPECT_TRUE(eventually([&] { return again_; })) << "it does not begin anew: " << alert().toStdString();
    QObject::disconnect(opened);
  }
  QString alert() { return find<QLabel>("alert")->text(); }

  /// `off`: by so much at most [m].
  static void expect_same_places(const app::TickRecord& one, const app::TickRecord& other, double off) {
    ASSERT_EQ(one.robots.size(), other.robots.size());
    for (std::size_t i = 0; i < one.robots.size(); ++i) {
      EXPECT_NEAR(one.robots[i].truth.x, other.robots[i].truth.x, off) << "robot " << i + 1;
      EXPECT_NEAR(one.robots[i].truth.y, other.robots[i].truth.y, off) << "robot " << i + 1;
    }
  }

 private:
  // A wait for the session to be gone, or for a time before the branch, may come when both are over: a busy thread
  // finds all of the past in one look.
  bool again_ = false;
};

TEST_F(Branch, OfALiveSimulationRepeatsWhatTheHandDidAndPauses) {
  start();
  const QPoint from = robot(1);
  drag(from, from + QPoint(30, 25));
  moved(1);
  const double moved_at = record().t;
  ASSERT_TRUE(eventually([&] { return record().t > moved_at + 0.5; }));
  window.go();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  const app::TickRecord before = record();
  ASSERT_GT(core::distance(before.robots[1].pose, before.robots[1].nominal.pose), 0.02)
      << "the hand's mark is still there";

  go_on_from_here();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  EXPECT_NEAR(record().t, before.t, 1e-9);
  expect_same_places(record(), before, 1e-9);
  EXPECT_EQ(live().speed(), 1.0);

  window.go();
  EXPECT_TRUE(eventually([&] { return running() && record().t > before.t + 0.2; })) << "it goes on";
}

TEST_F(Branch, TakesTheLastGestureBackAndDoesItAgain) {
  start();
  const auto away = [&](std::size_t i) {
    return core::distance(record().robots[i].pose, record().robots[i].nominal.pose);
  };
  const auto drag_and_pause = [&](std::size_t i, QPoint by) {
    const QPoint from = robot(i);
    drag(from, from + by);
    moved(i);
    const double moved_at = record().t;
    ASSERT_TRUE(eventually([&] { return record().t > moved_at + 0.8; }));
    window.go();
    ASSERT_TRUE(eventually([&] { return paused(); }));
    ASSERT_GT(away(i), 0.02) << "the hand's mark is still there";
  };
  const auto by = [&](const char* action) {
    repeat([&] { find<QAction>(action)->trigger(); });
    ASSERT_TRUE(eventually([&] { return paused(); }));
  };
  drag_and_pause(1, QPoint(30, 25));
  const app::TickRecord first = record();
  window.go();
  ASSERT_TRUE(eventually([&] { return running(); }));
  const double untouched = away(2);  // not 0: it is coupled to the one that was dragged first
  drag_and_pause(2, QPoint(-30, 25));
  const app::TickRecord second = record();

  by("take_back");
  EXPECT_NEAR(away(2), untouched, 0.004) << "as if nobody had touched it";
  EXPECT_GE(record().t, first.t) << "what was done before stays";
  by("take_back");
  EXPECT_LT(away(1), 0.005);
  EXPECT_LT(record().t, first.t);
  by("do_again");
  EXPECT_GE(record().t, first.t);
  by("do_again");
  EXPECT_NEAR(record().t, second.t, 1e-9);
  expect_same_places(record(), second, 1e-9);
  find<QAction>("do_again")->trigger();
  EXPECT_TRUE(alert().contains(QStringLiteral("Nothing has been taken back"))) << alert().toStdString();
}

TEST_F(Branch, TakesBackWhatWasDoneDuringAPause) {
  start();
  ASSERT_TRUE(eventually([&] { return record().t > 0.5; }));
  window.go();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  const app::TickRecord before = record();
  const QPoint from = robot(1);
  drag(from, from + QPoint(30, 25));
  moved(1);
  ASSERT_TRUE(eventually([&] { return core::distance(record().robots[1].truth, before.robots[1].truth) > 0.02; }));
  const app::TickRecord after = record();
  repeat([&] { find<QAction>("take_back")->trigger(); });
  ASSERT_TRUE(eventually([&] { return paused(); }));
  expect_same_places(record(), before, 1e-9);
  repeat([&] { find<QAction>("do_again")->trigger(); });
  ASSERT_TRUE(eventually([&] { return paused(); }));
  expect_same_places(record(), after, 1e-9);
  EXPECT_NEAR(record().t, after.t, 1e-9);
}

TEST_F(Branch, HasNothingToTakeBackWhereNothingWasDone) {
  start();
  window.go();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  const double t = record().t;
  find<QAction>("take_back")->trigger();
  EXPECT_TRUE(alert().contains(QStringLiteral("Nothing has been done to this run"))) << alert().toStdString();
  EXPECT_EQ(record().t, t);
}

TEST_F(Branch, OfABranchHasNothingInItsPastThatDidNotHappen) {
  constexpr double planned = 5.0;  // [s]
  const auto experiment = app::parse_experiment(
      app::paper_experiment().source + fmt::format("\n[[operator]]\nt = {}\ndoes = \"hold r2\"\n", planned),
      "planned.toml");
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  start(*experiment);
  window.go();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  ASSERT_LT(record().t, planned);
  go_on_from_here();  // what the file does later may now be done otherwise
  ASSERT_TRUE(eventually([&] { return paused(); }));
  window.go();
  window.set_speed(10.0);
  ASSERT_TRUE(eventually([&] { return record().t > planned + 1.0; }));
  window.go();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  const app::TickRecord before = record();
  ASSERT_EQ(count(saved_events(), "hold r2"), 0);

  go_on_from_here();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  EXPECT_NEAR(record().t, before.t, 1e-9);
  EXPECT_EQ(count(saved_events(), "hold r2"), 0) << "the second branch has another past than the first";
  expect_same_places(record(), before, 1e-7);
  const auto written = app::parse_experiment(live().experiment().source, "written.toml");
  ASSERT_TRUE(written);
  EXPECT_TRUE(written->actions.empty()) << "its text has what never happened";
}

TEST_F(Branch, OfAReplayGoesOnLiveFromItsPresentMoment) {
  app::Experiment experiment = app::paper_experiment();
  const QTemporaryDir dir;
  const QString file = dir.filePath(QStringLiteral("run.csv"));
  app::CsvFile csv(file.toStdString(), experiment);
  auto session = app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}});
  (*session)->run();
  csv.finish();
  window.resize(1280, 800);
  window.show();
  window.activateWindow();
  window.open_recording(file);
  ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
  ASSERT_TRUE(eventually([&] { return window.replay().is_loaded() && window.replay().latest()->t > 0.2; }));
  window.go();
  for (int k = 0; k < 2; ++k) QTest::keyClick(find<QWidget>("time_line"), Qt::Key_PageUp);  // past the kick at 18 s
  const app::TickRecord there = *window.replay().latest();
  ASSERT_GT(core::distance(there.robots[1].pose, there.robots[1].nominal.pose), 0.02);

  go_on_from_here();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  EXPECT_NEAR(record().t, there.t, 1e-9);
  expect_same_places(record(), there, 1e-7);
  EXPECT_TRUE(logged().contains(QStringLiteral("Repeated up to"))) << logged().toStdString();
}

TEST_F(Branch, OfARecordingIsNotOfTheFileThatWasOpenBefore) {
  const QTemporaryDir dir;
  const auto recorded =
      app::parse_experiment(app::paper_experiment().source, "recorded", {"arena.width=2.4", "duration=6"});
  ASSERT_TRUE(recorded) << recorded.error().front().message();
  const QString file = dir.filePath(QStringLiteral("run.csv"));
  app::CsvFile csv(file.toStdString(), *recorded);
  auto session = app::Session::open(*recorded, app::Session::Clock::virtual_, {false, {&csv}});
  (*session)->run();
  csv.finish();
  open_and_wait();
  window.set_experiment_file(dir.filePath(QStringLiteral("another.toml")));
  window.open_recording(file);
  ASSERT_TRUE(eventually([&] { return window.replay().is_loaded() && window.replay().latest()->t > 0.2; }));
  window.go();
  go_on_from_here();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  EXPECT_EQ(live().file().toStdString(), "") << "the kept run, and the editor, would take it for that";
  EXPECT_EQ(live().experiment().name, recorded->name);
  EXPECT_TRUE(window.windowTitle().startsWith(QString::fromStdString(live().experiment().name)));
  EXPECT_EQ(live().experiment().arena_width, 2.4);

  // Run anew it does not pause there.
  const auto pauses = [&] {
    const auto& actions = live().experiment().actions;
    return std::count_if(actions.begin(), actions.end(),
                         [](const app::OperatorAction& action) { return app::is<app::events::Pause>(action.event); });
  };
  EXPECT_EQ(pauses(), 1);
  window.new_run();
  EXPECT_EQ(pauses(), 0);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest(); }));
}

TEST_F(Branch, HasTheSameResultsAsTheRunAlsoOfWhatWasDoneBeforeItsStart) {
  open_and_wait();
  emit find<GainsPanel>("gains")->couple_wanted(0, 2, false);
  ASSERT_TRUE(eventually([&] { return !live().coupled(0, 2); }));
  window.go();
  ASSERT_TRUE(eventually([&] { return running() && record().t > 0.5; }));
  drag(robot(2), robot(2) + QPoint(20, 15));
  moved(2);
  const double moved_at = record().t;
  ASSERT_TRUE(eventually([&] { return record().t > moved_at + 0.5; }));
  window.go();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  const auto listed = [&] {
    QStringList lines;
    for (const RunResults::Kick& kick : find<ResultPanel>("results")->results()->kicks())
      lines << QStringLiteral("%1 %2").arg(kick.t, 0, 'f', 2).arg(kick.what);
    return lines.join(QLatin1Char('\n')).toStdString();
  };
  const std::string before = listed();
  EXPECT_NE(before, "");
  go_on_from_here();
  ASSERT_TRUE(eventually([&] { return paused(); }));
  EXPECT_EQ(listed(), before);
  EXPECT_FALSE(live().coupled(0, 2));
}

/// A run whose text is read again for so long that much can happen meanwhile.
class LongBranch : public Branch {
 protected:
  void start_and_pause() {
    const auto large = app::parse_experiment(timetables_of_64_robots(500).toStdString(), "large.toml");
    ASSERT_TRUE(large) << large.error().front().message();
    start(*large);
    window.go();
    ASSERT_TRUE(eventually([&] { return paused(); }));
  }
  bool is_preparing() { return window.findChild<BranchController*>()->is_busy(); }
  bool says_that_it_prepares() { return alert().contains(QStringLiteral("Preparing the run up to")); }
  void ask() { key(Qt::Key_B, nullptr, Qt::ControlModifier); }
  /// Whether the window handles an event while this holds. Frames would be no measure: on a busy display one takes
  /// longer than what is prepared.
  bool goes_on_while(const std::function<bool()>& holds) {
    bool handled = false, meanwhile = false;
    QMetaObject::invokeMethod(
        &window,
        [&] {
          handled = true;
          meanwhile = holds();
        },
        Qt::QueuedConnection);
    return eventually([&] { return handled; }) && meanwhile;
  }
};

TEST_F(LongBranch, IsPreparedWhileTheWindowGoesOn) {
  start_and_pause();
  const double t = record().t;
  QSignalSpy opened(&live(), &LiveRun::opened);
  ask();
  ASSERT_TRUE(is_preparing());
  EXPECT_TRUE(live().is_open() && !live().is_busy()) << "the run that is shown stays";
  EXPECT_TRUE(says_that_it_prepares()) << alert().toStdString();
  ask();
  find<QAction>("take_back")->trigger();
  find<QAction>("do_again")->trigger();
  EXPECT_TRUE(says_that_it_prepares()) << "asked again, nothing changes";
  arena().select(17);
  EXPECT_TRUE(goes_on_while([&] { return is_preparing(); }));
  ASSERT_TRUE(eventually([&] { return opened.size() == 1; }));
  ASSERT_TRUE(eventually([&] { return paused(); }));
  EXPECT_NEAR(record().t, t, 1e-9);
  EXPECT_FALSE(is_preparing()) << "it was asked for twice";
}

TEST_F(LongBranch, IsGivenUpByAStop) {
  start_and_pause();
  ask();
  ASSERT_TRUE(is_preparing());
  key(Qt::Key_Space);
  EXPECT_FALSE(is_preparing()) << "nothing starts by itself after a STOP";
  EXPECT_TRUE(eventually([&] { return stopped(); }));

  // Where nothing drives there is only this to stop.
  ask();
  ASSERT_TRUE(is_preparing());
  key(Qt::Key_Escape);
  EXPECT_FALSE(is_preparing());
  EXPECT_TRUE(alert().contains(QStringLiteral("not repeated"))) << alert().toStdString();
  EXPECT_TRUE(stopped());
}

TEST_F(LongBranch, IsGivenUpForAnotherRunAndWhereTheWindowCloses) {
  start_and_pause();
  ask();
  ASSERT_TRUE(is_preparing());
  QSignalSpy opened(&live(), &LiveRun::opened);
  window.open(app::paper_experiment(), false);
  EXPECT_FALSE(is_preparing());
  ASSERT_TRUE(eventually([&] { return opened.size() == 1 && live().latest(); }));
  EXPECT_EQ(live().experiment().robots.size(), 4U);

  start_and_pause();
  ask();
  ASSERT_TRUE(is_preparing());
  window.close();
  EXPECT_FALSE(is_preparing());
  EXPECT_TRUE(eventually([&] { return !window.isVisible(); }));
}

TEST_F(LongBranch, AChangeOfTheExperimentIsPreparedInTheSameWay) {
  const auto large = app::parse_experiment(timetables_of_64_robots(500).toStdString(), "large.toml");
  ASSERT_TRUE(large) << large.error().front().message();
  open_and_wait(*large);
  QSignalSpy opened(&live(), &LiveRun::opened);
  emit find<GainsPanel>("gains")->experiment_wanted(QStringLiteral("controller.coupling=bounded"));
  EXPECT_TRUE(live().is_open() && !live().is_busy()) << "the window waits for it";
  EXPECT_TRUE(goes_on_while([&] { return opened.isEmpty() && !live().is_busy(); }));
  ASSERT_TRUE(eventually([&] { return opened.size() == 1 && live().latest(); }));
  EXPECT_NE(live().experiment().controller.coupling, large->controller.coupling);

  // Started now, the run would have the settings that the operator has just changed.
  emit find<GainsPanel>("gains")->experiment_wanted(QStringLiteral("controller.coupling=paper"));
  window.go();
  EXPECT_TRUE(alert().contains(QStringLiteral("Not started: the changed experiment"))) << alert().toStdString();
  EXPECT_EQ(live().phase(), app::Phase::ready);
  ASSERT_TRUE(eventually([&] { return opened.size() == 2 && live().latest(); }));
  EXPECT_EQ(live().experiment().controller.coupling, large->controller.coupling);
}

TEST_F(Branch, NeedsARunAndSaysSo) {
  window.resize(1280, 800);
  window.show();
  window.activateWindow();
  window.open(app::paper_experiment(), false);
  ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
  ASSERT_TRUE(eventually([&] { return live().latest() != nullptr; }));
  key(Qt::Key_B, nullptr, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return alert().contains(QStringLiteral("no run yet")); })) << alert().toStdString();
  EXPECT_EQ(live().phase(), app::Phase::ready);
}

}  // namespace
}  // namespace skein::ui::test
