// A recorded run through the same widgets, and a second run to compare with.
#include <fmt/format.h>

#include <QAbstractItemView>
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QHelpEvent>
#include <QTableView>
#include <QToolButton>
#include <QToolTip>
#include <fstream>
#include <set>

#include "app/record/csv_file.h"
#include "operator.h"
#include "tests/files.h"
#include "ui/base/dialogs.h"
#include "ui/base/why.h"
#include "ui/gains/gains_panel.h"
#include "ui/plots/plot_view.h"
#include "ui/plots/plots_panel.h"
#include "ui/robots/robots_model.h"
#include "ui/status/run_bar.h"

namespace skein::ui::test {
namespace {

class Replay : public Operator {
 protected:
  /// The paper's experiment, recorded on the virtual clock.
  QString recorded(double k_xx = 0.008) {
    app::Experiment experiment = *app::parse_experiment(app::paper_experiment().source, "platoon.toml",
                                                        {"controller.gains.k_xx=" + fmt::format("{}", k_xx)});
    const QString file = dir.filePath(QStringLiteral("run-%1.csv").arg(k_xx));
    app::CsvFile csv(file.toStdString(), experiment);
    auto session = app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}});
    (*session)->run();
    csv.finish();
    return file;
  }
  /// A file of this name with this text.
  QString written(const char* name, const QByteArray& text) {
    const QString file = dir.filePath(QLatin1String(name));
    QFile out(file);
    EXPECT_TRUE(out.open(QIODevice::WriteOnly));
    EXPECT_EQ(out.write(text), text.size());
    return file;
  }
  void replay(const QString& file) {
    window.resize(1280, 800);
    window.show();
    window.activateWindow();
    window.open_recording(file);
    ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
    ASSERT_TRUE(eventually([&] { return window.replay().is_loaded(); }));
  }
  TimeLine& time_line() { return *find<TimeLine>("time_line"); }
  QString alert() { return find<QLabel>("alert")->text(); }
  QTemporaryDir dir;
};

TEST_F(Replay, PlaysThroughTheSameWidgets) {
  replay(recorded());
  EXPECT_TRUE(eventually([&] { return window.replay().t() > 0.3; })) << "it does not play";
  EXPECT_TRUE(alert().contains(QStringLiteral("bit for bit"))) << alert().toStdString();
  EXPECT_GE(find<QAbstractItemView>("event_log")->model()->rowCount(), 4) << "start and three kicks";
  EXPECT_EQ(find<PlotsPanel>("plots")->history().size(), 2100u);
  EXPECT_EQ(find<QAbstractItemView>("robots")->model()->rowCount(), 4);
  auto* go = find<QPushButton>("go");
  QTest::mouseClick(go, Qt::LeftButton);
  EXPECT_FALSE(window.replay().is_playing());
  const double t = window.replay().t();
  QTest::mouseClick(find<QPushButton>("step"), Qt::LeftButton);
  EXPECT_NEAR(window.replay().t(), t + 0.04, 0.0401);
  EXPECT_EQ(go->text(), QStringLiteral("Play"));
}

TEST_F(Replay, GoesWhereTheScrubberIsPut) {
  replay(recorded());
  window.go();
  TimeLine& line = time_line();
  for (const double share : {0.5, 0.22, 0.9}) {
    QTest::mouseClick(&line, Qt::LeftButton, {},
                      {10 + static_cast<int>(share * (line.width() - 20)), line.height() / 2});
    EXPECT_NEAR(window.replay().t(), share * 84.0, 1.5 * 84.0 / (line.width() - 20)) << "a pixel of it";
    const app::TickRecord& row = (*window.replay().latest());
    EXPECT_NEAR(row.t, window.replay().t(), 0.0401);
    ASSERT_TRUE(arena().scene().record.has_value());
    EXPECT_EQ(arena().scene().record->t, row.t);
    EXPECT_EQ(arena().scene().pose(0)->x, row.robots[0].truth.x);
  }
  line.setFocus();
  const double t = window.replay().t();
  key(Qt::Key_Left);
  EXPECT_NEAR(window.replay().t(), t - 1.0, 0.05);
  QTest::keyClick(&line, Qt::Key_Home);
  QTest::keyClick(&line, Qt::Key_Right, Qt::ControlModifier);  // to the next event
  EXPECT_FALSE((*window.replay().latest()).events.empty());
}

