// STOP, in every way and from every corner.
#include <QComboBox>
#include <QDialog>
#include <QDoubleSpinBox>
#include <QLineEdit>
#include <QMenu>
#include <QMenuBar>
#include <QSignalSpy>
#include <QSlider>
#include <QToolButton>

#include "operator.h"
#include "ui/status/alert_strip.h"
#include "ui/status/alert_voice.h"

namespace skein::ui::test {
namespace {

class Stop : public Operator {
 protected:
  void expect_stopped() {
    ASSERT_TRUE(eventually([&] { return stopped(); })) << "the robots drive on";
    for (const app::RobotRecord& robot : record().robots) {
      EXPECT_TRUE(robot.is(app::stopped));
      EXPECT_EQ(robot.wheels, core::WheelSpeeds{});
    }
    EXPECT_TRUE(eventually([&] { return arena().scene().banner.contains(QStringLiteral("STOPPED by operator")); }));
    EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("STOPPED by operator")));
    EXPECT_EQ(count(saved_events(), "stop"), 1);
  }
};

TEST_F(Stop, BySpace) {
  start();
  key(Qt::Key_Space);
  expect_stopped();
}

TEST_F(Stop, ByEscape) {
  start();
  key(Qt::Key_Escape);
  expect_stopped();
}

TEST_F(Stop, ByTheButtonOnTheWayDown) {
  start();
  QTest::mousePress(find<QPushButton>("stop"), Qt::LeftButton);
  expect_stopped();
  QTest::mouseRelease(find<QPushButton>("stop"), Qt::LeftButton);
}

TEST_F(Stop, ByTheMenu) {
  start();
  find<QAction>("stop_action")->trigger();
  expect_stopped();
}

TEST_F(Stop, IsSpokenWhereThatIsSwitchedOn) {
  start();
  auto* voice = window.findChild<AlertVoice*>(QStringLiteral("alert_voice"));
  auto* speaks = find<QAction>("view_voice");
  EXPECT_FALSE(speaks->isChecked()) << "nobody is startled who did not ask for it";
  const QSignalSpy said(voice, &AlertVoice::said);
  speaks->trigger();
  window.stop();
  expect_stopped();
  ASSERT_GE(said.size(), 1);
  EXPECT_TRUE(said.last()[0].toString().contains(QStringLiteral("STOPPED by operator")));
  speaks->trigger();
  const qsizetype before = said.size();
  find<AlertStrip>("alert")->clear_alert();
  find<AlertStrip>("alert")->hold(QStringLiteral("STOPPED once more"), Severity::alarm);
  EXPECT_EQ(said.size(), before) << "it is switched off";
}

TEST_F(Stop, WithTheFocusInAnyWidgetThatTakesKeys) {
  start();
  int tried = 0;
  for (const char* name : {"spin_k_xx", "slider_k_tt", "go", "new_run", "robots", "event_log", "reset_gains", "arena",
                           "event_words", "event_level", "gain_presets"})
    for (const Qt::Key pressed : {Qt::Key_Space, Qt::Key_Escape}) {
      auto* widget = find(name);
      ASSERT_TRUE(eventually([&] { return widget->isEnabled(); })) << name;
      widget->setFocus();
      ASSERT_TRUE(eventually([&] { return widget->hasFocus(); })) << name;
      key(pressed);
      ASSERT_TRUE(eventually([&] { return stopped(); })) << name << " kept the key to itself";
      ++tried;
      window.new_run();
      ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
      EXPECT_EQ(live().phase(), app::Phase::ready) << name << " was pressed by the key that meant STOP";
      window.go();
      ASSERT_TRUE(eventually([&] { return running(); }));
    }
  EXPECT_EQ(tried, 22);
}

TEST_F(Stop, WhileANumberIsBeingTyped) {
  start();
  auto* spin = find<QDoubleSpinBox>("spin_k_xx");
  spin->setFocus();
  spin->selectAll();
  QTest::keyClicks(spin, QStringLiteral("0.0"));
  key(Qt::Key_Space);
  expect_stopped();
}

TEST_F(Stop, WithADialogOpen) {
  for (const char* action : {"shortcuts", "about", "open", "save_csv", "save_plot"}) {
    if (!live().is_open()) start();
    ASSERT_TRUE(eventually([&] { return find<QAction>(action)->isEnabled(); }));
    find<QAction>(action)->trigger();
    QDialog* dialog = nullptr;
    ASSERT_TRUE(eventually([&] {
      dialog = window.findChild<QDialog*>();
      return dialog != nullptr && dialog->isVisible();
    })) << action;
    EXPECT_FALSE(dialog->isModal()) << action << ": nobody could click STOP beside it";
    ASSERT_TRUE(bring_to_front(*dialog));
    key(Qt::Key_Space, dialog);
    ASSERT_TRUE(eventually([&] { return stopped(); })) << action;
    EXPECT_TRUE(dialog->isVisible()) << action << ": the key did more than stop";
    delete dialog;
    window.new_run();
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
    window.go();
    ASSERT_TRUE(eventually([&] { return running(); }));
  }
}

TEST_F(Stop, WhileAPresetIsNamed) {
  start();
  QMenu* menu = find<QToolButton>("gain_presets")->menu();
  emit menu->aboutToShow();
  find<QAction>("keep_preset")->trigger();
  auto* dialog = find<QDialog>("preset_dialog");
  ASSERT_TRUE(QTest::qWaitForWindowExposed(dialog));
  EXPECT_FALSE(dialog->isModal());
  ASSERT_TRUE(bring_to_front(*dialog));
  key(Qt::Key_Escape, dialog);
  expect_stopped();
  EXPECT_TRUE(dialog->isVisible()) << "the key did more than stop";
  delete dialog;
}

