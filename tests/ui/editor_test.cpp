// The experiment editor: errors where they are, fields that write into the text, and nothing wrong is saved.
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QMessageBox>
#include <QPointer>
#include <QRegularExpression>
#include <QTextBlock>
#include <cmath>

#include "large_experiment.h"
#include "operator.h"
#include "tests/app/rows.h"
#include "ui/editor/editor_form.h"
#include "ui/editor/experiment_editor.h"
#include "ui/editor/toml_text.h"
#include "ui/gains/gains_panel.h"

namespace skein::ui::test {
namespace {

class Editor : public Operator {
 protected:
  void open_editor(const char* action = "edit_experiment") {
    find<QAction>(action)->trigger();
    editor = window.findChild<ExperimentEditor*>();
    ASSERT_NE(editor, nullptr);
    ASSERT_TRUE(QTest::qWaitForWindowExposed(editor));
    ASSERT_TRUE(bring_to_front(*editor));
    text = editor->findChild<TomlText*>(QStringLiteral("editor_text"));
  }
  QPushButton& button(const char* name) { return *editor->findChild<QPushButton*>(QString::fromLatin1(name)); }
  /// Robots that stand: then Space is a blank.
  void stand() {
    start();
    key(Qt::Key_Space);
    ASSERT_TRUE(eventually([&] { return stopped(); }));
  }
  ExperimentEditor* find_editor() { return window.findChild<ExperimentEditor*>(); }
  void write(const QString& what) {
    QFile out(file);
    ASSERT_TRUE(out.open(QIODevice::WriteOnly));
    out.write(what.toUtf8());
  }
  /// The paper's experiment from a file, in the window and in the editor.
  void open_shared() {
    write(paper);
    window.open_file(file);
    ASSERT_TRUE(eventually([&] { return live().file() == file && live().is_open() && live().latest() != nullptr; }));
    open_editor();
  }
  ExperimentEditor* editor = nullptr;
  TomlText* text = nullptr;
  QTemporaryDir dir;
  const QString file = dir.filePath(QStringLiteral("shared.toml"));
  const QString paper = QString::fromStdString(app::paper_experiment().source);
};

TEST_F(Editor, SaysItsVerdictInTheColoursOfThePaletteThatIsChosenWhileItIsOpen) {
  window.set_theme(Theme::light);  // whatever a test before it has stored
  stand();
  open_editor();
  const auto* verdict = editor->findChild<QLabel*>(QStringLiteral("editor_verdict"));
  const auto says = [&](const char* text, const QColor& colour) {
    return verdict->text().contains(QLatin1String(text)) && verdict->text().contains(colour.name());
  };
  text->setPlainText(QStringLiteral("rate = -3\n"));
  ASSERT_TRUE(eventually([&] { return says("1 problem:", colours(palette(Theme::light)).alarm); }))
      << verdict->text().toStdString();
  window.set_theme(Theme::dark);
  EXPECT_TRUE(eventually([&] { return says("1 problem:", colours(palette(Theme::dark)).alarm); }))
      << verdict->text().toStdString();
  window.set_theme(Theme::light);
}

TEST_F(Editor, TakesKeysAtOnce) {
  stand();
  open_editor();
  ASSERT_TRUE(eventually([&] { return text->hasFocus(); }));
  const QString before = text->toPlainText();
  QTest::keyClicks(editor->focusWidget(), QStringLiteral("# mine"));
  EXPECT_EQ(text->toPlainText(), QStringLiteral("# mine") + before);
}

TEST_F(Editor, MarksWhatIsWrongAndRunsNoneOfIt) {
  stand();
  open_editor();
  EXPECT_TRUE(editor->is_valid());
  EXPECT_TRUE(button("editor_save_as").isEnabled());
  QString wrong = editor->text();
  wrong.replace(QStringLiteral("duration = 84.0"), QStringLiteral("duration = -84.0"));
  wrong.replace(QStringLiteral("gamma = 4.0"), QStringLiteral("gamma = 4.0\nfrobnicate = 1"));
  text->setPlainText(wrong);
  ASSERT_TRUE(eventually([&] { return text->marked() == 2; })) << text->marked();
  auto* list = editor->findChild<QListWidget*>(QStringLiteral("editor_problems"));
  ASSERT_EQ(list->count(), 2);
  EXPECT_TRUE(list->item(0)->text().contains(QStringLiteral("duration"))) << list->item(0)->text().toStdString();
  EXPECT_TRUE(list->item(1)->text().contains(QStringLiteral("frobnicate")));
  const QString file = dir.filePath(QStringLiteral("wrong.toml"));
  EXPECT_FALSE(button("editor_open").isEnabled());
  EXPECT_TRUE(button("editor_save_as").isEnabled()) << "a text that is not finished can be kept";
  EXPECT_EQ(editor->save(file), QString());
  EXPECT_TRUE(QFile::exists(file));
  emit list->itemActivated(list->item(1));
  EXPECT_EQ(text->textCursor().block().text(), QStringLiteral("frobnicate = 1"));
}

TEST_F(Editor, ChecksALargeExperimentWhileTheWindowGoesOn) {
  start();
  open_editor();
  EXPECT_FALSE(editor->is_checking()) << "the control: a small one is checked at once";
  editor->edit(timetables_of_64_robots(), {});
  EXPECT_TRUE(editor->is_checking());
  EXPECT_EQ(editor->findChild<QLineEdit*>(QStringLiteral("form_duration"))->text(), QStringLiteral("84.0"))
      << "the form is filled when the text has been read";
  EXPECT_FALSE(editor->is_valid()) << "not yet known";
  EXPECT_FALSE(button("editor_open").isEnabled());
  ASSERT_TRUE(eventually([&] { return !editor->is_checking(); }));
  EXPECT_TRUE(editor->is_valid());
  EXPECT_TRUE(button("editor_open").isEnabled());
  EXPECT_EQ(editor->findChild<QLineEdit*>(QStringLiteral("form_duration"))->text(), QStringLiteral("600"));
  EXPECT_EQ(editor->save(dir.filePath(QStringLiteral("large.toml"))), QString());
}

TEST_F(Editor, TakesBlanksOnceNothingMoves) {
  stand();
  open_editor();
  text->setFocus();
  ASSERT_TRUE(eventually([&] { return text->hasFocus(); }));
  text->moveCursor(QTextCursor::Start);
  for (const Qt::Key pressed : {Qt::Key_A, Qt::Key_Space, Qt::Key_B}) key(pressed, editor);
  EXPECT_TRUE(editor->text().toLower().startsWith(QStringLiteral("a b")));
}

TEST_F(Editor, StopsWithSpaceWhileARunIsOn) {
  start();
  open_editor();
  text->setFocus();
  ASSERT_TRUE(eventually([&] { return text->hasFocus(); }));
  const QString before = editor->text();
  key(Qt::Key_Space, editor);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  EXPECT_EQ(editor->text(), before);
}

TEST_F(Editor, WritesFieldsIntoTheTextAndLeavesTheRest) {
  stand();
  open_editor();
  const QString before = editor->text();
  auto* field = editor->findChild<QLineEdit*>(QStringLiteral("form_controller.v_max"));
  ASSERT_NE(field, nullptr);
  EXPECT_EQ(field->text(), QStringLiteral("0.1"));
  field->setFocus();
  ASSERT_TRUE(eventually([&] { return field->hasFocus(); }));
  field->selectAll();
  QTest::keyClicks(field, QStringLiteral("0.09"));
  QTest::keyClick(field, Qt::Key_Tab);
  QString expected = before;
  expected.replace(QStringLiteral("v_max = 0.1\n"), QStringLiteral("v_max = 0.09\n"));
  EXPECT_EQ(editor->text().toStdString(), expected.toStdString()) << "comments and order are the operator's";
  EXPECT_TRUE(eventually([&] { return editor->is_valid(); }));
  text->undo();
  EXPECT_EQ(editor->text(), before);
}

TEST_F(Editor, SavesAndOpensInTheWindow) {
  stand();
  open_editor();
  QString changed = editor->text();
  changed.replace(QStringLiteral("name = \"platoon\""), QStringLiteral("name = \"mine\""));
  text->setPlainText(changed);
  ASSERT_TRUE(editor->save(dir.filePath(QStringLiteral("mine.toml"))).isEmpty());
  QTest::mouseClick(&button("editor_open"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().experiment().name == "mine"; }));
}

TEST_F(Editor, WritesDownPresentGainsPairByPair) {
  start();
  window.set_speed(10.0);
  find<QDoubleSpinBox>("spin_k_xx")->setValue(0.004);
  ASSERT_TRUE(eventually([&] { return std::abs(record().k_xx - 0.004) < 1e-12; }));
  emit find<GainsPanel>("gains")->pair_wanted(core::GainName::k_yy, 0, 2, 0.05);
  emit find<GainsPanel>("gains")->couple_wanted(1, 3, false);
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_xx, 1, 3) == 0.0; }));
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_yy, 0, 2) == 0.05; }));
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  open_editor("edit_present");
  ASSERT_TRUE(editor->is_valid()) << editor->text().toStdString();
  const auto experiment = app::parse_experiment(editor->text().toStdString(), "present.toml");
  ASSERT_TRUE(experiment.has_value());
  const core::CouplingGains& gains = experiment->controller.gains;
  EXPECT_EQ(gains.k_xx(0, 1), 0.004);
  EXPECT_EQ(gains.k_xx(1, 3), 0.0);
  EXPECT_EQ(gains.k_yy(0, 2), 0.05);
  EXPECT_EQ(gains.k_yy(0, 1), 0.08);
}