TEST_F(Replay, HasATimeLineOnWhichASecondIsSeen) {
  replay(recorded());
  for (const int width : {1024, 1100, 1280, 1366, 1920}) {
    window.resize(width, 768);
    ASSERT_TRUE(eventually([&] { return window.width() == width; }));
    EXPECT_TRUE(eventually([&] { return time_line().width() >= 320; })) << time_line().width() << " px at " << width;
  }
}

TEST_F(Replay, IsScrubbedInTheSmallestWindow) {
  replay(recorded());
  window.go();
  ASSERT_FALSE(window.replay().is_playing());
  const QSize smallest(784, 552);  // what a window manager leaves of 800x600
  window.resize(smallest);
  ASSERT_TRUE(eventually([&] { return window.size() == smallest; }));
  ASSERT_TRUE(eventually([&] { return time_line().isVisible(); })) << "there is nothing to scrub with";
  EXPECT_EQ(time_line().visibleRegion().boundingRect(), time_line().rect());
  find<QAction>("go_to_time")->trigger();
  ASSERT_TRUE(eventually([&] { return time_line().hasFocus(); }));
  key(Qt::Key_End);
  EXPECT_TRUE(eventually([&] { return window.replay().t() == window.replay().recording()->rows.back().t; }));
}

/// The tip that a resting mouse gets there.
void rest_mouse(QWidget* over, QPoint where) {
  QHelpEvent tip(QEvent::ToolTip, where, over->mapToGlobal(where));
  QApplication::sendEvent(over, &tip);
}

TEST_F(Replay, TipsFollowTheMomentThatIsShown) {
  replay(recorded());
  window.go();
  ASSERT_FALSE(window.replay().is_playing());
  emit time_line().time_wanted(18.2);  // shortly after the kick
  const auto why_now = [&] { return why(*window.replay().latest(), 1, window.replay().circumstances()); };
  auto* table = find<QTableView>("robots");
  QString before = why_now();
  rest_mouse(table->viewport(), table->visualRect(table->model()->index(1, RobotsModel::mode)).center());
  ASSERT_EQ(QToolTip::text(), before);
  const auto step = [&](int times) {  // a click would take the tip away
    while (times-- > 0) find<QAction>("step_action")->trigger();
  };
  step(5);
  ASSERT_NE(why_now(), before) << "nothing has changed that could be told";
  EXPECT_TRUE(eventually([&] { return QToolTip::text() == why_now(); })) << QToolTip::text().toStdString();

  before = why_now();
  rest_mouse(&arena(), robot(1));
  ASSERT_TRUE(QToolTip::text().contains(before)) << QToolTip::text().toStdString();
  step(3);
  ASSERT_NE(why_now(), before);
  EXPECT_TRUE(eventually([&] { return QToolTip::text().contains(why_now()); })) << QToolTip::text().toStdString();
  EXPECT_FALSE(QToolTip::text().contains(QStringLiteral("Drag"))) << "nothing can be dragged in a replay";
}

TEST_F(Replay, HasItsObstaclesWhereTheyStandAtEveryMoment) {
  const app::Experiment experiment =
      *app::parse_experiment(app::paper_experiment().source +
                                 "[[operator]]\nt = 5\ndoes = \"obstacle o1 x=0 y=0 radius=0.05\"\n"
                                 "[[operator]]\nt = 60\ndoes = \"obstacle o1 x=0 y=0 radius=0\"\n",
                             "obstacle.toml", {"perturb=[]", "duration=84"});
  const QString file = dir.filePath(QStringLiteral("obstacle.csv"));
  app::CsvFile csv(file.toStdString(), experiment);
  (*app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}}))->run();
  csv.finish();
  replay(file);
  window.go();
  for (const auto& [t, stands] : {std::pair{50.0, true}, {2.0, false}, {6.0, true}, {83.0, false}, {40.0, true}}) {
    emit time_line().time_wanted(t);
    EXPECT_EQ(arena().scene().obstacle_at(0.0, 0.0) == 0, stands) << "at " << t << " s";
  }
}

TEST_F(Replay, OfARunThatHasEndedATipSaysThatItIsOver) {
  app::Experiment brief = app::paper_experiment();
  brief.duration = 1.0;
  start(brief);
  auto* table = find<QTableView>("robots");
  table->setFocus();  // a tip goes when the focus does, and what is switched off at the end loses it
  rest_mouse(table->viewport(), table->visualRect(table->model()->index(1, RobotsModel::mode)).center());
  ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::finished; }));
  EXPECT_TRUE(eventually([&] { return QToolTip::text() == QStringLiteral("stands: the run is over"); }))
      << QToolTip::text().toStdString();
}

