// Every task of the user guide by the keyboard alone: no test of this file moves a mouse.
#include <QAbstractItemView>
#include <QAbstractSpinBox>
#include <QAction>
#include <QApplication>
#include <QClipboard>
#include <QComboBox>
#include <QDir>
#include <QDockWidget>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QImage>
#include <QLabel>
#include <QLineEdit>
#include <QListView>
#include <QMenu>
#include <QMessageBox>
#include <QPlainTextEdit>
#include <QPointer>
#include <QSlider>
#include <QTabBar>
#include <QTabWidget>
#include <QTimer>
#include <QToolTip>
#include <QWindow>
#include <map>
#include <set>

#include "app/record/csv_file.h"
#include "operator.h"
#include "tests/places.h"
#include "ui/base/settings.h"
#include "ui/editor/experiment_editor.h"
#include "ui/plots/plot_layouts.h"
#include "ui/plots/plots_panel.h"
#include "ui/plots/xy_plot.h"

namespace skein::ui::test {
namespace {

class Keyboard : public Operator {
 protected:
  /// A key as it comes from the system: to the menu that is open, else to the window in front.
  void press(Qt::Key key, Qt::KeyboardModifiers modifiers = Qt::NoModifier, int times = 1) {
    while (times-- > 0) QTest::keyClick(in_front(), key, modifiers);
  }
  void type(const QString& text) {
    for (const QChar c : text) QTest::keyClick(in_front(), c.toLatin1());
  }
  QWindow* in_front() {
    if (QWidget* popup = QApplication::activePopupWidget()) return popup->windowHandle();
    QWindow* front = QGuiApplication::focusWindow();
    return front ? front : window.windowHandle();
  }
  /// A dialog is gone, and the window below it is in front again: by the window manager, which is not there.
  void expect_in_front(QWidget& below) {
    ASSERT_TRUE(eventually([&] {
      const QWidgetList all = QApplication::topLevelWidgets();
      return std::none_of(all.begin(), all.end(), [&](const QWidget* other) {
        return other->isVisible() && other != &window && other != &below && other->windowType() == Qt::Dialog;
      });
    })) << "a dialog is still there";
    ASSERT_TRUE(bring_to_front(below));
  }
  /// By Ctrl+W. Without a window manager the window may come to the front once more after the dialog did.
  void close(const QPointer<QDialog>& dialog) {
    ASSERT_TRUE(eventually([&] {
      if (!dialog || !dialog->isVisible()) return true;
      dialog->activateWindow();
      if (dialog->isActiveWindow()) press(Qt::Key_W, Qt::ControlModifier);
      return !dialog || !dialog->isVisible();
    }));
  }
  static bool has_focus(const QString& name) {
    const QWidget* focus = QApplication::focusWidget();
    return focus &&
           (focus->objectName() == name || (focus->parentWidget() && focus->parentWidget()->objectName() == name));
  }
  void tab_to(const char* name) {
    for (int k = 0; k < 150 && !has_focus(QLatin1String(name)); ++k) press(Qt::Key_Tab);
    ASSERT_TRUE(has_focus(QLatin1String(name))) << "Tab does not get to " << name;
  }
  /// What is done while a menu or dialog is open that the next key opens and waits for.
  static void then(const std::function<void()>& keys) { QTimer::singleShot(50, qApp, keys); }
  void show() {
    window.resize(1280, 800);
    window.show();
    window.activateWindow();
    ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
  }
  /// The dialog that a key has opened, with the focus, which a window manager would give it.
  template <typename Dialog>
  Dialog* comes_up(QWidget* of, const char* name) {
    Dialog* dialog = nullptr;
    eventually([&] {
      dialog = of->findChild<Dialog*>(QLatin1String(name));
      return dialog && dialog->isVisible();
    });
    if (!dialog) return nullptr;
    return bring_to_front(*dialog) ? dialog : nullptr;
  }
  /// Into a file dialog that a key has opened.
  void answer(const char* dialog, const QString& file) {
    QWidget* open = comes_up<QDialog>(&window, dialog);
    ASSERT_NE(open, nullptr) << dialog;
    // The dialog's own folder may still be read, and takes the name's field for itself while it is.
    auto* name = open->findChild<QLineEdit*>(QStringLiteral("fileNameEdit"));
    ASSERT_NE(name, nullptr);
    ASSERT_TRUE(eventually([&] { return name->hasFocus(); }));
    ASSERT_TRUE(eventually([&] {
      if (name->text() == file) return true;
      press(Qt::Key_A, Qt::ControlModifier);
      type(file);
      return name->text() == file;
    }));
    // A question of the dialog (no such file, replace it?) would wait for an answer for ever.
    QTimer::singleShot(5000, open, [] {
      for (QWidget* top : QApplication::topLevelWidgets())
        if (auto* box = qobject_cast<QMessageBox*>(top); box && box->isVisible()) {
          ADD_FAILURE() << box->text().toStdString();
          box->reject();
        }
    });
    take_the_name();
    expect_in_front(window);
  }
  /// Return, which a list of names that the field proposes may take for itself first.
  void take_the_name() {
    press(Qt::Key_Return);
    QTest::qWait(50);
    if (auto* dialog = qobject_cast<QDialog*>(QApplication::activeWindow()); dialog && dialog->isVisible())
      if (dialog->inherits("QFileDialog")) press(Qt::Key_Return);
  }
  QString alert() { return find<QLabel>("alert")->text(); }
  /// Of a short run on the virtual clock.
  QString recorded(const char* name, const char* set) {
    const app::Experiment experiment =
        *app::parse_experiment(app::paper_experiment().source, "platoon.toml", {"duration=8", "perturb=[]", set});
    QString file = dir.filePath(QLatin1String(name));
    app::CsvFile csv(file.toStdString(), experiment);
    (*app::Session::open(experiment, app::Session::Clock::virtual_, {false, {&csv}}))->run();
    csv.finish();
    return file;
  }
  QTemporaryDir dir;
};

TEST_F(Keyboard, OpensChecksStartsPausesStepsAndStops) {
  show();
  press(Qt::Key_O, Qt::ControlModifier);
  answer("open_dialog", QString::fromStdString(skein::test::in_source("resources/experiments/platoon.toml")));
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  press(Qt::Key_L, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return find("check_list")->isVisible(); }));
  ASSERT_TRUE(eventually([&] { return find<QPushButton>("go")->isEnabled(); }));
  press(Qt::Key_F5);
  ASSERT_TRUE(eventually([&] { return running() && record().t > 0.2; }));
  press(Qt::Key_F5);
  ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; }));
  const double t = record().t;
  press(Qt::Key_F6);
  EXPECT_TRUE(eventually([&] { return record().t > t + 0.03; }));
  press(Qt::Key_Up, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return live().speed() == 2.0; }));
  press(Qt::Key_F, Qt::AltModifier);  // a menu, and out of it again by what it offers
  ASSERT_TRUE(eventually([&] { return QApplication::activePopupWidget() != nullptr; }));
  press(Qt::Key_S);
  answer("save_csv_dialog", dir.filePath(QStringLiteral("kept.csv")));
  EXPECT_TRUE(eventually([&] { return QFile::exists(dir.filePath(QStringLiteral("kept.csv"))); }));
  ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; }));
  press(Qt::Key_F5);
  ASSERT_TRUE(eventually([&] { return running(); }));
  press(Qt::Key_F1);
  QPointer<QDialog> shortcuts = comes_up<QDialog>(&window, "shortcuts_dialog");
  ASSERT_NE(shortcuts, nullptr);
  close(shortcuts);  // Esc would stop
  expect_in_front(window);
  EXPECT_TRUE(running());
  press(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  press(Qt::Key_N, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return live().is_open() && live().phase() == app::Phase::ready; }));
}