TEST_F(Editor, WritesDownARunSoThatItHappensAgain) {
  window.set_speed(4.0);  // a paced simulation keeps its ticks, on any machine, but for its first one
  start();
  ASSERT_EQ(live().speed(), 4.0);
  drag(robot(1), robot(1) + QPoint(40, 10), Qt::ShiftModifier);
  const auto kick = last<app::events::Kick>(1);
  emit find<GainsPanel>("gains")->pair_wanted(core::GainName::k_xx, 0, 1, 0.02);
  drag(robot(2), floor(0.2, 0.1));
  moved(2);
  find<QAction>("tool_obstacle")->trigger();
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, floor(0.75, 0.6));
  last<app::events::PutObstacle>(0);
  const double t = record().t;
  ASSERT_TRUE(eventually([&] { return record().t > t + 5.0; }));
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  open_editor("edit_done");
  ASSERT_TRUE(editor->is_valid()) << editor->text().toStdString();
  const auto written = app::parse_experiment(editor->text().toStdString(), "done.toml");
  ASSERT_TRUE(written.has_value());
  EXPECT_GE(written->actions.size(), 4u);

  skein::test::Rows again;
  auto session = app::Session::open(*written, app::Session::Clock::virtual_, {false, {&again}});
  ASSERT_TRUE(session.has_value());
  (*session)->run([&] { return again.rows.empty() || again.rows.back().t < record().t + 1.0; });
  bool kicked = false;
  for (const auto& row : live().history().rows()) {
    if (row->phase != app::Phase::running) continue;
    const auto k = static_cast<std::size_t>(row->tick);
    ASSERT_LT(k, again.rows.size());
    ASSERT_EQ(again.rows[k].tick, row->tick);
    kicked = kicked || again.rows[k].events.contains<app::events::Kick>(kick.robot);
    EXPECT_EQ(again.rows[k].pair_gain(core::GainName::k_xx, 0, 1), row->pair_gain(core::GainName::k_xx, 0, 1)) << k;
    for (std::size_t i = 0; i < 4; ++i) {
      const core::Pose &a = again.rows[k].robots[i].truth, &b = row->robots[i].truth;
      ASSERT_LT(std::hypot(a.x - b.x, a.y - b.y), 1e-3) << "robot " << i + 1 << " at t = " << row->t;
    }
  }
  EXPECT_TRUE(kicked);
}