TEST_F(Replay, TurnsTheLiveControlsOffAndSaysWhy) {
  replay(recorded());
  auto* gains = find<GainsPanel>("gains");
  EXPECT_FALSE(find("spin_k_xx")->isEnabled());
  EXPECT_TRUE(gains->toolTip().contains(QStringLiteral("replay"))) << gains->toolTip().toStdString();
  EXPECT_FALSE(find<QPushButton>("record")->isEnabled());
  EXPECT_FALSE(live().is_open());
  auto* leave = find<QPushButton>("new_run");
  EXPECT_EQ(leave->text(), QStringLiteral("Leave replay"));
  QTest::mouseClick(leave, Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  EXPECT_FALSE(window.replay().is_loaded());
  EXPECT_TRUE(find("spin_k_xx")->isEnabled());
}

TEST_F(Replay, SaysWhereARunComesOutDifferently) {
  QByteArray text = QByteArray::fromStdString(skein::test::read_file(recorded().toStdString()));
  // Another gain than the one that was used.
  ASSERT_TRUE(text.contains("k_yy = 0.08"));
  replay(written("changed.csv", text.replace("k_yy = 0.08", "k_yy = 0.07")));
  EXPECT_TRUE(alert().contains(QStringLiteral("differ, first"))) << alert().toStdString();
  EXPECT_TRUE(alert().contains(QStringLiteral("has been changed"))) << alert().toStdString();
}

TEST_F(Replay, SaysWhatIsWrongWithAFile) {
  start();
  window.open_recording(written("broken.csv", "# skein 0.1.0\nt,tick,r1_x\n0,0,zebra\n"));
  ASSERT_TRUE(eventually([&] { return window.findChild<QWidget*>(QStringLiteral("problem_dialog")) != nullptr; }));
  EXPECT_TRUE(running()) << "what ran went on";
  delete find<QWidget>("problem_dialog");
}

TEST_F(Replay, SaysThatANewerProgramWroteWhatItCannotRead) {
  window.show();
  window.open_recording(written("newer.csv", "# skein 99.1.0\n#| warp = 9\nt,tick,r1_x\n0,0,0\n"));
  MessageDialog* problem = nullptr;
  ASSERT_TRUE(eventually([&] { return (problem = window.findChild<MessageDialog*>()) != nullptr; }));
  EXPECT_TRUE(problem->text().contains(QStringLiteral("warp"))) << problem->text().toStdString();
  EXPECT_TRUE(problem->text().contains(QStringLiteral("recorded by skein 99.1.0"))) << problem->text().toStdString();
}

TEST_F(Replay, ComparesWithASecondRun) {
  const QString one = recorded(0.008), two = recorded(0.004);
  replay(one);
  window.go();
  window.compare_with(two);
  ASSERT_TRUE(eventually([&] { return arena().scene().compared.size() == 1; }));
  QTest::mouseClick(&time_line(), Qt::LeftButton, {}, {time_line().width() / 4, time_line().height() / 2});
  const OtherRun& other = arena().scene().compared.front();
  ASSERT_EQ(other.trails.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_FALSE(other.trails[i].empty());
    const core::Pose& ghost = other.trails[i].back();
    const core::Pose here = *arena().scene().pose(i);
    EXPECT_LT(std::hypot(ghost.x - here.x, ghost.y - here.y), 0.2) << "another time";
  }
  find<QAction>("compare_end")->trigger();
  EXPECT_TRUE(arena().scene().compared.empty());
}

TEST_F(Replay, ComparesWithAnyNumberOfRunsWithoutColourAndAlignedAtAKick) {
  const auto kicked_at = [this](const char* name, double t) {
    const app::Experiment experiment = *app::parse_experiment(
        app::paper_experiment().source, "platoon.toml",
        {"duration=9", "perturb=[{ t = " + fmt::format("{}", t) + ", robot = 2, dx = 0.1, dy = 0.0 }]"});
    const QString file = dir.filePath(QLatin1String(name));
    app::CsvFile csv(file.toStdString(), experiment);
    (*app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}}))->run();
    csv.finish();
    return file;
  };
  replay(kicked_at("own.csv", 2.0));
  window.go();
  for (const QString& file : {kicked_at("three.csv", 3.0), kicked_at("four.csv", 4.0), kicked_at("five.csv", 5.0)})
    window.compare_with(file);
  const auto& compared = arena().scene().compared;
  ASSERT_TRUE(eventually([&] { return compared.size() == 3; })) << compared.size() << " of 3 runs are there";
  const auto* second = find<QToolButton>("compared_B");
  EXPECT_EQ(second->text(), QStringLiteral("B  four.csv"));

  // Every run has a line of its own in the plots, and this one's alone is unbroken.
  auto* plot = find<PlotView>("plot");
  std::set<Qt::PenStyle> styles;
  for (int k = 0; k < plot->graphCount(); ++k) styles.insert(plot->graph(k)->pen().style());
  EXPECT_EQ(styles, (std::set{Qt::SolidLine, Qt::DashLine, Qt::DotLine, Qt::DashDotLine}));

  // One second after its kick every run is where this one is then.
  auto* align = find<QComboBox>("compare_align");
  ASSERT_TRUE(eventually([&] { return align->count() == 2; })) << "the kick of this run cannot be chosen";
  emit find<TimeLine>("time_line")->time_wanted(3.0);
  const auto off = [&](std::size_t k) {
    const core::Pose &there = compared[k].trails[1].back(), here = *arena().scene().pose(1);
    const core::Pose nominal = app::make_reference(window.replay().experiment())->at(1, 3.0).pose;
    const double then = 3.0 + static_cast<double>(k) + 1.0;  // where it should be in the other run by then
    const core::Pose theirs = app::make_reference(window.replay().experiment())->at(1, then).pose;
    return std::hypot((there.x - theirs.x) - (here.x - nominal.x), (there.y - theirs.y) - (here.y - nominal.y));
  };
  align->setCurrentIndex(1);
  emit align->activated(1);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(off(k), 0.01) << "run " << k << " is not aligned";

  QTest::mouseClick(find<QToolButton>("compared_A"), Qt::LeftButton);
  ASSERT_EQ(compared.size(), 2u);
  EXPECT_EQ(compared[0].number, 1u) << "B keeps its letter and its line";
  find<QAction>("compare_end")->trigger();
  EXPECT_TRUE(compared.empty());
  EXPECT_FALSE(find("comparison_bar")->isVisible());
}