TEST_F(Keyboard, NoArrowIsLostHoweverFastTheyCome) {
  start();
  window.go();
  ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; }));
  press(Qt::Key_1, Qt::ControlModifier);
  press(Qt::Key_2);
  const core::Pose before = *arena().scene().pose(1);
  press(Qt::Key_Right, Qt::NoModifier, 3);
  press(Qt::Key_Up);
  press(Qt::Key_PageUp);
  EXPECT_TRUE(eventually([&] {
    const core::Pose now = *arena().scene().pose(1);
    return std::abs(now.x - before.x - 0.06) < 1e-6 && std::abs(now.y - before.y - 0.02) < 1e-6 &&
           std::abs(core::wrap_angle(now.theta - before.theta) - 15.0 * core::pi / 180.0) < 1e-6;
  })) << arena().scene().pose(1)->x - before.x;
}

TEST_F(Keyboard, MovesTurnsKicksHoldsAndMeasures) {
  start();
  press(Qt::Key_1, Qt::ControlModifier);
  ASSERT_TRUE(arena().hasFocus());
  EXPECT_TRUE(arena().scene().has_keys) << "nobody sees where the keys go";
  press(Qt::Key_N, Qt::NoModifier, 2);
  EXPECT_EQ(arena().scene().selected, 1);
  const core::Pose before = *arena().scene().pose(1);
  press(Qt::Key_Up);
  EXPECT_NEAR(moved(1).y - before.y, 0.02, 0.02);
  press(Qt::Key_F1, Qt::ShiftModifier);
  EXPECT_TRUE(QToolTip::text().contains(QStringLiteral("Robot 2"))) << QToolTip::text().toStdString();

  press(Qt::Key_K);
  press(Qt::Key_2);
  press(Qt::Key_Return);
  press(Qt::Key_Right, Qt::NoModifier, 5);
  ASSERT_TRUE(arena().scene().kick);
  press(Qt::Key_Return);
  const auto kick = last<app::events::Kick>(1);
  EXPECT_NEAR(kick.vx, 0.4, 0.01);  // 10 cm, 25 cm for 1 m/s
  EXPECT_NEAR(kick.vy, 0.0, 0.01);
  press(Qt::Key_2);
  press(Qt::Key_Return);
  press(Qt::Key_Right, Qt::NoModifier, 5);
  ASSERT_TRUE(arena().scene().kick);
  press(Qt::Key_Backspace);
  EXPECT_FALSE(arena().scene().kick) << "what was begun cannot be given up";

  press(Qt::Key_M);
  press(Qt::Key_1);
  press(Qt::Key_Return);
  press(Qt::Key_3);
  press(Qt::Key_Return);
  ASSERT_TRUE(arena().scene().ruler);
  const core::Pose third = *arena().scene().pose(2);
  EXPECT_LT(std::hypot(arena().scene().ruler->to.x() - third.x, arena().scene().ruler->to.y() - third.y), 0.03);

  press(Qt::Key_4, Qt::ControlModifier);
  tab_to("hold_robot");
  press(Qt::Key_Return);
  last<app::events::Hold>(2);
  ASSERT_TRUE(
      eventually([&] { return find<QAbstractButton>("hold_robot")->text().startsWith(QStringLiteral("Let")); }));
  press(Qt::Key_Return);
  last<app::events::Release>(2);
  press(Qt::Key_4, Qt::ControlModifier);
  press(Qt::Key_Right, Qt::NoModifier, 3);
  press(Qt::Key_F1, Qt::ShiftModifier);
  EXPECT_FALSE(QToolTip::text().isEmpty()) << "why a robot does what it does is told to a mouse alone";
}

