// STOP beside every dialog that the window has, and in every state of a run, by Space, Esc and the button.
#include <QAction>
#include <QApplication>
#include <QMenu>
#include <QPlainTextEdit>
#include <QPointer>
#include <QToolButton>

#include "operator.h"
#include "ui/editor/experiment_editor.h"

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

TEST_F(StopEverywhere, BesideADialogThatCameBeforeTheWindowHadItsPlace) {
  start();
  find<QAction>("edit_experiment")->trigger();
  ASSERT_TRUE(eventually([&] { return beside().size() == 1; }));
  QWidget* dialog = beside().first();
  const auto* button = find<QPushButton>("stop");
  const auto stop_there = [&] { return QRect(button->mapToGlobal(QPoint()), button->size()); };
  // As a window manager places it.
  window.move(window.pos() + dialog->frameGeometry().center() - stop_there().center());
  EXPECT_TRUE(eventually([&] { return !dialog->frameGeometry().intersects(stop_there()); })) << "the editor hides STOP";
  delete dialog;
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
    if (way == ways.front()) {
      ASSERT_EQ(live().state().go, RunState::Go::pause);
      ASSERT_TRUE(live().state().may_go);
      window.go();
      ASSERT_TRUE(eventually([&] { return live().is_paused(); })) << "staging is not paused";
      EXPECT_EQ(live().state().go, RunState::Go::resume);
      window.go();
      ASSERT_TRUE(eventually([&] { return !live().is_paused(); })) << "staging is not resumed";
      EXPECT_EQ(live().phase(), app::Phase::staging);
      window.go();
      ASSERT_TRUE(eventually([&] { return live().is_paused(); }));
    }
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

/// Every kind of message and question that the window can show, by what brings it up.
struct Message {
  const char* name;  // of the dialog
  bool tells;        // only tells something: the window's own keys work in it
  std::function<void()> comes;
};

class Messages : public StopEverywhere {
 protected:
  std::vector<Message> all() {
    const auto by = [this](const char* action) { return [this, action] { find<QAction>(action)->trigger(); }; };
    const auto broken = [this](const char* name, const char* text) {
      return [this, name, text] {
        QFile file(dir.filePath(QLatin1String(name)));
        EXPECT_TRUE(file.open(QIODevice::WriteOnly));
        file.write(text);
        file.close();
        window.open_file(file.fileName());
      };
    };
    const auto editor = [this] {
      find<QAction>("edit_experiment")->trigger();
      auto* made = find<ExperimentEditor>("experiment_editor");
      made->edit(made->text() + QStringLiteral("# changed\n"), dir.filePath(QStringLiteral("mine.toml")));
      return made;
    };
    return {
        {"shortcuts_dialog", true, by("shortcuts")},
        {"about_dialog", true, by("about")},
        {"problem_dialog", true, [this] { window.open_file(dir.filePath(QStringLiteral("notes.txt"))); }},
        {"problem_dialog", true, broken("broken.csv", "# skein 0.1.0\nt,tick,r1_x\n0,0,zebra\n")},
        {"problem_dialog", true, [this] { window.open_file(dir.filePath(QStringLiteral("nowhere.toml"))); }},
        {"problem_dialog", true, [this] { window.save_plot(QStringLiteral("/nowhere/plot.pdf"), false); }},
        {"problem_dialog", true, [this] { window.save_csv(QStringLiteral("/nowhere/run.csv")); }},
        {"problem_dialog", true, by("rehearse")},
        {"experiment_editor", false, broken("broken.toml", "rate = -3\n")},
        {"open_dialog", false, by("open")},
        {"open_recording_dialog", false, by("open_recording")},
        {"compare_dialog", false, by("compare")},
        {"save_csv_dialog", false, by("save_csv")},
        {"save_plot_dialog", false, by("save_plot")},
        {"preset_dialog", false,
         [this] {
           QMenu* menu = find<QToolButton>("gain_presets")->menu();
           emit menu->aboutToShow();
           find<QAction>("keep_preset")->trigger();
         }},
        {"layout_dialog", false,
         [this] {
           QMenu* menu = find<QToolButton>("choose_plots")->menu();
           emit menu->aboutToShow();
           find<QAction>("keep_layout")->trigger();
         }},
        {"editor_close_dialog", false,
         [this, editor] {
           editor();
           QTest::keyClicks(find<ExperimentEditor>("experiment_editor")->findChild<QPlainTextEdit*>(),
                            QStringLiteral("#x"));
           find<ExperimentEditor>("experiment_editor")->reject();
         }},
        {"calibration_dialog", false, by("calibrate_camera")},
        {"camera_page", false, by("camera")},
        {"connect_page", false, by("connect_robots_page")},
    };
  }
  /// The dialog of this message, with the focus.
  QDialog* bring(const Message& message) {
    message.comes();
    QDialog* dialog = nullptr;
    const bool there = eventually([&] {
      dialog = window.findChild<QDialog*>(QLatin1String(message.name));
      return dialog && dialog->isVisible();
    });
    EXPECT_TRUE(there) << message.name;
    return there && bring_to_front(*dialog) ? dialog : nullptr;
  }
  void clear() {
    while (auto* dialog = window.findChild<QDialog*>()) delete dialog;
    ASSERT_TRUE(eventually([&] { return beside().isEmpty(); }));
    ASSERT_TRUE(bring_to_front(window));
  }
  QTemporaryDir dir;
};

TEST_F(Messages, LetCtrlSF5SpaceAndEscDoWhatTheyDoInTheWindowOrNothing) {
  start();
  std::size_t turn = 0;
  for (const Message& message : all()) {
    SCOPED_TRACE(std::string(message.name) + ", message " + std::to_string(turn));
    if (!running()) run_again();
    const QPointer<QDialog> dialog = bring(message);
    ASSERT_NE(dialog, nullptr);
    EXPECT_TRUE(running()) << "a message stops nothing";

    key(Qt::Key_F5, dialog);
    if (message.tells) {
      EXPECT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; })) << "F5 is lost in it";
      key(Qt::Key_F5, dialog);
      EXPECT_TRUE(eventually([&] { return running(); }));
    }
    EXPECT_TRUE(dialog && dialog->isVisible());
    if (message.tells) {
      key(Qt::Key_S, dialog, Qt::ControlModifier);
      EXPECT_TRUE(eventually([&] { return window.findChild<QDialog*>(QStringLiteral("save_csv_dialog")); }))
          << "Ctrl+S is lost in it";
      delete window.findChild<QDialog*>(QStringLiteral("save_csv_dialog"));
      ASSERT_TRUE(bring_to_front(*dialog));
    }
    EXPECT_TRUE(running());

    const bool by_space = turn++ % 2 == 0;
    key(by_space ? Qt::Key_Space : Qt::Key_Escape, dialog);
    ASSERT_TRUE(eventually([&] { return stopped(); })) << (by_space ? "Space" : "Esc") << " does not stop";
    EXPECT_TRUE(dialog && dialog->isVisible()) << "the key did more than stop";
    key(by_space ? Qt::Key_Escape : Qt::Key_Space, dialog);  // stopped twice changes nothing
    EXPECT_TRUE(stopped());
    clear();
  }
}

TEST_F(Messages, AreClosedByEscBeforeAStart) {
  open_and_wait();
  for (const Message& message : all()) {
    SCOPED_TRACE(message.name);
    const std::string_view name = message.name;
    if (name == "save_csv_dialog" || name == "experiment_editor") continue;  // nothing to save yet; it asks first
    const QPointer<QDialog> dialog = bring(message);
    ASSERT_NE(dialog, nullptr);
    key(Qt::Key_Escape, dialog);
    EXPECT_TRUE(eventually([&] { return !dialog || !dialog->isVisible(); })) << "Esc does not close it";
    EXPECT_EQ(live().phase(), app::Phase::ready) << "Esc has done more than close it";
    clear();
  }
}

}  // namespace
}  // namespace skein::ui::test