TEST_F(Replay, AlignsAKickWithThatAtTheSameTimeAlthoughAHandWasThereBefore) {
  const auto kicked = [this](const char* name, const std::vector<double>& times) {
    std::string kicks;
    for (const double t : times) kicks += "{ t = " + fmt::format("{}", t) + ", robot = 2, dx = 0.1, dy = 0.0 },";
    const app::Experiment experiment = *app::parse_experiment(app::paper_experiment().source, "platoon.toml",
                                                              {"duration=9", "perturb=[" + kicks + "]"});
    const QString file = dir.filePath(QLatin1String(name));
    app::CsvFile csv(file.toStdString(), experiment);
    (*app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}}))->run();
    csv.finish();
    return file;
  };
  replay(kicked("own.csv", {2.0, 5.0}));
  window.go();
  window.compare_with(kicked("left alone.csv", {5.0}));
  const auto& compared = arena().scene().compared;
  ASSERT_TRUE(eventually([&] { return compared.size() == 1; }));
  auto* align = find<QComboBox>("compare_align");
  ASSERT_TRUE(eventually([&] { return align->count() == 3; })) << "the kicks of this run cannot be chosen";
  emit find<TimeLine>("time_line")->time_wanted(5.5);
  const auto there = [&] { return compared[0].trails[1].back(); };
  const core::Pose unmoved = there();
  for (const int kick : {2, 1}) {
    align->setCurrentIndex(kick);
    emit align->activated(kick);
    EXPECT_EQ(there().x, unmoved.x) << "kick " << kick << ": it was kicked at the same time, or not at all";
    EXPECT_EQ(there().y, unmoved.y);
  }
}

TEST_F(Replay, ComparesALiveRunWithTheOneBefore) {
  start();
  window.set_speed(20.0);
  ASSERT_TRUE(eventually([&] { return record().t > 10.0; }));
  find<QAction>("compare_now")->trigger();
  ASSERT_EQ(arena().scene().compared.size(), 1u);
  window.new_run();
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  window.go();
  ASSERT_TRUE(eventually([&] { return running() && record().t > 5.0; }));
  ASSERT_EQ(arena().scene().compared.size(), 1u) << "it is gone with the run";
}

}  // namespace
}  // namespace skein::ui::test