TEST_F(Keyboard, BringsARobotBackToItsPlace) {
  open_and_wait();
  press(Qt::Key_1, Qt::ControlModifier);
  press(Qt::Key_2);
  press(Qt::Key_Right, Qt::NoModifier, 5);
  ASSERT_TRUE(eventually([&] { return find("mend_places")->isVisible(); })) << "nobody says that robot 2 is elsewhere";
  tab_to("mend_places");
  press(Qt::Key_Return);
  EXPECT_TRUE(eventually([&] {
    return !find("check_list")->isVisible() && arena().scene().banner.contains(QStringLiteral("Ready"));
  })) << "it was not brought back";
  EXPECT_EQ(live().phase(), app::Phase::ready);
  press(Qt::Key_F5);
  EXPECT_TRUE(eventually([&] { return running(); }));
}

TEST_F(Keyboard, SwitchesTheVoiceOfAlarmsAndAsksForARehearsal) {
  open_and_wait();
  const auto choose = [&](Qt::Key menu, Qt::Key entry) {
    press(menu, Qt::AltModifier);
    ASSERT_TRUE(eventually([] { return QApplication::activePopupWidget() != nullptr; }));
    press(entry);
  };
  const bool spoke = find<QAction>("view_voice")->isChecked();
  choose(Qt::Key_V, Qt::Key_S);
  EXPECT_NE(find<QAction>("view_voice")->isChecked(), spoke);
  choose(Qt::Key_R, Qt::Key_H);
  const QPointer<QDialog> problem = comes_up<QDialog>(&window, "problem_dialog");
  ASSERT_NE(problem, nullptr) << "the paper's experiment has no hardware";
  close(problem);
  expect_in_front(window);
}

TEST_F(Keyboard, TurnsARobotAndZoomsAndPansTheArena) {
  start();
  press(Qt::Key_1, Qt::ControlModifier);
  press(Qt::Key_2);
  const double before = arena().scene().pose(1)->theta;
  press(Qt::Key_PageDown);
  EXPECT_NEAR(core::wrap_angle(moved(1).theta - before), -core::pi / 12, 0.1);

  const QPointF origin = arena().map().to_screen({0.0, 0.0});
  press(Qt::Key_Plus, Qt::ControlModifier, 3);
  const double near = arena().map().zoomed();
  EXPECT_GT(near, 1.5);
  press(Qt::Key_Minus, Qt::ControlModifier);
  EXPECT_LT(arena().map().zoomed(), near);
  const QPointF here = arena().map().to_screen({0.0, 0.0});
  press(Qt::Key_Right, Qt::AltModifier);
  EXPECT_NE(arena().map().to_screen({0.0, 0.0}), here) << "Alt and an arrow pan nothing";
  press(Qt::Key_0, Qt::ControlModifier);
  EXPECT_EQ(arena().map().zoomed(), 1.0);
  EXPECT_EQ(arena().map().to_screen({0.0, 0.0}), origin);
}