TEST_F(Editor, AsksBeforeChangesAreLost) {
  stand();
  open_editor();
  const QPointer<ExperimentEditor> open = editor;
  editor->close();
  ASSERT_TRUE(eventually([&] { return !open; })) << "nothing was changed: nothing is asked";
  open_editor();
  text->setPlainText(editor->text() + QStringLiteral("\n# mine\n"));
  editor->close();
  auto* question = editor->findChild<QMessageBox*>(QStringLiteral("editor_close_dialog"));
  ASSERT_NE(question, nullptr);
  EXPECT_FALSE(question->isModal()) << "nobody could click STOP beside it";
  EXPECT_TRUE(editor->isVisible());
  window.close();
  QTest::qWait(50);
  EXPECT_TRUE(window.isVisible()) << "the window went, and the changes with it";
}

TEST_F(Editor, KeepsAnUnfinishedTextInItsFile) {
  stand();
  open_shared();
  const QString unfinished = paper + QStringLiteral("\n[[perturb]\n");
  text->setPlainText(unfinished);
  ASSERT_TRUE(eventually([&] { return text->marked() == 1; }));
  QTest::mouseClick(&button("editor_save"), Qt::LeftButton);
  const QPointer<ExperimentEditor> open = editor;
  editor->close();
  ASSERT_TRUE(eventually([&] { return !open; })) << "it is saved: nothing is asked";
  EXPECT_EQ(live().experiment().source, paper.toStdString()) << "what can be run is still open";
  window.open_file(file);
  ASSERT_TRUE(eventually([&] { return (editor = find_editor()) != nullptr; }));
  EXPECT_EQ(editor->text().toStdString(), unfinished.toStdString());
  EXPECT_FALSE(editor->is_valid());
}

