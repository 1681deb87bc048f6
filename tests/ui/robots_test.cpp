// The table of robots: what it says of each, and what can be done with one of them.
#include <sys/resource.h>

#include <QAbstractItemView>
#include <QAction>
#include <QHeaderView>
#include <QLabel>
#include <QProcess>
#include <QTableView>
#include <QToolButton>
#include <csignal>

#include "operator.h"
#include "tests/places.h"
#include "ui/base/dialogs.h"
#include "ui/robots/robots_model.h"

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
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit nothing{0, before.rlim_max};
  std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &nothing), 0);  // a marker cannot be written anywhere
  window.show();
  window.activateWindow();
  window.open(*experiment, false);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }))
      << live().failure().value_or(QString()).toStdString();
  EXPECT_TRUE(eventually([&] { return !log_line(QStringLiteral("NO GUARD")).isEmpty(); }));
  EXPECT_TRUE(eventually([&] { return find<QLabel>("alert")->text().contains(QStringLiteral("NO GUARD")); }));
  EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  window.close();
  EXPECT_TRUE(eventually([&] { return !window.isVisible(); }));
  robots.terminate();
  EXPECT_TRUE(robots.waitForFinished());
}

}  // namespace
}  // namespace skein::ui::test