TEST_F(Keyboard, StopsTheRobotsOfAnEarlierRun) {
  const EnvironmentVariable state_home("XDG_STATE_HOME", dir.filePath(QStringLiteral("state")).toUtf8());
  ASSERT_TRUE(QDir(dir.path()).mkpath(QStringLiteral("state/skein")));
  QFile marker(dir.filePath(QStringLiteral("state/skein/run-999999")));
  ASSERT_TRUE(marker.open(QIODevice::WriteOnly));
  marker.write("skein run lab\nserial:/dev/no-such-robot\n");
  marker.close();
  show();
  ASSERT_TRUE(eventually([&] { return find("left_behind")->isVisible(); }));
  tab_to("stop_left_behind");
  press(Qt::Key_Return);
  EXPECT_TRUE(eventually([&] {
    return find<QLabel>("left_behind_text")->text().contains(QStringLiteral("Not all robots have acknowledged"));
  })) << "nobody has tried to stop them";
}

TEST_F(Keyboard, RecordsChoosesTheFormOfCouplingsFiltersEventsAndCopiesLatex) {
  settings().setValue(QStringLiteral("recordings"), dir.filePath(QStringLiteral("recordings")));
  open_and_wait();
  press(Qt::Key_2, Qt::ControlModifier);
  tab_to("coupling");
  press(Qt::Key_Down);
  ASSERT_TRUE(eventually([&] {
    return live().is_open() && live().latest() && live().experiment().controller.coupling == core::Coupling::bounded;
  }));
  press(Qt::Key_R, Qt::ControlModifier);
  ASSERT_TRUE(eventually([&] { return arena().scene().banner.startsWith(QStringLiteral("Ready")); }));
  press(Qt::Key_F5);
  ASSERT_TRUE(eventually([&] { return running(); }));
  EXPECT_TRUE(live().record_file().startsWith(dir.path())) << live().record_file().toStdString();

  auto* events = find<QAbstractItemView>("event_log")->model();
  ASSERT_TRUE(eventually([&] { return events->rowCount() > 0; }));
  press(Qt::Key_5, Qt::ControlModifier);
  tab_to("event_words");
  type(QStringLiteral("zebra"));
  EXPECT_TRUE(eventually([&] { return events->rowCount() == 0; }));
  press(Qt::Key_6, Qt::ControlModifier);
  tab_to("copy_results_latex");
  press(Qt::Key_Return);
  EXPECT_TRUE(QGuiApplication::clipboard()->text().contains(QStringLiteral("tabular")))
      << QGuiApplication::clipboard()->text().toStdString();
  settings().remove(QStringLiteral("recordings"));
}

TEST_F(Keyboard, OpensTheMenuOfThePlotAtTheCursor) {
  start();
  press(Qt::Key_3, Qt::ControlModifier);
  press(Qt::Key_Right);
  for (const char* plot : {"e_x", "e_y"}) {
    const QMenu* menu = nullptr;
    press(Qt::Key_F10, Qt::ShiftModifier);
    ASSERT_TRUE(
        eventually([&] { return (menu = qobject_cast<QMenu*>(QApplication::activePopupWidget())) != nullptr; }));
    const auto* into = menu->findChild<QMenu*>(QStringLiteral("add_signal"));
    ASSERT_NE(into, nullptr) << "it is the menu of no plot";
    const PlotsPanel& plots = *find<PlotsPanel>("plots");
    EXPECT_TRUE(into->title().endsWith(plots.titles_of({QLatin1String(plot)}))) << into->title().toStdString();
    QApplication::activePopupWidget()->close();
    press(Qt::Key_Right);
    press(Qt::Key_Down);
  }
}

TEST_F(Keyboard, DropsDrawsOutDragsAndTakesAwayAnObstacle) {
  start();
  press(Qt::Key_1, Qt::ControlModifier);
  press(Qt::Key_O);
  press(Qt::Key_Left);  // the cross stands in the middle, a step to the left
  press(Qt::Key_Return);
  press(Qt::Key_Right, Qt::NoModifier, 3);
  press(Qt::Key_Return);
  EXPECT_NEAR(last<app::events::PutObstacle>(0).obstacle.radius, 0.06, 1e-9);
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(-0.02, 0.0) == 0; }));
  press(Qt::Key_Left);
  press(Qt::Key_Return);  // inside it: taken there
  press(Qt::Key_Down, Qt::NoModifier, 10);
  press(Qt::Key_Return);
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(-0.02, -0.2) == 0; })) << "it was not dragged";
  press(Qt::Key_PageUp);
  ASSERT_TRUE(eventually([&] { return arena().scene().circumstances.obstacles[0].radius > 0.065; }))
      << "it has not grown";
  press(Qt::Key_Delete);
  EXPECT_TRUE(eventually([&] { return arena().scene().obstacle_at(-0.02, -0.2) < 0; }));
}