TEST_F(Editor, OffersATextThatNobodySavedWhenTheFileIsOpenedAgain) {
  stand();
  open_shared();
  const QString unfinished = paper + QStringLiteral("\n[[perturb]\n");
  text->setPlainText(unfinished);
  ASSERT_TRUE(eventually([&] { return text->marked() == 1; }));
  delete editor;  // as when the program is killed: nobody is asked
  open_editor();
  EXPECT_EQ(editor->text().toStdString(), paper.toStdString()) << "what the file has, until it is said otherwise";
  auto* offer = editor->findChild<QWidget*>(QStringLiteral("editor_draft"));
  ASSERT_NE(offer, nullptr);
  ASSERT_TRUE(offer->isVisible());
  QTest::mouseClick(&button("editor_draft_use"), Qt::LeftButton);
  EXPECT_EQ(editor->text().toStdString(), unfinished.toStdString());
  EXPECT_FALSE(offer->isVisible());
  EXPECT_TRUE(editor->has_changes());
  QTest::mouseClick(&button("editor_save"), Qt::LeftButton);
  delete editor;
  open_editor();
  EXPECT_FALSE(editor->findChild<QWidget*>(QStringLiteral("editor_draft"))->isVisible()) << "it is saved by now";

  text->setPlainText(unfinished);
  ASSERT_TRUE(eventually([&] { return text->marked() == 1; }));
  delete editor;
  open_editor();
  ASSERT_TRUE(editor->findChild<QWidget*>(QStringLiteral("editor_draft"))->isVisible());
  QTest::mouseClick(&button("editor_draft_forget"), Qt::LeftButton);
  delete editor;
  open_editor();
  EXPECT_FALSE(editor->findChild<QWidget*>(QStringLiteral("editor_draft"))->isVisible()) << "nobody wants it";
}

