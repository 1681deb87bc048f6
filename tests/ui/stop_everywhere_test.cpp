// STOP beside every dialog that the window has, and in every state of a run, by Space, Esc and the button.
#include <QAction>
#include <QApplication>

#include "operator.h"

namespace skein::ui::test {
namespace {

enum class By { space, escape, button };
constexpr std::array ways{By::space, By::escape, By::button};

class StopEverywhere : public Operator {
 protected:
  void stop(By way, QWidget* in = nullptr) {
    if (way == By::button)
      QTest::mouseClick(find<QPushButton>("stop"), Qt::LeftButton);
    else
      key(way == By::space ? Qt::Key_Space : Qt::Key_Escape, in);
  }
  void run_again() {
    ASSERT_TRUE(eventually([&] { return !live().is_busy(); }));
    window.new_run();
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
    window.go();
    ASSERT_TRUE(eventually([&] { return running(); }));
  }
  /// The dialogs and windows beside the main one.
  QList<QWidget*> beside() {
    QList<QWidget*> found;
    for (QWidget* widget : QApplication::topLevelWidgets())
      if (widget->isVisible() && widget != &window && widget->windowType() != Qt::ToolTip) found << widget;
    return found;
  }
};

TEST_F(StopEverywhere, BesideEveryDialog) {
  start();
  QStringList names{QStringLiteral("shortcuts"), QStringLiteral("about")};
  for (const QAction* action : window.findChildren<QAction*>())  // by habit, what opens a dialog ends with dots
    if (action->text().endsWith(QStringLiteral("…")) && !action->objectName().isEmpty() &&
        !names.contains(action->objectName()))
      names << action->objectName();
  EXPECT_GE(names.size(), 10) << names.join(QLatin1Char(' ')).toStdString();
  std::size_t turn = 0;
  for (const QString& name : names) {
    if (!running()) run_again();
    auto* action = window.findChild<QAction*>(name);
    ASSERT_TRUE(eventually([&] { return action->isEnabled(); })) << name.toStdString();
    action->trigger();
    ASSERT_TRUE(eventually([&] { return beside().size() == 1; })) << name.toStdString();
    QWidget* dialog = beside().first();
    EXPECT_FALSE(dialog->isModal()) << name.toStdString() << ": nobody could click STOP beside it";
    const auto* button = find<QPushButton>("stop");
    EXPECT_FALSE(dialog->frameGeometry().intersects(QRect(button->mapToGlobal(QPoint()), button->size())))
        << name.toStdString() << " hides STOP";
    ASSERT_TRUE(bring_to_front(*dialog));
    const By way = ways[turn++ % ways.size()];  // each dialog another way, and every way by Stop.WithADialogOpen
    stop(way, dialog);
    ASSERT_TRUE(eventually([&] { return stopped(); })) << name.toStdString() << ", way " << static_cast<int>(way);
    EXPECT_TRUE(dialog->isVisible()) << name.toStdString() << ": the key did more than stop";
    delete dialog;
    ASSERT_TRUE(eventually([&] { return beside().isEmpty(); }));
  }
}

TEST_F(StopEverywhere, InEveryState) {
  start();
  for (const By way : ways) {
    SCOPED_TRACE(static_cast<int>(way));
    stop(way);  // running
    ASSERT_TRUE(eventually([&] { return stopped(); }));
    stop(way);  // once more changes nothing
    QTest::qWait(50);
    EXPECT_TRUE(stopped());

    window.new_run();
    stop(way);  // while it is opened
    ASSERT_TRUE(eventually([&] { return live().is_open() && stopped(); }));
    window.go();  // sets up again, and starts nothing
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().phase() == app::Phase::ready; }));

    ASSERT_TRUE(eventually([&] { return !live().is_busy(); }));
    window.new_run();
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
    stop(way);  // ready
    ASSERT_TRUE(eventually([&] { return stopped(); }));

    run_again();
    window.go();
    ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; }));
    stop(way);
    ASSERT_TRUE(eventually([&] { return stopped(); })) << "paused";
    run_again();
  }
  app::Experiment away = app::paper_experiment();
  away.robots[0].start = core::Pose{-0.3, -0.2, 2.0};
  for (const By way : ways) {
    ASSERT_TRUE(eventually([&] { return !live().is_busy(); }));
    window.open(away, false);
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
    const_cast<LiveRun&>(live()).stage();  // as the check list does for robots that nobody can put anywhere
    ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::staging; }));
    stop(way);
    ASSERT_TRUE(eventually([&] { return stopped(); })) << "staging, way " << static_cast<int>(way);
  }
  // Finished: nothing moves, and nothing is undone.
  app::Experiment brief = app::paper_experiment();
  brief.duration = 0.4;
  ASSERT_TRUE(eventually([&] { return !live().is_busy(); }));
  window.open(brief, true);
  ASSERT_TRUE(eventually([&] { return live().latest() && live().phase() == app::Phase::finished; }));
  for (const By way : ways) stop(way);
  EXPECT_EQ(live().phase(), app::Phase::finished);
}

}  // namespace
}  // namespace skein::ui::test