TEST_F(Keyboard, SetsGainsPairsPresetsAndASchedule) {
  start();
  press(Qt::Key_2, Qt::ControlModifier);
  ASSERT_TRUE(has_focus(QStringLiteral("slider_k_xx")));
  press(Qt::Key_Right);
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_xx, 0, 1) > 0.008; }));
  press(Qt::Key_Z, Qt::ControlModifier);
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_xx, 0, 1) == 0.008; }));
  tab_to("spin_k_yy");
  press(Qt::Key_A, Qt::ControlModifier);
  type(QStringLiteral("0,05"));
  press(Qt::Key_Return);
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_yy, 0, 1) == 0.05; }));
  tab_to("gain_ramp");
  press(Qt::Key_A, Qt::ControlModifier);
  type(QStringLiteral("3"));
  press(Qt::Key_Return);
  EXPECT_EQ(find<QDoubleSpinBox>("gain_ramp")->value(), 3.0);
  tab_to("gain_presets");
  then([this] {
    press(Qt::Key_Down, Qt::NoModifier, 3);  // file's, paper's, uncoupled
    press(Qt::Key_Return);
  });
  press(Qt::Key_Return);
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_yy, 0, 1) == 0.0; }));
  press(Qt::Key_Z, Qt::ControlModifier);
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_yy, 0, 1) == 0.05; }));

  auto* tabs = find<QTabWidget>("gain_tabs");
  for (int k = 0; k < 60 && QApplication::focusWidget() != tabs->tabBar(); ++k) press(Qt::Key_Tab);
  ASSERT_TRUE(tabs->tabBar()->hasFocus());
  press(Qt::Key_Right);
  tab_to("pair_table");
  auto* pairs = find<QAbstractItemView>("pair_table");
  press(Qt::Key_Home, Qt::ControlModifier);
  press(Qt::Key_Right);
  ASSERT_EQ(pairs->currentIndex().column(), 1);
  press(Qt::Key_X);
  EXPECT_TRUE(eventually([&] { return !live().coupled(0, 1); }));
  ASSERT_TRUE(eventually([&] { return pairs->currentIndex().data(Qt::CheckStateRole).toInt() == Qt::Unchecked; }));
  press(Qt::Key_X);
  EXPECT_TRUE(eventually([&] { return live().coupled(0, 1); }));
  ASSERT_TRUE(eventually([&] { return pairs->currentIndex().flags() & Qt::ItemIsEditable; }));
  press(Qt::Key_F2);
  press(Qt::Key_A, Qt::ControlModifier);
  type(QStringLiteral("0.004"));
  press(Qt::Key_Return);
  EXPECT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_xx, 0, 1) == 0.004; }));

  press(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  press(Qt::Key_N, Qt::ControlModifier);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().phase() == app::Phase::ready; }));
  ASSERT_TRUE(eventually([&] { return find("schedule_add")->isEnabled(); }));
  tabs->tabBar()->setFocus(Qt::TabFocusReason);
  press(Qt::Key_Right);
  tab_to("schedule_add");
  press(Qt::Key_Return);
  tab_to("schedule_table");
  press(Qt::Key_Home, Qt::ControlModifier);
  press(Qt::Key_Right);
  type(QStringLiteral("0.005"));
  press(Qt::Key_Return);
  tab_to("schedule_apply");
  press(Qt::Key_Return);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().experiment().gain_changes.size() == 1; }));
  EXPECT_EQ(live().experiment().gain_changes[0][core::GainName::k_xx]->largest(), 0.005);
}

