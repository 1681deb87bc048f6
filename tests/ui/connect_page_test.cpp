// The page on which robots are set up: found, paired, pinged, tested, saved; and that nobody has them meanwhile.
#include <QAbstractItemView>
#include <QAction>
#include <QApplication>
#include <QFile>
#include <QFrame>
#include <QLabel>
#include <QLineEdit>
#include <QTableView>
#include <atomic>
#include <chrono>

#include "comms/emulator/pty_emulator.h"
#include "operator.h"
#include "tests/comms/fake_bluez.h"
#include "tests/places.h"
#include "ui/connect/connect_page.h"
#include "ui/editor/experiment_editor.h"

namespace skein::ui::test {
namespace {

using Column = ConnectModel::Column;

/// An emulated robot at the end of a line like a real one's.
struct Lab {
  Lab()
      : robots(
            std::vector{core::MotorModel::epuck2},
            [this](std::size_t, const core::WheelSpeeds& told) {
              driven = driven || told.left != 0 || told.right != 0;
            },
            [] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }) {
  }
  bool stands() const { return robots.wheels(0).left == 0.0 && robots.wheels(0).right == 0.0; }
  std::atomic<bool> driven{false};
  comms::PtyEmulator robots;
};

class ConnectPageTest : public Operator {
 protected:
  static app::Experiment emulated() {
    return *app::parse_experiment(
        "rate = 10\n[camera]\nsource = \"synthetic\"\n[robot_defaults]\nlink = \"loopback\"\n"
        "[[robot]]\nname = \"anna\"\nstart = [-0.4, 0.2, 0.5]\n[[robot]]\nname = \"bert\"\nstart = [0.3, -0.2, 2.0]\n",
        "two.toml");
  }
  /// One robot on this line, before a camera that shows an empty floor.
  app::Experiment real() {
    QImage floor(1280, 960, QImage::Format_Grayscale8);
    floor.fill(128);
    for (int k = 0; k < 9; ++k) floor.save(dir.filePath(QStringLiteral("floor%1.png").arg(k)));
    app::Experiment experiment =
        *app::parse_experiment("[[robot]]\nname = \"anna\"\nlink = \"serial:" + lab.robots.device(0) +
                                   "\"\nmodel = \"epuck2\"\n"
                                   "[camera]\nsource = \"images:" +
                                   dir.path().toStdString() + "\"\ncalibration = \"overhead.toml\"\n",
                               "one.toml");
    experiment.directory = skein::test::in_source("resources/cameras");
    return experiment;
  }
  /// The same before no camera: what the page drives, while the window shows nothing of it.
  static app::Experiment without_camera(app::Experiment experiment) {
    experiment.camera = {};
    return experiment;
  }
  ConnectPage* open_page() {
    find<QAction>("connect_robots_page")->trigger();
    auto* page = find<ConnectPage>("connect_page");
    EXPECT_TRUE(bring_to_front(*page));
    return page;
  }
  QAbstractItemModel* table() { return find<QAbstractItemView>("connect_robots")->model(); }
  QString cell(int row, Column column) { return table()->index(row, column).data().toString(); }
  QString status() { return find<QLabel>("connect_status")->text(); }
  void press(const char* name) { QTest::mouseClick(find<QPushButton>(name), Qt::LeftButton); }
  bool rests() { return find<QPushButton>("connect_ping")->isEnabled(); }
  /// As somebody without a mouse does.
  void press_by_key(const char* name) {
    auto* button = find<QPushButton>(name);
    for (int k = 0; k < 20 && !button->hasFocus(); ++k) key(Qt::Key_Tab, button);
    ASSERT_TRUE(button->hasFocus()) << name;
    key(Qt::Key_Return, button);
  }
  QTemporaryDir dir;
  Lab lab;  // until the window is closed: a robot that is gone would have a guard for ever
};

TEST_F(ConnectPageTest, EmulatedRobotsPassAllOfItByTheKeyboard) {
  open_and_wait(emulated());
  open_page();
  ASSERT_EQ(table()->rowCount(), 2);
  EXPECT_EQ(cell(1, Column::robot), QStringLiteral("robot 2 (bert)\nemulated"));
  EXPECT_EQ(cell(0, Column::verdict), QStringLiteral("ping it"));
  EXPECT_EQ(cell(0, Column::paired), QStringLiteral("–"));
  EXPECT_FALSE(table()->index(0, Column::paired).data(Qt::ToolTipRole).toString().isEmpty()) << "nobody knows why";
  for (const Column column : {Column::answers, Column::wheels, Column::tag})
    EXPECT_EQ(cell(0, column), QStringLiteral("not tested")) << column;
  EXPECT_EQ(cell(0, Column::battery), QStringLiteral("not known"));

  press_by_key("connect_ping");
  EXPECT_TRUE(find<QPushButton>("connect_stop")->hasFocus()) << "the keyboard is nowhere";
  ASSERT_TRUE(eventually([&] { return rests(); }));
  EXPECT_EQ(status().toStdString(), "2 of 2 robots answer");
  EXPECT_TRUE(find<QTableView>("connect_robots")->hasFocus()) << "the keyboard is nowhere";
  for (int row = 0; row < 2; ++row) {
    EXPECT_TRUE(cell(row, Column::answers).endsWith(QStringLiteral("ms"))) << cell(row, Column::answers).toStdString();
    EXPECT_TRUE(cell(row, Column::battery).endsWith(QStringLiteral("V"))) << cell(row, Column::battery).toStdString();
    EXPECT_EQ(cell(row, Column::firmware).toStdString(), "2.0");
    EXPECT_EQ(cell(row, Column::verdict).toStdString(), "test its wheels and its tag");
  }

  press_by_key("connect_test");
  EXPECT_TRUE(find<QFrame>("connect_question")->isVisible());
  EXPECT_TRUE(find<QLabel>("connect_question_text")->text().contains(QStringLiteral("Clear 10 cm")));
  EXPECT_TRUE(find<QPushButton>("connect_not_now")->hasFocus()) << "Return twice would drive";
  key(Qt::Key_Return, find("connect_not_now"));
  EXPECT_FALSE(find<QFrame>("connect_question")->isVisible());
  EXPECT_TRUE(rests()) << "robots drive all the same";
  press_by_key("connect_test");
  press_by_key("connect_drive");
  ASSERT_TRUE(eventually([&] { return rests(); }));
  EXPECT_EQ(status().toStdString(), "2 of 2 robots pass their test");
  for (int row = 0; row < 2; ++row) {
    EXPECT_EQ(cell(row, Column::wheels).toStdString(), "good");
    EXPECT_EQ(cell(row, Column::tag).toInt(), row + 1);
    EXPECT_EQ(cell(row, Column::verdict).toStdString(), "ready");
  }
  EXPECT_TRUE(find<QLabel>("connect_details")->text().contains(QStringLiteral("wheel_diameter")));
  EXPECT_TRUE(logged().contains(QStringLiteral("robot 2 (bert) passes its test"))) << logged().toStdString();
  EXPECT_TRUE(live().is_open()) << "nothing real was in it: the experiment need not let go";
}

TEST_F(ConnectPageTest, SimulatedRobotsAreReadyAndSayWhyNothingIsTested) {
  open_and_wait(app::paper_experiment());
  open_page();
  EXPECT_EQ(cell(3, Column::verdict).toStdString(), "ready: it is simulated");
  EXPECT_EQ(cell(3, Column::answers), QStringLiteral("–"));
  EXPECT_TRUE(
      table()->index(3, Column::answers).data(Qt::ToolTipRole).toString().contains(QStringLiteral("simulated")));
  press("connect_ping");
  EXPECT_TRUE(status().contains(QStringLiteral("simulated"))) << status().toStdString();
  press("connect_save");
  EXPECT_TRUE(status().contains(QStringLiteral("Not saved"))) << status().toStdString();
  press("connect_add");
  EXPECT_TRUE(status().contains(QStringLiteral("already"))) << status().toStdString();
  find<QAbstractItemView>("connect_robots")->clearSelection();
  press("connect_test");
  EXPECT_TRUE(status().contains(QStringLiteral("Choose robots"))) << status().toStdString();
  EXPECT_FALSE(find<QFrame>("connect_question")->isVisible());
}

TEST_F(ConnectPageTest, TheExperimentLetsGoOfItsRobotsAndHasThemAgainWhenThePageIsClosed) {
  open_and_wait(real());
  ConnectPage* page = open_page();
  press("connect_ping");
  EXPECT_TRUE(status().contains(QStringLiteral("lets go"))) << status().toStdString();
  ASSERT_TRUE(eventually([&] { return rests(); })) << status().toStdString();
  EXPECT_FALSE(live().is_open()) << "two masters of one robot";
  EXPECT_EQ(status().toStdString(), "1 of 1 robots answer");
  EXPECT_FALSE(lab.driven) << "a ping drives nobody";
  delete page;
  EXPECT_TRUE(eventually([&] { return live().is_open(); })) << "it is not opened again";
}

TEST_F(ConnectPageTest, ANewRunWaitsUntilThePageHasLetGo) {
  open_and_wait(real());
  open_page();
  press("connect_ping");
  ASSERT_TRUE(eventually([&] { return !live().is_busy() && !live().is_open(); }));
  ASSERT_FALSE(rests());
  window.new_run();
  EXPECT_FALSE(live().is_busy()) << "opened while the page has the robot";
  ASSERT_TRUE(eventually([&] { return live().is_open(); }));
  EXPECT_TRUE(rests());
  EXPECT_TRUE(eventually([&] { return !live().robots().empty() && live().robots()[0].link == app::LinkState::up; }));
}

/// STOP by the key, by the window's button, and by the page's own.
class ConnectStop : public ConnectPageTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(ConnectStop, StandsTheRobotThatItsTestDrives) {
  window.resize(1280, 800);
  window.show();
  window.activateWindow();
  ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
  window.open(without_camera(real()), false);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  ConnectPage* page = open_page();
  press("connect_test");
  press("connect_drive");
  ASSERT_TRUE(eventually([&] { return lab.driven || (rests() && !live().is_busy()); }));
  ASSERT_TRUE(lab.driven) << status().toStdString();
  const std::string way = GetParam();
  if (way == "space" || way == "escape")
    key(way == "space" ? Qt::Key_Space : Qt::Key_Escape, page);
  else if (way == "close")
    delete page;
  else
    press(way.c_str());
  EXPECT_TRUE(eventually([&] { return lab.stands(); }));
  if (way == "close") {
    EXPECT_TRUE(eventually([&] { return live().is_open(); })) << "once the robot stands";
    EXPECT_TRUE(lab.stands());
    return;
  }
  EXPECT_TRUE(page->isVisible()) << "the key did more than stop";
  ASSERT_TRUE(eventually([&] { return rests(); }));
  EXPECT_TRUE(lab.stands());
  EXPECT_TRUE(status().contains(QStringLiteral("Stopped"))) << status().toStdString();
  EXPECT_TRUE(cell(0, Column::verdict).contains(QStringLiteral("test it again")))
      << cell(0, Column::verdict).toStdString();
}

INSTANTIATE_TEST_SUITE_P(By, ConnectStop, ::testing::Values("space", "escape", "stop", "connect_stop", "close"),
                         [](const auto& way) { return std::string(way.param); });

TEST_F(ConnectPageTest, TheWindowIsClosedWhenTheRobotOfATestStands) {
  open_and_wait(without_camera(real()));
  open_page();
  press("connect_test");
  press("connect_drive");
  ASSERT_TRUE(eventually([&] { return lab.driven.load(); })) << status().toStdString();
  window.close();
  ASSERT_TRUE(eventually([&] { return !window.isVisible(); }));
  EXPECT_TRUE(lab.stands());
}

TEST_F(ConnectPageTest, RefusesWhileARunIsUnderWayAndEndsWhenOneStarts) {
  open_and_wait(emulated());
  open_page();
  press("connect_ping");
  ASSERT_FALSE(rests());
  ASSERT_TRUE(eventually([&] { return const_cast<LiveRun&>(live()).start().has_value(); }));
  ASSERT_TRUE(eventually([&] { return rests(); }));
  ASSERT_TRUE(eventually([&] { return running(); }));
  EXPECT_TRUE(status().contains(QStringLiteral("Stopped"))) << status().toStdString();
  press("connect_ping");
  EXPECT_TRUE(status().contains(QStringLiteral("stop it first"))) << status().toStdString();
  EXPECT_TRUE(rests());
  EXPECT_TRUE(running());
}

TEST_F(ConnectPageTest, SaysWhyThereIsNoBluetooth) {
  const EnvironmentVariable bus("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere/bus");
  open_and_wait(app::paper_experiment());
  open_page();
  press("connect_scan");
  ASSERT_TRUE(eventually([&] { return rests(); }));
  EXPECT_TRUE(status().contains(QStringLiteral("bus"))) << status().toStdString();
  find<QLineEdit>("connect_adapter")->setText(QStringLiteral("wlan0"));
  press("connect_scan");
  ASSERT_TRUE(eventually([&] { return rests(); }));
  EXPECT_TRUE(status().contains(QStringLiteral("wlan0")) && status().contains(QStringLiteral("allowed")))
      << status().toStdString();
}

TEST_F(ConnectPageTest, FindsPairsAddsAndSavesARobot) {
  const skein::test::PrivateBus bus;
  if (!bus.running()) GTEST_SKIP() << "there is no dbus-daemon";
  const skein::test::FakeBluez bluez(bus, {{}},
                                     {{.name = "e-puck_1234", .address = "10:00:E8:AA:BB:01", .pin = "1234"}});
  open_and_wait(app::paper_experiment());
  open_page();
  press("connect_scan");
  ASSERT_TRUE(eventually([&] { return bluez.discoveries() > 0; })) << status().toStdString();
  press("connect_stop");  // the fake daemon hears everybody at once
  ASSERT_TRUE(eventually([&] { return rests(); }));
  ASSERT_EQ(table()->rowCount(), 5);
  EXPECT_EQ(cell(4, Column::robot).toStdString(), "e-puck_1234\nrfcomm:10:00:E8:AA:BB:01/1");
  EXPECT_EQ(cell(4, Column::paired).toStdString(), "no");
  EXPECT_EQ(cell(4, Column::verdict).toStdString(), "pair it");
  find<QTableView>("connect_robots")->selectRow(4);
  press("connect_pair");
  ASSERT_TRUE(eventually([&] { return rests(); }));
  EXPECT_EQ(status().toStdString(), "1 of 1 robots are paired");
  EXPECT_EQ(cell(4, Column::paired).toStdString(), "yes");
  EXPECT_EQ(cell(4, Column::verdict).toStdString(), "ping it");

  const EnvironmentVariable config_home("XDG_CONFIG_HOME", dir.path().toUtf8());
  press("connect_save");
  EXPECT_TRUE(status().contains(QStringLiteral("robots.toml"))) << status().toStdString();
  QFile file(dir.filePath(QStringLiteral("skein/robots.toml")));
  ASSERT_TRUE(file.open(QIODevice::ReadOnly));
  EXPECT_TRUE(file.readAll().contains("e-puck_1234"));

  press("connect_add");
  auto* editor = find<ExperimentEditor>("experiment_editor");
  EXPECT_TRUE(editor->has_changes());
  EXPECT_TRUE(editor->text().contains(QStringLiteral("link = \"rfcomm:10:00:E8:AA:BB:01/1\"")));
  delete editor;
}

class ConnectLook : public ConnectPageTest, public ::testing::WithParamInterface<Theme> {};

TEST_P(ConnectLook, CutsNothingOffAt800x600) {
  window.set_theme(GetParam());
  open_and_wait(emulated());
  ConnectPage* page = open_page();
  page->resize(800, 600);
  press("connect_ping");
  ASSERT_TRUE(eventually([&] { return rests(); }));
  press("connect_test");  // with the question
  ASSERT_TRUE(eventually([&] { return page->size() == QSize(800, 600); })) << page->width() << " x " << page->height();
  lay_out();
  QCoreApplication::sendPostedEvents(nullptr, QEvent::LayoutRequest);
  for (QWidget* widget : page->findChildren<QWidget*>()) {
    if (!widget->isVisible() || !(qobject_cast<QPushButton*>(widget) || qobject_cast<QLabel*>(widget))) continue;
    const QSize needed = widget->minimumSizeHint();
    EXPECT_GE(widget->width(), needed.width()) << widget->objectName().toStdString();
    EXPECT_GE(widget->height(), needed.height()) << widget->objectName().toStdString();
    EXPECT_TRUE(page->rect().contains(QRect(widget->mapTo(page, QPoint()), widget->size())))
        << widget->objectName().toStdString();
    if (auto* label = qobject_cast<QLabel*>(widget); label && label->wordWrap()) {
      EXPECT_GE(label->height(), label->heightForWidth(label->width())) << label->objectName().toStdString();
    }
  }
  auto* view = find<QTableView>("connect_robots");
  for (int row = 0; row < table()->rowCount(); ++row)
    for (int column = 0; column < table()->columnCount(); ++column) {
      const QModelIndex index = table()->index(row, column);
      const QRect room = view->visualRect(index).adjusted(3, 0, -3, 0);
      const QRect text =
          view->fontMetrics().boundingRect(QRect(0, 0, room.width(), 1000), Qt::TextWordWrap, index.data().toString());
      EXPECT_LE(text.width(), room.width()) << index.data().toString().toStdString();
      EXPECT_LE(text.height(), room.height()) << index.data().toString().toStdString();
      EXPECT_TRUE(view->viewport()->rect().contains(view->visualRect(index))) << row << ", " << column;
    }
}

INSTANTIATE_TEST_SUITE_P(In, ConnectLook, ::testing::Values(Theme::light, Theme::dark),
                         [](const auto& theme) { return theme.param == Theme::dark ? "Dark" : "Light"; });

}  // namespace
}  // namespace skein::ui::test
