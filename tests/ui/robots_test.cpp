// The table of robots: what it says of each, and what can be done with one of them.
#include <QAbstractItemView>
#include <QAction>
#include <QHeaderView>
#include <QLabel>
#include <QMenu>
#include <QProcess>
#include <QTabWidget>
#include <QTableView>
#include <QToolButton>

#include "operator.h"
#include "tests/places.h"
#include "tests/small_disk.h"
#include "ui/base/dialogs.h"
#include "ui/plots/plot_view.h"
#include "ui/plots/plots_panel.h"
#include "ui/robots/robots_model.h"
#include "ui/run/run_history.h"
#include "ui/status/time_line.h"

namespace skein::ui::test {
namespace {

class Robots : public Operator {
 protected:
  void open_loopback() {
    const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
    ASSERT_TRUE(experiment.has_value());
    open_and_wait(*experiment);
  }
  QString cell(int robot, RobotsModel::Column column) {
    return find<QAbstractItemView>("robots")->model()->index(robot, column).data().toString();
  }
  void select(Qt::Key number) {
    arena().setFocus();
    ASSERT_TRUE(eventually([&] { return arena().hasFocus(); }));
    key(number);
  }
  /// Presses a button as somebody without a mouse does.
  void press(const char* name) {
    auto* button = find<QAbstractButton>(name);
    ASSERT_TRUE(eventually([&] { return button->isEnabled(); })) << button->toolTip().toStdString();
    button->setFocus();
    ASSERT_TRUE(eventually([&] { return button->hasFocus(); }));
    key(Qt::Key_Return);
  }
  QString log_line(const QString& words) {
    const auto* log = find<QAbstractItemView>("event_log")->model();
    for (int row = 0; row < log->rowCount(); ++row)
      if (QString line = log->index(row, 2).data(Qt::ToolTipRole).toString(); line.contains(words)) return line;
    return {};
  }
};

TEST_F(Robots, TheirModeIsWholeInATableThatIsTooNarrow) {
  open_loopback();
  auto* table = find<QTableView>("robots");
  const auto whole = [&] {
    int widest = 0;
    for (int robot = 0; robot < 4; ++robot)
      widest = std::max(widest, table->fontMetrics().horizontalAdvance(cell(robot, RobotsModel::mode)));
    return widest > 0 && table->columnWidth(RobotsModel::mode) > widest;
  };
  window.resize(1900, 1000);
  EXPECT_TRUE(eventually([&] { return whole(); }));
  window.resize(900, 620);
  EXPECT_TRUE(eventually([&] { return table->viewport()->width() < 500; })) << table->viewport()->width();
  EXPECT_TRUE(whole()) << table->columnWidth(RobotsModel::mode);
  EXPECT_GE(table->horizontalHeader()->length(), table->viewport()->width()) << "and nothing is left over";
}

TEST_F(Robots, SayHowTheyWereFoundAndWhoTheyAre) {
  open_loopback();
  EXPECT_TRUE(eventually([&] { return cell(0, RobotsModel::found) == QStringLiteral("tracked"); }));
  EXPECT_TRUE(eventually([&] { return cell(3, RobotsModel::firmware) == QStringLiteral("2.0"); }));
  EXPECT_TRUE(eventually([&] { return cell(1, RobotsModel::battery).endsWith(QStringLiteral("V")); }));
  EXPECT_FALSE(find<QAbstractItemView>("robots")->isHidden());
}

TEST_F(Robots, HaveTheirLinksInAReplayAsTheRecordingHasThem) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment.has_value());
  start(*experiment);
  ASSERT_TRUE(eventually([&] {
    const app::LinkRecord& link = record().robots[3].link;
    return std::isfinite(link.battery) && std::isfinite(link.round_trip);
  })) << "no robot has answered";
  const double late = record().t;
  ASSERT_TRUE(eventually([&] { return record().t > late; }));
  window.stop();  // while robots with links drive no file is opened
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  const QTemporaryDir dir;
  const QString file = dir.filePath(QStringLiteral("run.csv"));
  EXPECT_EQ(write_csv(live().history().rows(), live().experiment(), file), QString());
  window.open_recording(file);
  ASSERT_TRUE(eventually([&] { return window.replay().is_loaded(); }));
  if (window.replay().is_playing()) window.go();
  emit find<TimeLine>("time_line")->time_wanted(late);
  const app::LinkRecord& link = window.replay().latest()->robots[3].link;
  ASSERT_TRUE(std::isfinite(link.battery) && std::isfinite(link.round_trip)) << "the recording does not have them";
  EXPECT_EQ(cell(3, RobotsModel::link), QStringLiteral("up"));
  EXPECT_EQ(cell(3, RobotsModel::battery), QStringLiteral("%1 V").arg(link.battery, 0, 'f', 2));
  EXPECT_EQ(cell(3, RobotsModel::round_trip), QStringLiteral("%1 ms").arg(link.round_trip * 1000, 0, 'f', 1));
  auto* table = find<QTableView>("robots");
  EXPECT_FALSE(table->isColumnHidden(RobotsModel::battery) || table->isColumnHidden(RobotsModel::round_trip));
}