TEST_F(Keyboard, ReplaysScrubsReadsComparesSavesAndGoesOn) {
  const QString file = recorded("one.csv", "controller.gains.k_xx=0.008");
  const QString other = recorded("two.csv", "controller.gains.k_xx=0");
  show();
  press(Qt::Key_O, Qt::ControlModifier | Qt::ShiftModifier);
  answer("open_recording_dialog", file);
  ASSERT_TRUE(eventually([&] { return window.replay().is_loaded(); }));
  press(Qt::Key_Space);
  ASSERT_FALSE(window.replay().is_playing());
  press(Qt::Key_7, Qt::ControlModifier);
  press(Qt::Key_Home);
  press(Qt::Key_Right, Qt::NoModifier, 3);
  EXPECT_NEAR(window.replay().t(), 3.0, 0.05);

  press(Qt::Key_3, Qt::ControlModifier);
  press(Qt::Key_Right);
  EXPECT_TRUE(QToolTip::text().contains(QStringLiteral("along x"))) << QToolTip::text().toStdString();
  press(Qt::Key_Down);
  EXPECT_TRUE(QToolTip::text().contains(QStringLiteral("along y"))) << QToolTip::text().toStdString();
  press(Qt::Key_Plus);
  EXPECT_FALSE(find<PlotsPanel>("plots")->is_live());
  press(Qt::Key_Home);
  EXPECT_TRUE(find<PlotsPanel>("plots")->is_live());
  press(Qt::Key_Left, Qt::NoModifier, 5);
  press(Qt::Key_Return);
  EXPECT_LT(window.replay().t(), 2.99) << "the replay did not go to the cursor";
  tab_to("plots");  // backwards would do as well: from the plots on, all the way round
  tab_to("choose_plots");
  for (const bool shown : {false, true}) {  // and back: the choice is kept for the windows to come
    then([this] {
      press(Qt::Key_Down);
      press(Qt::Key_Return);
    });
    press(Qt::Key_Return);
    EXPECT_TRUE(
        eventually([&] { return find<PlotsPanel>("plots")->shown().contains(QStringLiteral("e_x")) == shown; }));
  }

  press(Qt::Key_D, Qt::ControlModifier);
  answer("compare_dialog", other);
  ASSERT_TRUE(eventually([&] { return arena().scene().compared.size() == 1; }));
  for (const std::size_t shown : {0U, 1U}) {
    press(Qt::Key_3, Qt::ControlModifier);
    tab_to("compared_A");
    press(Qt::Key_Return);
    EXPECT_TRUE(eventually([&] { return arena().scene().compared.size() == shown; })) << "by the legend's switch";
  }
  press(Qt::Key_6, Qt::ControlModifier);
  tab_to("copy_results");
  press(Qt::Key_Return);
  EXPECT_TRUE(QGuiApplication::clipboard()->text().contains(QStringLiteral("whole run")));
  press(Qt::Key_5, Qt::ControlModifier);
  press(Qt::Key_Home);
  press(Qt::Key_Return);
  EXPECT_NEAR(window.replay().t(), 0.0, 0.05) << "the replay did not go to the event";
  press(Qt::Key_P, Qt::ControlModifier);
  answer("save_plot_dialog", dir.filePath(QStringLiteral("plot.pdf")));
  EXPECT_TRUE(eventually([&] { return QFile::exists(dir.filePath(QStringLiteral("plot.pdf"))); }));
  press(Qt::Key_7, Qt::ControlModifier);
  press(Qt::Key_Right, Qt::NoModifier, 2);
  press(Qt::Key_B, Qt::ControlModifier);
  ASSERT_TRUE(eventually([&] { return live().latest() && live().phase() == app::Phase::paused; }));
  EXPECT_NEAR(record().t, 2.0, 0.05);
}

TEST_F(Keyboard, AlignsComparedRunsAtAKick) {
  const QString file = recorded("one.csv", "perturb=[{ t = 2, robot = 2, dx = 0.1 }]");
  const QString other = recorded("two.csv", "perturb=[{ t = 5, robot = 2, dx = 0.1 }]");
  show();
  press(Qt::Key_O, Qt::ControlModifier | Qt::ShiftModifier);
  answer("open_recording_dialog", file);
  ASSERT_TRUE(eventually([&] { return window.replay().is_loaded(); }));
  press(Qt::Key_Space);
  press(Qt::Key_D, Qt::ControlModifier);
  answer("compare_dialog", other);
  ASSERT_TRUE(eventually([&] { return arena().scene().compared.size() == 1; }));
  auto* align = find<QComboBox>("compare_align");
  ASSERT_TRUE(eventually([&] { return align->count() == 2; }));
  press(Qt::Key_7, Qt::ControlModifier);
  press(Qt::Key_Home);
  press(Qt::Key_Right, Qt::NoModifier, 3);  // a second after the kick of this run, two before the other's
  const auto apart = [&] {
    const auto& trail = arena().scene().compared[0].trails[1];
    return trail.empty() ? 0.0 : core::distance(trail.back(), *arena().scene().pose(1));
  };
  ASSERT_TRUE(eventually([&] { return apart() > 0.02; })) << "control: not aligned, they are not together";
  press(Qt::Key_3, Qt::ControlModifier);
  tab_to("compare_align");
  const double before = apart();
  press(Qt::Key_Down);
  EXPECT_EQ(align->currentIndex(), 1);
  EXPECT_TRUE(eventually([&] { return std::abs(apart() - before) > 0.02; })) << "it makes no difference";
  const double aligned = apart();
  press(Qt::Key_Up);
  EXPECT_EQ(align->currentIndex(), 0);
  EXPECT_TRUE(eventually([&] { return std::abs(apart() - aligned) > 0.02; })) << "it made no difference";
}