TEST_F(Stop, WithTheCheckListOpen) {
  window.resize(1280, 800);
  window.show();
  window.activateWindow();
  window.open(app::paper_experiment(), false);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  find<QAction>("view_checks")->trigger();
  ASSERT_TRUE(eventually([&] { return find("check_list")->isVisible(); }));
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); })) << "STOP before the start is latched as well";
  window.go();  // sets up again, and starts nothing
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() && live().phase() == app::Phase::ready; }));
}

TEST_F(Stop, LetsAFileNameHaveBlanksOnceNothingMoves) {
  start();
  key(Qt::Key_Space);
  expect_stopped();
  find<QAction>("save_csv")->trigger();
  auto* dialog = find<QDialog>("save_csv_dialog");
  ASSERT_TRUE(QTest::qWaitForWindowExposed(dialog));
  dialog->activateWindow();
  auto* name = dialog->findChild<QLineEdit*>();
  name->setFocus();
  ASSERT_TRUE(eventually([&] { return name->hasFocus(); }));
  name->clear();
  for (const Qt::Key pressed : {Qt::Key_A, Qt::Key_Space, Qt::Key_B}) key(pressed, dialog);
  EXPECT_EQ(name->text().toLower(), QStringLiteral("a b"));
  delete dialog;
}

TEST_F(Stop, WithAMenuOpen) {
  start();
  auto* menu = window.findChild<QMenuBar*>()->actions().first()->menu();
  menu->popup(window.mapToGlobal(QPoint(10, 20)));
  ASSERT_TRUE(QTest::qWaitForWindowExposed(menu));
  key(Qt::Key_Escape, menu);
  expect_stopped();
  EXPECT_EQ(QApplication::activePopupWidget(), nullptr) << "it takes the keys that follow";
}

TEST_F(Stop, ClosesEveryListAndMenuThatIsOpen) {
  start();
  auto* menu = window.findChild<QMenuBar*>()->actions().first()->menu();
  QMenu inner;
  QComboBox list;
  list.addItems({QStringLiteral("one"), QStringLiteral("two")});
  list.show();
  menu->popup(window.mapToGlobal(QPoint(10, 20)));
  inner.addAction(QStringLiteral("more"));
  inner.popup(window.mapToGlobal(QPoint(60, 60)));
  list.showPopup();
  ASSERT_NE(QApplication::activePopupWidget(), nullptr);
  ASSERT_NE(QApplication::activePopupWidget(), &inner) << "the list is in front of the menus";
  key(Qt::Key_Space, QApplication::activePopupWidget());
  expect_stopped();
  EXPECT_EQ(QApplication::activePopupWidget(), nullptr);
  EXPECT_EQ(list.currentIndex(), 0) << "and chose nothing";
}

TEST_F(Stop, ByTheButtonWithAMenuOpen) {
  start();
  auto* menu = window.findChild<QMenuBar*>()->actions().first()->menu();
  menu->popup(window.mapToGlobal(QPoint(10, 20)));
  ASSERT_TRUE(QTest::qWaitForWindowExposed(menu));
  auto* button = find<QPushButton>("stop");
  // The window system hands the press to the menu, wherever it is.
  QTest::mousePress(menu, Qt::LeftButton, {}, menu->mapFromGlobal(button->mapToGlobal(button->rect().center())));
  expect_stopped();
  EXPECT_EQ(QApplication::activePopupWidget(), nullptr);
  QTest::mouseRelease(button, Qt::LeftButton);
}

TEST_F(Stop, InTheMiddleOfADrag) {
  start();
  QTest::mousePress(&arena(), Qt::LeftButton, {}, robot(1));
  QTest::mouseMove(&arena(), floor(0, 0));
  key(Qt::Key_Space);
  expect_stopped();
  QTest::mouseRelease(&arena(), Qt::LeftButton, {}, floor(0, 0));
}

TEST_F(Stop, WhilePaused) {
  start();
  window.go();
  ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; }));
  key(Qt::Key_Space);
  expect_stopped();
}

TEST_F(Stop, BeforeTheStartAndWhileOpening) {
  window.resize(1280, 800);
  window.show();
  window.activateWindow();
  window.open(app::paper_experiment(), true);
  window.stop();  // nothing is open yet, and it would start by itself
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr && stopped(); }));
  EXPECT_EQ(live().latest()->t, 0.0);
}

TEST_F(Stop, IsAlwaysThere) {
  start();
  auto* button = find<QPushButton>("stop");
  const auto there = [&] { return button->isEnabled() && button->isVisible() && !button->visibleRegion().isEmpty(); };
  EXPECT_TRUE(there());
  key(Qt::Key_Space);
  expect_stopped();
  EXPECT_TRUE(there());
  window.new_run();
  EXPECT_TRUE(there()) << "while a session is opened";
}

TEST_F(Stop, WhenTheWindowCloses) {
  start();
  window.close();
  ASSERT_TRUE(eventually([&] { return !window.isVisible(); }));
  EXPECT_FALSE(live().is_open());
  EXPECT_TRUE(live().stop_asked());
}

}  // namespace
}  // namespace skein::ui::test