TEST_F(Robots, OneIsTestedFromTheKeyboardAndTheVerdictIsShown) {
  open_loopback();
  select(Qt::Key_2);
  press("test_robot");
  EXPECT_TRUE(eventually([&] { return find<QAbstractButton>("test_robot")->text() == QStringLiteral("Testing …"); }));
  window.go();
  EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("Not started")));
  ASSERT_TRUE(eventually([&] { return window.findChild<MessageDialog*>() != nullptr; })) << "no verdict came";
  EXPECT_EQ(live().phase(), app::Phase::ready);
  auto* verdict = find<MessageDialog>("problem_dialog");
  EXPECT_TRUE(verdict->text().contains(QStringLiteral("Robot 2 executes its commands")))
      << verdict->text().toStdString();
  EXPECT_TRUE(verdict->text().contains(QStringLiteral("Version")));
  delete verdict;
  EXPECT_FALSE(log_line(QStringLiteral("Robot 2 executes its commands")).isEmpty());
  EXPECT_TRUE(eventually([&] { return find<QAbstractButton>("test_robot")->isEnabled(); }));
}

TEST_F(Robots, AreAllSeenInTheUsualWindow) {
  open_loopback();
  window.resize(1280, 720);  // with more columns than have room: the table scrolls sideways
  auto* table = find<QTableView>("robots");
  const QModelIndex last = table->model()->index(3, 0);
  EXPECT_TRUE(eventually([&] {
    return window.height() == 720 && table->visualRect(last).bottom() < table->viewport()->height();
  })) << table->visualRect(last).bottom() - table->viewport()->height()
      << " px are cut off";
}

TEST_F(Robots, StopEndsATest) {
  open_loopback();
  select(Qt::Key_1);
  press("test_robot");
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  EXPECT_TRUE(eventually([&] { return !log_line(QStringLiteral("STOP was pressed")).isEmpty(); }));
  EXPECT_EQ(window.findChild<MessageDialog*>(), nullptr);
}

TEST_F(Robots, ThatAreSimulatedSayWhyTheyAreNotTested) {
  open_and_wait(app::paper_experiment());
  EXPECT_TRUE(eventually([&] { return cell(0, RobotsModel::found) == QStringLiteral("simulated"); }));
  select(Qt::Key_3);
  auto* test = find<QAbstractButton>("test_robot");
  EXPECT_FALSE(test->isEnabled());
  EXPECT_TRUE(test->toolTip().contains(QStringLiteral("simulated"))) << test->toolTip().toStdString();
  EXPECT_FALSE(find("connect_robot")->isVisible()) << "nobody to connect to";
  // The same by the table's menu, which the menu key opens.
  const QList<QAction*> actions = find("robots")->actions();
  ASSERT_EQ(actions.size(), 3);
  EXPECT_TRUE(actions[0]->text().contains(QLatin1Char('3')));
  actions[0]->trigger();
  EXPECT_TRUE(eventually([&] { return cell(2, RobotsModel::mode) == QStringLiteral("held"); }));
}

