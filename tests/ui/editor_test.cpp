// The experiment editor: errors where they are, fields that write into the text, and nothing wrong is saved.
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QTextBlock>
#include <cmath>

#include "operator.h"
#include "ui/experiment_editor.h"
#include "ui/toml_text.h"

namespace skein::ui::test {
namespace {

class Editor : public Operator {
 protected:
  void open_editor(const char* action = "edit_experiment") {
    find<QAction>(action)->trigger();
    editor = window.findChild<ExperimentEditor*>();
    ASSERT_NE(editor, nullptr);
    ASSERT_TRUE(QTest::qWaitForWindowExposed(editor));
    text = editor->findChild<TomlText*>(QStringLiteral("editor_text"));
  }
  QPushButton& button(const char* name) { return *editor->findChild<QPushButton*>(QString::fromLatin1(name)); }
  /// Robots that stand: then Space is a blank.
  void stand() {
    start();
    key(Qt::Key_Space);
    ASSERT_TRUE(eventually([&] { return stopped(); }));
  }
  ExperimentEditor* editor = nullptr;
  TomlText* text = nullptr;
  QTemporaryDir dir;
};

TEST_F(Editor, MarksWhatIsWrongAndSavesNoneOfIt) {
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
  EXPECT_FALSE(editor->save(file).isEmpty());
  EXPECT_FALSE(QFile::exists(file));
  EXPECT_FALSE(button("editor_save_as").isEnabled());
  emit list->itemActivated(list->item(1));
  EXPECT_EQ(text->textCursor().block().text(), QStringLiteral("frobnicate = 1"));
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
  field->selectAll();
  QTest::keyClicks(field, QStringLiteral("0.09"));
  QTest::keyClick(field, Qt::Key_Tab);
  QString expected = before;
  expected.replace(QStringLiteral("v_max = 0.1\n"), QStringLiteral("v_max = 0.09\n"));
  EXPECT_EQ(editor->text(), expected) << "comments and order are the operator's";
  EXPECT_TRUE(editor->is_valid());
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

TEST_F(Editor, WritesDownPresentGainsAndMoves) {
  start();
  window.set_speed(10.0);
  find<QDoubleSpinBox>("spin_k_xx")->setValue(0.004);
  ASSERT_TRUE(eventually([&] { return std::abs(record().k_xx - 0.004) < 1e-12; }));
  window.set_speed(1.0);
  drag(robot(1), floor(0.3, 0.1));
  const core::Pose put = moved(1);
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  open_editor("edit_present");
  ASSERT_TRUE(editor->is_valid()) << editor->text().toStdString();
  const auto experiment = app::parse_experiment(editor->text().toStdString(), "present.toml");
  ASSERT_TRUE(experiment.has_value());
  EXPECT_NEAR(experiment->controller.gains.k_xx.largest(), 0.004, 1e-12);
  const auto mine = std::find_if(experiment->perturbations.begin(), experiment->perturbations.end(),
                                 [](const app::Perturbation& p) { return p.robot == 1 && p.t < 17.0; });
  ASSERT_NE(mine, experiment->perturbations.end());
  for (const auto& row : live().history().rows())
    if (std::abs(row->t - mine->t) < 1e-9) {
      EXPECT_NEAR(row->robots[1].truth.x, put.x, 0.01);
    }
}

}  // namespace
}  // namespace skein::ui::test