TEST_F(Editor, AsksBeforeItOverwritesWhatSomebodyElseWrote) {
  stand();
  open_shared();
  text->setPlainText(paper + QStringLiteral("\n# mine\n"));
  write(paper + QStringLiteral("\n# theirs\n"));
  QTest::mouseClick(&button("editor_save"), Qt::LeftButton);
  auto* question = editor->findChild<QMessageBox*>(QStringLiteral("editor_overwrite_dialog"));
  ASSERT_NE(question, nullptr);
  QFile now(file);
  ASSERT_TRUE(now.open(QIODevice::ReadOnly));
  EXPECT_TRUE(now.readAll().contains("# theirs")) << "it is overwritten";
  EXPECT_TRUE(question->text().contains(QStringLiteral("by another program"))) << question->text().toStdString();
}

TEST_F(Editor, TellsWhatSetChangedFromWhatSomebodyElseWrote) {
  write(paper);
  const auto changed = app::load_experiment(file.toStdString(), {"duration=7", "controller.k_y=9"});
  ASSERT_TRUE(changed) << changed.error().front().message();
  open_and_wait(*changed);
  window.set_experiment_file(file);
  open_editor();
  EXPECT_FALSE(editor->has_changes()) << "nobody has typed anything";
  const auto question = [&] { return editor->findChild<QMessageBox*>(QStringLiteral("editor_overwrite_dialog")); };
  QTest::mouseClick(&button("editor_save"), Qt::LeftButton);
  ASSERT_NE(question(), nullptr);
  EXPECT_FALSE(question()->text().contains(QStringLiteral("another program"))) << question()->text().toStdString();
  for (const char* said : {"--set", "duration", "controller.k_y"})
    EXPECT_TRUE(question()->text().contains(QLatin1String(said))) << said << ": " << question()->text().toStdString();
  delete question();

  write(paper + QStringLiteral("\n# theirs\n"));  // since the window opened it
  delete editor;
  open_editor();
  QTest::mouseClick(&button("editor_save"), Qt::LeftButton);
  ASSERT_NE(question(), nullptr);
  EXPECT_TRUE(question()->text().contains(QStringLiteral("by another program"))) << question()->text().toStdString();
  for (QAbstractButton* answer : question()->buttons())
    if (answer->text() == QStringLiteral("Overwrite it")) answer->click();
  EXPECT_FALSE(editor->text().contains(QStringLiteral("theirs")));
  delete question();
  QTest::mouseClick(&button("editor_save"), Qt::LeftButton);
  EXPECT_EQ(question(), nullptr) << "the file has it by now";
}

TEST_F(Editor, AFileThatWasBrokenMeanwhileIsNotSaidToHaveChangedSinceItWasRead) {
  stand();
  open_shared();
  delete editor;
  write(paper + QStringLiteral("\nfrobnicate = 1\n"));
  window.open_file(file);
  ASSERT_TRUE(eventually([&] { return (editor = find_editor()) != nullptr; }));
  text = editor->findChild<TomlText*>(QStringLiteral("editor_text"));
  text->setPlainText(paper);
  QTest::mouseClick(&button("editor_save"), Qt::LeftButton);
  EXPECT_EQ(editor->findChild<QMessageBox*>(QStringLiteral("editor_overwrite_dialog")), nullptr);
}

TEST(EditorForm, ShowsTheGainsOfAFileThatHasNone) {
  EditorForm form;
  form.show_values(std::vector<std::optional<std::string>>(form.keys().size()));
  for (const auto& [name, value] : {std::pair("k_xx", "0.008"), {"k_tt", "0.025"}, {"k_yy", "0.08"}}) {
    const auto fields =
        form.findChildren<QLineEdit*>(QRegularExpression(QStringLiteral(".*%1$").arg(QLatin1String(name))));
    ASSERT_EQ(fields.size(), 1) << name;
    EXPECT_EQ(fields.front()->placeholderText(), QLatin1String(value)) << name;
  }
}

}  // namespace
}  // namespace skein::ui::test