TEST_F(Robots, HaveCellsThatAreDraggedOntoPlots) {
  start();
  auto& plots = *find<PlotsPanel>("plots");
  plots.show_plots({QStringLiteral("e_x"), QStringLiteral("V")});
  ASSERT_TRUE(eventually([&] { return plots.view().axisRectCount() == 2 && plots.view().axisRect(1)->height() > 50; }));
  auto* table = find<QTableView>("robots");
  QWidget* cells = table->viewport();
  const auto centre = [&](RobotsModel::Column column) {
    return table->visualRect(table->model()->index(1, column)).center();
  };
  const auto press_and_move = [&](RobotsModel::Column column, const QPoint& to) {
    const QPoint from = centre(column);
    QTest::mousePress(cells, Qt::LeftButton, {}, from);
    for (int k = 1; k <= 4; ++k) QTest::mouseMove(cells, from + (to - from) * k / 4);
  };
  const auto drag_to = [&](RobotsModel::Column column, const QPoint& on_screen) {
    const QPoint to = cells->mapFromGlobal(on_screen);
    press_and_move(column, to);
    QTest::mouseRelease(cells, Qt::LeftButton, {}, to);
  };
  const QPoint upper = plots.view().mapToGlobal(plots.view().axisRect(0)->rect().center());
  drag_to(RobotsModel::mode, upper);  // words
  EXPECT_EQ(plots.shown(), (QStringList{QStringLiteral("e_x"), QStringLiteral("V")}));
  drag_to(RobotsModel::tag_age, upper);
  EXPECT_EQ(plots.shown(), (QStringList{QStringLiteral("e_x+pose_age"), QStringLiteral("V")}));
  EXPECT_EQ(table->currentIndex().row(), 1) << "and the robot is selected";
  const auto row = std::find_if(plots.rows().begin(), plots.rows().end(),
                                [](const PlotRow& r) { return r.name == QStringLiteral("pose_age"); });
  ASSERT_NE(row, plots.rows().end());
  EXPECT_NEAR(plots.history().value(row->first + 1, record().t), 1000 * record().robots[1].pose_age, 1.0);

  // Beside the plots: a plot of its own. Both wheels go there.
  drag_to(RobotsModel::wheels, find("plot_span")->mapToGlobal(QPoint(3, 3)));
  EXPECT_TRUE(plots.shown().contains(QStringLiteral("wheel_left+wheel_right")))
      << plots.shown().join(' ').toStdString();

  // STOP is not lost on the way.
  const QStringList before = plots.shown();
  press_and_move(RobotsModel::tag_age, cells->mapFromGlobal(upper));
  key(Qt::Key_Space);
  EXPECT_TRUE(eventually([&] { return stopped(); }));
  QTest::mouseRelease(cells, Qt::LeftButton, {}, centre(RobotsModel::tag_age));
  EXPECT_EQ(plots.shown(), before) << "dropped where it came from";
  plots.show_plots({});
}