TEST_F(Keyboard, SavesUsesAndForgetsALayoutAndDrawsOnePlotOverAnother) {
  start();
  auto* plots = find<PlotsPanel>("plots");
  const auto in_menu = [&](const std::vector<Qt::Key>& keys) {
    press(Qt::Key_3, Qt::ControlModifier);
    tab_to("choose_plots");
    then([this, keys] {
      for (const Qt::Key one : keys) press(one);
    });
    press(Qt::Key_Return);
  };
  in_menu({Qt::Key_O, Qt::Key_Down, Qt::Key_Right, Qt::Key_Down, Qt::Key_Return});  // e_y over the first of its list
  EXPECT_TRUE(eventually([&] { return plots->over().isVisible(); })) << "nothing is drawn over anything";
  const QStringList drawn = plots->shown();
  in_menu({Qt::Key_L, Qt::Key_S});
  auto* name = comes_up<QDialog>(&window, "layout_dialog");
  ASSERT_NE(name, nullptr);
  type(QStringLiteral("mine"));
  press(Qt::Key_Return);
  expect_in_front(window);
  in_menu({Qt::Key_O, Qt::Key_Right, Qt::Key_Up, Qt::Key_Return});  // the last of the list: nothing
  EXPECT_TRUE(eventually([&] { return !plots->over().isVisible(); }));
  in_menu({Qt::Key_Down, Qt::Key_Return});  // without e_x
  ASSERT_TRUE(eventually([&] { return plots->shown() != drawn; }));
  in_menu({Qt::Key_L, Qt::Key_Return});
  EXPECT_TRUE(eventually([&] { return plots->shown() == drawn && plots->over().isVisible(); }))
      << plots->shown().join(QLatin1Char(' ')).toStdString();
  in_menu({Qt::Key_L, Qt::Key_F, Qt::Key_Return});
  EXPECT_TRUE(eventually([&] { return plot_layouts().empty(); }));
  plots->show_over({}, {});
}

TEST_F(Keyboard, LooksThroughACameraAndSavesAReport) {
  QImage grey(64, 48, QImage::Format_Grayscale8);
  grey.fill(128);
  ASSERT_TRUE(grey.save(dir.filePath(QStringLiteral("a.png"))));
  settings().setValue(QStringLiteral("recordings"), dir.filePath(QStringLiteral("reports")));
  start();
  press(Qt::Key_R, Qt::AltModifier);
  ASSERT_TRUE(eventually([&] { return QApplication::activePopupWidget() != nullptr; }));
  press(Qt::Key_A);
  QPointer<QDialog> page = comes_up<QDialog>(&window, "camera_page");
  ASSERT_NE(page, nullptr);
  tab_to("camera_source");
  press(Qt::Key_A, Qt::ControlModifier);
  type(QStringLiteral("images:") + dir.path());
  tab_to("camera_look");
  press(Qt::Key_Return);
  auto* status = page->findChild<QLabel*>(QStringLiteral("camera_status"));
  EXPECT_TRUE(eventually([&] { return status->text().contains(QStringLiteral("no more pictures")); }))
      << status->text().toStdString();
  close(page);
  expect_in_front(window);
  EXPECT_TRUE(running());
  press(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  press(Qt::Key_6, Qt::ControlModifier);
  tab_to("save_results");
  press(Qt::Key_Return);
  const QDir reports(dir.filePath(QStringLiteral("reports")));
  EXPECT_TRUE(eventually([&] {
    const QStringList folders = reports.entryList(QDir::Dirs | QDir::NoDotAndDotDot);
    return folders.size() == 1 && QFile::exists(reports.filePath(folders.first() + QStringLiteral("/report.html")));
  })) << alert().toStdString();
  // What of it cannot be done on this machine is told in a message.
  EXPECT_TRUE(eventually([&] {
    return alert().contains(QStringLiteral("report")) || window.findChild<QDialog*>(QStringLiteral("problem_dialog"));
  }));
  settings().remove(QStringLiteral("recordings"));
}

TEST_F(Keyboard, EditsAnExperimentWhileARunIsOn) {
  start();
  press(Qt::Key_E, Qt::ControlModifier);
  auto* editor = comes_up<ExperimentEditor>(&window, "experiment_editor");
  ASSERT_NE(editor, nullptr);
  editor->findChild<QPlainTextEdit*>()->setFocus();
  press(Qt::Key_Home, Qt::ControlModifier);
  type(QStringLiteral("#keys"));
  press(Qt::Key_Return);
  EXPECT_TRUE(editor->text().startsWith(QStringLiteral("#keys\n")));
  tab_to("editor_save_as");
  press(Qt::Key_Return);
  ASSERT_NE(comes_up<QDialog>(editor, "editor_save_dialog"), nullptr);
  press(Qt::Key_A, Qt::ControlModifier);
  type(dir.filePath(QStringLiteral("mine.toml")));
  take_the_name();
  ASSERT_TRUE(eventually([&] { return QFile::exists(dir.filePath(QStringLiteral("mine.toml"))); }));
  expect_in_front(*editor);
  press(Qt::Key_W, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return window.findChild<ExperimentEditor*>() == nullptr; }));
  EXPECT_TRUE(running());
}

/// What Tab goes to, once round.
std::set<QWidget*> round_of(QWidget* window) {
  std::set<QWidget*> seen;
  for (int k = 0, again = 0; k < 300 && again < 5; ++k) {
    if (!window->isActiveWindow() && !bring_to_front(*window)) break;
    QTest::keyClick(window->windowHandle(), Qt::Key_Tab);
    if (QWidget* focus = QApplication::focusWidget()) again = seen.insert(focus).second ? 0 : again + 1;
  }
  return seen;
}