TEST_F(Robots, AndPairsHaveCellsThatArePlottedByTheKeyboard) {
  start();
  auto& plots = *find<PlotsPanel>("plots");
  plots.show_plots({QStringLiteral("e_x"), QStringLiteral("v")});
  find("plots_dock")->hide();
  const auto menu_of = [&](QAbstractItemView* table, int column) -> QMenu* {
    table->setFocus();
    if (!eventually([&] { return table->hasFocus(); })) return nullptr;
    table->setCurrentIndex(table->model()->index(0, column));
    key(Qt::Key_F10, nullptr, Qt::ShiftModifier);
    QMenu* menu = nullptr;
    static_cast<void>(eventually([&] {
      menu = table->findChild<QMenu*>(QStringLiteral("cell_menu"));
      return menu && menu->isVisible();
    }));
    return menu;
  };
  const auto choose = [&](QMenu* menu, const QString& beginning) {
    ASSERT_NE(menu, nullptr);
    auto* plot = menu->findChild<QMenu*>(QStringLiteral("plot_cell"));
    ASSERT_NE(plot, nullptr);
    QAction* found = nullptr;
    for (QAction* action : plot->actions())
      if (action->text().startsWith(beginning)) found = action;
    ASSERT_NE(found, nullptr) << beginning.toStdString();
    found->trigger();
    menu->close();
    EXPECT_TRUE(eventually([&] { return window.findChild<QMenu*>(QStringLiteral("cell_menu")) == nullptr; }));
  };
  auto* robots = find<QAbstractItemView>("robots");
  choose(menu_of(robots, RobotsModel::tag_age), QStringLiteral("In the plot of e_x"));
  EXPECT_EQ(plots.shown(), (QStringList{QStringLiteral("e_x+pose_age"), QStringLiteral("v")}));
  EXPECT_FALSE(find("plots_dock")->isHidden()) << "what is plotted is seen";
  choose(menu_of(robots, RobotsModel::tag_age), QStringLiteral("In the plot of e_x"));
  EXPECT_EQ(plots.shown(), (QStringList{QStringLiteral("e_x"), QStringLiteral("v")})) << "and no longer";

  QMenu* words = menu_of(robots, RobotsModel::mode);
  ASSERT_NE(words, nullptr);
  EXPECT_FALSE(words->findChild<QMenu*>(QStringLiteral("plot_cell"))->menuAction()->isEnabled());
  EXPECT_EQ(words->actions().first()->text(), robots->actions().first()->text()) << "what else can be done";
  words->close();

  auto* tabs = find<QTabWidget>("gain_tabs");
  for (int k = 0; k < tabs->count(); ++k)
    if (tabs->widget(k)->findChild<QWidget*>(QStringLiteral("pair_table"))) tabs->setCurrentIndex(k);
  choose(menu_of(find<QAbstractItemView>("pair_table"), 1), QStringLiteral("In a plot of its &own"));
  EXPECT_TRUE(plots.shown().contains(QStringLiteral("k_xx"))) << plots.shown().join(' ').toStdString();
  plots.show_plots({});
}

TEST_F(Robots, WithoutAGuardAreSaidToHaveNone) {
  const QTemporaryDir dir;
  QProcess robots;
  robots.start(QString::fromStdString(skein::test::program()),
               {QStringLiteral("emulate"), QStringLiteral("--robots"), QStringLiteral("1"),
                QStringLiteral("--directory"), dir.path()});
  const QString device = dir.filePath(QStringLiteral("robot1"));
  ASSERT_TRUE(eventually([&] { return QFile::exists(device); }));
  QImage floor(1280, 960, QImage::Format_Grayscale8);
  floor.fill(128);
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(floor.save(dir.filePath(QStringLiteral("floor%1.png").arg(k, 3))));
  auto experiment = app::parse_experiment("[[robot]]\ntag = 1\nlink = \"serial:" + device.toStdString() +
                                              "\"\n[camera]\nsource = \"images:" + dir.path().toStdString() +
                                              "\"\ncalibration = \"overhead.toml\"\n",
                                          "one.toml");
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  experiment->directory = skein::test::in_source("resources/cameras");
  window.show();
  window.activateWindow();
  bool open = false, logged = false, alerted = false;
  {
    const skein::test::SmallDisk full(0);  // a marker cannot be written anywhere
    window.open(*experiment, false);
    open = eventually([&] { return live().is_open() && live().latest() != nullptr; });
    logged = open && eventually([&] { return !log_line(QStringLiteral("NO GUARD")).isEmpty(); });
    alerted = logged && eventually([&] { return find<QLabel>("alert")->text().contains(QStringLiteral("NO GUARD")); });
  }
  EXPECT_TRUE(open) << live().failure().value_or(QString()).toStdString();
  EXPECT_TRUE(logged);
  EXPECT_TRUE(alerted);
  window.close();
  EXPECT_TRUE(eventually([&] { return !window.isVisible(); }));
  robots.terminate();
  EXPECT_TRUE(robots.waitForFinished());
}

}  // namespace
}  // namespace skein::ui::test