TEST_F(Keyboard, NoTwoEntriesOfAMenuHaveTheSameLetter) {
  int menus = 0;
  for (QMenu* menu : window.findChildren<QMenu*>()) {
    std::map<QChar, QString> letters;
    menus += menu->actions().size() > 1 ? 1 : 0;
    for (const QAction* action : menu->actions()) {
      const qsizetype at = action->text().indexOf(QLatin1Char('&'));
      if (at < 0 || at + 1 >= action->text().size()) continue;
      const auto [first, is_new] = letters.try_emplace(action->text().at(at + 1).toLower(), action->text());
      EXPECT_TRUE(is_new) << "the letter of \"" << action->text().toStdString() << "\" only goes from \""
                          << first->second.toStdString() << "\" to it, and opens neither";
    }
  }
  EXPECT_GT(menus, 5);
}

TEST_F(Keyboard, TabGetsToEveryControlOfTheWindowAndOfEveryDialog) {
  start();
  const auto expect_all = [](QWidget* window) {
    const std::set<QWidget*> reached = round_of(window);
    int controls = 0;
    for (QWidget* widget : window->findChildren<QWidget*>()) {
      const bool takes_keys = widget->focusPolicy() & Qt::TabFocus && widget->isEnabled() && widget->isVisible() &&
                              widget->window() == window && widget->focusProxy() == nullptr;
      if (!takes_keys) continue;
      ++controls;
      EXPECT_TRUE(reached.contains(widget))
          << widget->metaObject()->className() << " " << widget->objectName().toStdString() << " of "
          << window->objectName().toStdString();
    }
    return controls;
  };
  for (int tab = 0; tab < 3; ++tab) {
    find<QTabWidget>("gain_tabs")->setCurrentIndex(tab);
    EXPECT_GT(expect_all(&window), 20);
  }
  find<QDockWidget>("results_dock")->raise();
  expect_all(&window);
  for (const auto& [action, name] : {std::pair{"shortcuts", "shortcuts_dialog"},
                                     {"open", "open_dialog"},
                                     {"save_plot", "save_plot_dialog"},
                                     {"edit_experiment", "experiment_editor"},
                                     {"calibrate_camera", "calibration_dialog"},
                                     {"camera", "camera_page"},
                                     {"connect_robots_page", "connect_page"}}) {
    find<QAction>(action)->trigger();
    auto* dialog = comes_up<QDialog>(&window, name);
    ASSERT_NE(dialog, nullptr) << name;
    if (auto* search = dialog->findChild<QPushButton*>(QStringLiteral("camera_search"))) {
      ASSERT_TRUE(eventually([&] { return search->isEnabled(); })) << "cameras are still being looked for";
    }
    EXPECT_GT(expect_all(dialog), 0) << name;
    delete dialog;
    window.activateWindow();
    ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
  }
}

TEST_F(Keyboard, TabGoesThroughTheGainsFromTheTopDown) {
  start();
  auto* gains = find("gains");
  std::vector<QWidget*> parts;  // of the panel, in the order in which Tab comes to them
  for (QWidget* next = gains->nextInFocusChain(); next != gains; next = next->nextInFocusChain()) {
    if (!gains->isAncestorOf(next) || !next->isVisible() || !(next->focusPolicy() & Qt::TabFocus)) continue;
    QWidget* part = next;
    while (part->parentWidget() != gains) part = part->parentWidget();
    if (parts.empty() || parts.back() != part) parts.push_back(part);
  }
  EXPECT_GT(parts.size(), 5U);
  for (std::size_t k = 1; k < parts.size(); ++k)
    EXPECT_GT(parts[k]->geometry().bottom(), parts[k - 1]->geometry().center().y())
        << parts[k]->objectName().toStdString() << " is above " << parts[k - 1]->objectName().toStdString();
}

TEST_F(Keyboard, TabGoesThroughTheRunBarFromTheLeftToTheRight) {
  open_and_wait();
  const auto* bar = find("run_bar");
  QStringList order;
  for (const QWidget* next = bar->nextInFocusChain(); next != bar; next = next->nextInFocusChain())
    if (bar->isAncestorOf(next) && next->focusPolicy() & Qt::TabFocus) order << next->objectName();
  EXPECT_EQ(order.join(QLatin1Char(' ')).toStdString(), "go step speed new_run record");
}

TEST_F(Keyboard, QuitsFromADialogAsWell) {
  open_and_wait();
  find<QAction>("camera")->trigger();
  auto* page = find<QDialog>("camera_page");
  ASSERT_TRUE(bring_to_front(*page));
  key(Qt::Key_Q, page, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return !window.isVisible(); }));
}

}  // namespace
}  // namespace skein::ui::test
