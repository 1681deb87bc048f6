// The gains panel: undo, presets, the form of the couplings, the schedule. And what can be done with one robot.
#include <QAbstractItemView>
#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDockWidget>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QMenu>
#include <QPointer>
#include <QRegularExpression>
#include <QSlider>
#include <QTabWidget>
#include <QToolButton>
#include <QToolTip>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string_view>

#include "operator.h"
#include "tests/has_python.h"
#include "ui/gains/gain_presets.h"
#include "ui/gains/gain_slider.h"
#include "ui/gains/gains_panel.h"
#include "ui/gains/parameter_panel.h"
#include "ui/gains/schedule_editor.h"
#include "ui/robots/robots_model.h"

namespace skein::ui::test {
namespace {

class Gains : public Operator {
 protected:
  double spin(const char* name) { return find<QDoubleSpinBox>(name)->value(); }
  void set(const char* name, double value) {
    find<QDoubleSpinBox>(name)->setValue(value);
    if (std::string_view(name) == "gain_ramp") return;
    ASSERT_TRUE(eventually([&] { return find<QToolButton>("undo_gain")->isEnabled(); }));
  }
  void use_preset(const QString& name) {
    QMenu* menu = find<QToolButton>("gain_presets")->menu();
    emit menu->aboutToShow();
    for (QAction* action : menu->actions())
      if (action->text() == name) return action->trigger();
    ADD_FAILURE() << "no preset " << name.toStdString();
  }
  void open_before_start() {
    window.resize(1280, 800);
    window.show();
    window.activateWindow();
    window.open(app::paper_experiment(), false);
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
    ASSERT_TRUE(eventually([&] { return find<QComboBox>("coupling")->isEnabled(); }));
  }
};

TEST_F(Gains, AreUndoneAndRedone) {
  start();
  set("spin_k_xx", 0.012);
  ASSERT_TRUE(eventually([&] { return std::abs(record().k_xx - 0.012) < 1e-6; }));
  QTest::mouseClick(find<QToolButton>("undo_gain"), Qt::LeftButton);
  EXPECT_EQ(spin("spin_k_xx"), 0.008);
  ASSERT_TRUE(eventually([&] { return std::abs(record().k_xx - 0.008) < 1e-6; }));
  QTest::mouseClick(find<QToolButton>("redo_gain"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return std::abs(record().k_xx - 0.012) < 1e-6; }));
  EXPECT_FALSE(find<QToolButton>("redo_gain")->isEnabled());
}

/// A menu that is disabled while it is open took every key and click, and did not close.
TEST_F(Gains, AMenuThatIsOpenWhenTheRunEndsIsClosed) {
  start();
  auto* presets = find<QToolButton>("gain_presets");
  presets->menu()->popup(presets->mapToGlobal(presets->rect().bottomLeft()));
  ASSERT_TRUE(eventually([&] { return QApplication::activePopupWidget() == presets->menu(); }));
  window.stop();
  ASSERT_TRUE(eventually([&] { return !presets->isEnabled(); })) << "nothing can be set after the end";
  EXPECT_EQ(QApplication::activePopupWidget(), nullptr);
}

/// The panel is disabled where nothing can be set. Its dialog was disabled with it: no key and no button closed it.
TEST_F(Gains, TheDialogThatNamesAPresetOutlivesTheRun) {
  start();
  emit find<QToolButton>("gain_presets")->menu()->aboutToShow();
  find<QAction>("keep_preset")->trigger();
  const QPointer<QDialog> dialog = find<QDialog>("preset_dialog");
  ASSERT_TRUE(QTest::qWaitForWindowExposed(dialog));
  const auto alone =
      app::parse_experiment(app::paper_experiment().source, "platoon.toml", {"robot=[{tag=1}]", "perturb=[]"});
  ASSERT_TRUE(alone);
  window.open(*alone, false);
  ASSERT_TRUE(
      eventually([&] { return live().experiment().robots.size() == 1 && !find<GainsPanel>("gains")->isEnabled(); }));
  EXPECT_TRUE(dialog->isEnabled());
  ASSERT_TRUE(bring_to_front(*dialog));
  key(Qt::Key_W, dialog, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return !dialog; })) << "Ctrl+W does not close it";
}

TEST_F(Gains, ChangeWithinTheTimeThatIsAskedFor) {
  start();
  set("gain_ramp", 20.0);
  set("spin_k_yy", 0.04);
  ASSERT_TRUE(eventually([&] { return record().k_yy < 0.0795; }));
  EXPECT_GT(record().k_yy, 0.05) << "at the bounded rate it would be there in a third of a second";
  EXPECT_TRUE(find<QLabel>("delay_margin")->text().contains(QStringLiteral("margin 55 ms")))
      << find<QLabel>("delay_margin")->text().toStdString();
  set("gain_ramp", 0.0);
  EXPECT_EQ(find<QDoubleSpinBox>("gain_ramp")->text(), QStringLiteral("as fast as is safe"));
  set("spin_k_yy", 0.03);
  ASSERT_TRUE(eventually([&] { return record().k_yy == 0.03; }));
  const QStringList events = saved_events();
  EXPECT_EQ(count(events, "gain k_yy 0.08 -> 0.04 ramp=20"), 1) << events.join(QLatin1Char('|')).toStdString();
  EXPECT_EQ(count(events, "gain k_yy 0.04 -> 0.03"), 1);
}

TEST_F(Gains, ComeAsPresetsWhichAreOneStepToUndo) {
  start();
  use_preset(QStringLiteral("Uncoupled"));
  for (const char* name : {"spin_k_xx", "spin_k_tt", "spin_k_yy"}) EXPECT_EQ(spin(name), 0.0) << name;
  ASSERT_TRUE(eventually([&] { return record().k_xx == 0.0 && record().k_yy == 0.0; }));
  QTest::mouseClick(find<QToolButton>("undo_gain"), Qt::LeftButton);
  EXPECT_EQ(spin("spin_k_xx"), 0.008);
  EXPECT_EQ(spin("spin_k_tt"), 0.025);
  EXPECT_EQ(spin("spin_k_yy"), 0.08);
}

TEST_F(Gains, KeepThePresetsOfTheirOwn) {
  keep_gain_preset({QStringLiteral("Mine / 1"), {0.001, 0.002, 0.003}, true});
  start();
  use_preset(QStringLiteral("Mine - 1"));
  QMenu* menu = find<QToolButton>("gain_presets")->menu();
  for (int k = 0; k < 3; ++k) emit menu->aboutToShow();
  EXPECT_EQ(menu->findChildren<QMenu*>().size(), 1) << "the submenus of earlier openings are left";
  EXPECT_EQ(spin("spin_k_tt"), 0.002);
  forget_gain_preset(QStringLiteral("Mine - 1"));
  for (const GainPreset& preset : gain_presets(live().experiment())) EXPECT_FALSE(preset.own);
}

TEST_F(Gains, SwitchTheFormOfTheCouplingsBeforeTheStart) {
  open_before_start();
  auto* box = find<QComboBox>("coupling");
  box->setCurrentIndex(1);
  emit box->activated(1);
  ASSERT_TRUE(eventually([&] {
    return live().is_open() && live().latest() && live().experiment().controller.coupling == core::Coupling::bounded;
  }));
  EXPECT_EQ(box->currentIndex(), 1);
  EXPECT_NE(live().experiment().source.find("bounded"), std::string::npos) << "the record must say so";
  window.go();
  ASSERT_TRUE(eventually([&] { return running(); }));
  EXPECT_TRUE(eventually([&] { return !box->isEnabled(); })) << "a law does not change in mid-run";
}

TEST_F(Gains, FollowAScheduleThatWasMadeInTheWindow) {
  open_before_start();
  find<QTabWidget>("gain_tabs")->setCurrentWidget(find("schedule"));
  QTest::mouseClick(find<QPushButton>("schedule_add"), Qt::LeftButton);
  auto* table = find<QAbstractItemView>("schedule_table");
  ASSERT_EQ(table->model()->rowCount(), 1);
  const auto put = [&](int column, const QString& text) {
    return table->model()->setData(table->model()->index(0, column), text, Qt::EditRole);
  };
  EXPECT_TRUE(put(ScheduleModel::t, QStringLiteral("0.4")));
  EXPECT_TRUE(put(ScheduleModel::k_xx, QStringLiteral("0.002")));
  EXPECT_TRUE(put(ScheduleModel::k_tt, QString()));
  EXPECT_TRUE(put(ScheduleModel::k_yy, QString()));
  EXPECT_TRUE(put(ScheduleModel::ramp, QStringLiteral("0.2")));
  EXPECT_FALSE(put(ScheduleModel::t, QStringLiteral("soon")));
  EXPECT_FALSE(put(ScheduleModel::ramp, QString()));
  QTest::mouseClick(find<QPushButton>("schedule_apply"), Qt::LeftButton);
  ASSERT_TRUE(
      eventually([&] { return live().is_open() && live().latest() && live().experiment().gain_changes.size() == 1; }));
  EXPECT_EQ(table->model()->rowCount(), 1);
  ASSERT_TRUE(eventually([&] { return find<QPushButton>("go")->isEnabled(); }));
  window.go();
  ASSERT_TRUE(eventually([&] { return running() && record().t > 0.8; }));
  EXPECT_NEAR(record().k_xx, 0.002, 1e-12);
  EXPECT_NEAR(record().k_tt, 0.025, 1e-12);
  EXPECT_EQ(count(saved_events(), "schedule k_xx 0.008 -> 0.002"), 1);
}

TEST_F(Gains, OfAnotherLawAreTheParametersThatItDeclares) {
  const auto experiment = app::parse_experiment(app::paper_experiment().source, "leader.toml",
                                                {"controller.kind=\"leader_follower\"", "duration=60"});
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  start(*experiment);
  EXPECT_FALSE(find("slider_k_xx")->isVisible()) << "it would change nothing";
  ASSERT_TRUE(eventually([&] { return window.findChild<QSlider*>(QStringLiteral("slider_alpha_l")) != nullptr; }));
  EXPECT_EQ(spin("spin_alpha_l"), 0.8);
  set("spin_alpha_l", 1.5);
  ASSERT_TRUE(eventually([&] { return live().parameters()[0].value == 1.5; }));

  // Out of its range: refused in words, and the value in force is shown again.
  find<QDoubleSpinBox>("spin_ahead")->setValue(7.0);
  EXPECT_EQ(spin("spin_ahead"), 0.03);
  EXPECT_TRUE(eventually([&] {
    return find<QLabel>("alert")->text().contains(QStringLiteral("ahead: found 7, allowed: 0.005 to 0.5 m"));
  }));

  // By the keyboard, along the slider: to its end.
  auto* slider = find<QSlider>("slider_ahead");
  slider->setFocus();
  QTest::keyClick(slider, Qt::Key_End);
  ASSERT_TRUE(eventually([&] { return live().parameters()[2].value == 0.5; }));
  EXPECT_EQ(spin("spin_ahead"), 0.5);
  QTest::mouseClick(find<QToolButton>("undo_gain"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return live().parameters()[2].value == 0.03; }));
  EXPECT_EQ(spin("spin_ahead"), 0.03);
  const QStringList events = saved_events();
  EXPECT_EQ(count(events, "parameter alpha_l 0.8 -> 1.5"), 1) << events.join(QLatin1Char('|')).toStdString();
  EXPECT_EQ(count(events, "parameter ahead 0.03 -> 0.5"), 1);
  EXPECT_EQ(count(events, "parameter ahead 0.5 -> 0.03"), 1);
}

TEST(LawParameters, AreShownAsTheyAreHoweverLarge) {
  ParameterPanel panel;
  app::LawParameter stiffness;
  stiffness.name = "stiffness";
  stiffness.high = 1e8;
  stiffness.value = 5e6;
  panel.show_parameters({stiffness});
  const auto* field = panel.findChild<QDoubleSpinBox*>(QStringLiteral("spin_stiffness"));
  ASSERT_NE(field, nullptr);
  EXPECT_EQ(field->value(), 5e6);
}

TEST_F(Gains, OfALawWithoutParametersAreGoneToByTheKeyboardAllTheSame) {
  const auto experiment =
      app::parse_experiment(app::paper_experiment().source, "own.toml", {"controller.command=\"false\""});
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  ASSERT_TRUE(show_and_open(*experiment, false));
  find<QDockWidget>("gains_dock")->hide();
  key(Qt::Key_2, nullptr, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return find<QDockWidget>("gains_dock")->isVisible(); }));
}

TEST_F(Gains, OfAProcessAreTheParametersThatItDeclares) {
  if (!skein::test::has_python()) GTEST_SKIP() << "no python3";
  const QTemporaryDir dir;
  QFile law(dir.filePath(QStringLiteral("law.py")));
  ASSERT_TRUE(law.open(QIODevice::WriteOnly));
  law.write(
      "import sys\nsys.modules['numpy'] = None\nimport skein.controller\n"
      "@skein.controller.law(speed=(0.0, 'm/s', 0.0, 0.1, 'forward speed'), anything=1.0)\n"
      "def step(tick):\n"
      "    for i in range(tick.robots):\n"
      "        tick.v[i], tick.omega[i] = tick.parameters['speed'], 0.0\n"
      "skein.controller.run(step)\n");
  law.close();
  const auto experiment = app::parse_experiment(
      app::paper_experiment().source, "own.toml",
      {"controller.command=\"python3 '" + law.fileName().toStdString() + "'\"", "controller.deadline=0.02"});
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  start(*experiment);
  ASSERT_TRUE(eventually([&] { return window.findChild<QSlider*>(QStringLiteral("slider_speed")) != nullptr; }));
  EXPECT_EQ(window.findChild<QSlider*>(QStringLiteral("slider_anything")), nullptr) << "it has no range";
  EXPECT_TRUE(find<QSlider>("slider_speed")->toolTip().contains(QStringLiteral("No preview: the run has a controller")))
      << find<QSlider>("slider_speed")->toolTip().toStdString();
  auto* slider = find<QSlider>("slider_speed");
  slider->setFocus();
  QTest::keyClick(slider, Qt::Key_Right);
  EXPECT_TRUE(eventually([&] {
    return arena().scene().hint.startsWith(QStringLiteral("No preview: the run has a controller of its own"));
  })) << arena().scene().hint.toStdString();
  QTest::keyClick(slider, Qt::Key_Left);
  EXPECT_EQ(spin("spin_anything"), 1.0);
  ASSERT_TRUE(eventually([&] { return record().robots[0].law.v == 0.0; }));
  set("spin_speed", 0.05);
  ASSERT_TRUE(eventually([&] { return record().robots[0].law.v == 0.05; }));
  EXPECT_EQ(live().parameters()[0].value, 0.05);
}

TEST_F(Gains, AreSetPairByPairAndHeldAtTheLimit) {
  start();
  find<QTabWidget>("gain_tabs")->setCurrentWidget(find("pairs"));
  auto* table = find<QAbstractItemView>("pair_table");
  const auto cell = [&](int i, int j, int role = Qt::DisplayRole) { return table->model()->index(i, j).data(role); };
  ASSERT_TRUE(eventually([&] { return cell(0, 1).toString() == QStringLiteral("0.008"); }));
  ASSERT_TRUE(table->model()->setData(table->model()->index(1, 0), QStringLiteral("0.004"), Qt::EditRole));
  ASSERT_TRUE(eventually([&] { return cell(0, 1).toString() == QStringLiteral("0.004"); }));
  EXPECT_EQ(cell(1, 0), cell(0, 1)) << "(18c)";
  EXPECT_EQ(cell(2, 3).toString(), QStringLiteral("0.008"));
  EXPECT_FALSE(table->model()->setData(table->model()->index(1, 0), QStringLiteral("much"), Qt::EditRole));

  ASSERT_TRUE(table->model()->setData(table->model()->index(0, 2), QStringLiteral("5"), Qt::EditRole));
  ASSERT_TRUE(eventually([&] {
    const double held = live().gain_target(core::GainName::k_xx, 0, 2);
    return held > 0.008 && held < 0.1;
  })) << "(18) allows no such gain";
  EXPECT_TRUE(eventually([&] { return count(saved_events(), "pair_gain_held") == 1; }));

  ASSERT_TRUE(table->model()->setData(table->model()->index(1, 2), Qt::Unchecked, Qt::CheckStateRole));
  ASSERT_TRUE(eventually([&] { return cell(1, 2).toString() == QStringLiteral("off"); }));
  QTest::mouseClick(find<QToolButton>("undo_gain"), Qt::LeftButton);
  EXPECT_TRUE(eventually([&] { return cell(1, 2).toString() == QStringLiteral("0.008"); }));
}

TEST_F(Gains, OfAPairAtItsLimitSayWhichOtherGainMakesRoom) {
  app::Experiment experiment = app::paper_experiment();
  experiment.duration = 7200.0;
  experiment.perturbations.clear();
  start(experiment);
  window.set_speed(10.0);  // ramps
  find<QTabWidget>("gain_tabs")->setCurrentWidget(find("pairs"));
  auto* table = find<QAbstractItemView>("pair_table");
  const auto put = [&](core::GainName gain, int i, int j, const char* value) {
    find<QComboBox>("pair_gain")->setCurrentIndex(static_cast<int>(gain));
    ASSERT_TRUE(table->model()->setData(table->model()->index(i, j), QString::fromLatin1(value), Qt::EditRole));
  };
  const auto says = [&](const QString& text) { return eventually([&] { return logged().contains(text); }); };
  put(core::GainName::k_yy, 0, 1, "0.42");
  EXPECT_TRUE(
      says(QStringLiteral("k_yy of robots 1 and 2 is held at 0.4098, its limit: lower k_θθ of the same pair "
                          "from 0.0250 to 0.0148 to allow 0.4200")))
      << logged().toStdString();
  put(core::GainName::k_tt, 0, 1, "0.0148");
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_tt, 0, 1) == 0.0148; }));
  put(core::GainName::k_yy, 0, 1, "0.42");
  EXPECT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_yy, 0, 1) == 0.42; }));

  put(core::GainName::k_xx, 0, 1, "0.004");
  ASSERT_TRUE(eventually([&] { return live().gain_target(core::GainName::k_xx, 0, 1) == 0.004; }));
  put(core::GainName::k_xx, 0, 2, "0.034");
  EXPECT_TRUE(
      says(QStringLiteral(": lower k_xx in the other pairs of robot 1 by 0.0010 and of robot 3 by 0.0050 in "
                          "total to allow 0.0340")))
      << logged().toStdString();
  put(core::GainName::k_xx, 0, 2, "5");
  EXPECT_TRUE(says(QStringLiteral("its limit: a larger one takes a slower reference (18f)"))) << logged().toStdString();
}

TEST_F(Gains, OfManyRobotsAreShownAsTheyAreInForce) {
  std::string text =
      "[arena]\nwidth = 5.0\nheight = 4.0\n[controller.gains]\nk_xx = 0.000452\nk_tt = 0.0014\nk_yy = "
      "0.0045\n[reference]\npath = { shape = 'rounded_rectangle', width = 4.0, height = 3.0, radius = 0.3 "
      "}\n";
  for (int i = 0; i < 64; ++i) text += "[[robot]]\ntag = " + std::to_string(i) + "\n";
  const auto many = app::parse_experiment(text, "many.toml");
  ASSERT_TRUE(many) << many.error().front().message();
  open_and_wait(*many);
  EXPECT_NEAR(find<QDoubleSpinBox>("spin_k_xx")->value(), 0.000452, 1e-9) << "typed again, it would be another gain";
  EXPECT_EQ(find<QLabel>("now_k_xx")->text().toStdString(), "now 0.000452");
  auto* field = find<QDoubleSpinBox>("spin_k_xx");
  EXPECT_GE(field->width(), field->sizeHint().width()) << "it is cut off";
}

TEST_F(Gains, OfAScheduleThatWasNotAppliedAreNotShownInTheRun) {
  open_before_start();
  find<QTabWidget>("gain_tabs")->setCurrentWidget(find("schedule"));
  QTest::mouseClick(find<QPushButton>("schedule_add"), Qt::LeftButton);
  const auto* rows = find<QAbstractItemView>("schedule_table")->model();
  ASSERT_EQ(rows->rowCount(), 1);
  ASSERT_TRUE(eventually([&] { return find<QPushButton>("go")->isEnabled(); }));
  window.go();
  ASSERT_TRUE(eventually([&] { return running(); }));
  EXPECT_TRUE(eventually([&] { return rows->rowCount() == 0; })) << "a change is shown that will not come";
  EXPECT_TRUE(eventually([&] { return find<QLabel>("alert")->text().contains(QStringLiteral("not applied")); }))
      << find<QLabel>("alert")->text().toStdString();
}

TEST_F(Gains, ThatTheScheduleCannotShowAreNotLostByItsApply) {
  const auto varying = app::parse_experiment(
      "[controller]\npolicy = 'fixed'\nk_x = 0.02\nk_theta = 0.3\n[[gain_change]]\nt = 9\nk_x = [[2, 0.01]]\n",
      "varying.toml");
  ASSERT_TRUE(varying) << varying.error().front().message();
  open_and_wait(*varying);
  find<QTabWidget>("gain_tabs")->setCurrentWidget(find("schedule"));
  EXPECT_FALSE(find<QPushButton>("schedule_add")->isEnabled());
  EXPECT_TRUE(find("schedule")->toolTip().contains(QStringLiteral("edit the experiment file")));
}

TEST_F(Gains, ThatAreTypedIntoATableAndNotTakenAreSaidNotToBe) {
  open_before_start();
  const auto told = [&](QAbstractItemModel* model, int row, int column, const QString& text) {
    EXPECT_FALSE(model->setData(model->index(row, column), text, Qt::EditRole)) << text.toStdString();
    const QString alert = find<QLabel>("alert")->text();
    EXPECT_TRUE(alert.contains(QStringLiteral("found ") + text) && alert.contains(QStringLiteral("allowed: ")))
        << alert.toStdString();
  };
  auto* pairs = find<QAbstractItemView>("pair_table")->model();
  told(pairs, 0, 1, QStringLiteral("-0.1"));
  told(pairs, 0, 1, QStringLiteral("1.000.5"));
  QTest::mouseClick(find<QPushButton>("schedule_add"), Qt::LeftButton);
  auto* schedule = find<QAbstractItemView>("schedule_table")->model();
  told(schedule, 0, ScheduleModel::k_xx, QStringLiteral("-0.1"));
  told(schedule, 0, ScheduleModel::t, QStringLiteral("soon"));
  for (QAbstractItemModel* model : {pairs, schedule}) {
    EXPECT_FALSE(model->setData(model->index(0, 1), QStringLiteral("1,000"), Qt::EditRole));
    EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("1.000 or 1000")));
  }
  const auto in_force = record().k_yy;
  for (const char* name : {"spin_k_yy", "gain_ramp"}) {
    auto* field = find<QDoubleSpinBox>(name);
    const QString before = field->text();
    field->setFocus();
    ASSERT_TRUE(eventually([&] { return field->hasFocus(); }));
    field->selectAll();
    QTest::keyClicks(field, QStringLiteral("2,000"));
    key(Qt::Key_Return);
    EXPECT_EQ(field->text().toStdString(), before.toStdString()) << name;
    EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("2.000 or 2000"))) << name;
  }
  EXPECT_EQ(record().k_yy, in_force);
}

TEST_F(Gains, ThatAreBeingTypedWhenTheRunEndsAreNotShownAsInForce) {
  start();
  auto* field = find<QDoubleSpinBox>("spin_k_yy");
  field->setFocus();
  ASSERT_TRUE(eventually([&] { return field->hasFocus(); }));
  field->selectAll();
  QTest::keyClicks(field, QStringLiteral("0.01"));
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped() && !field->isEnabled(); }));
  const double in_force = live().gain_target(core::GainName::k_yy, 0, 1);
  EXPECT_TRUE(eventually([&] {
    return std::abs(field->value() - in_force) < 1e-4 && field->text().startsWith(QString::number(in_force, 'f', 2));
  })) << field->text().toStdString()
      << " is shown, " << in_force << " was in force";
}

TEST_F(Gains, AreToldWhyAScheduleCannotBe) {
  open_before_start();
  auto* panel = find<GainsPanel>("gains");
  emit panel->experiment_wanted(QStringLiteral("gain_change=[{ t = 1, k_xx = 5 }]"));
  const auto box = [&] { return window.findChild<QWidget*>(QStringLiteral("problem_dialog")); };
  ASSERT_TRUE(eventually([&] { return box() != nullptr; }));
  EXPECT_TRUE(live().experiment().gain_changes.empty());
  delete box();
}

/// A number typed into a gain's field, and what becomes of it.
class GainRoom : public Gains {
 protected:
  /// Long enough for ten times real time on any machine.
  void start_at_ten_times() {
    app::Experiment experiment = app::paper_experiment();
    experiment.duration = 7200.0;
    experiment.perturbations.clear();
    start(experiment);
    window.set_speed(10.0);  // ramps
  }
  void type(core::GainName gain, double value) { find<QDoubleSpinBox>(widget("spin_", gain))->setValue(value); }
  static const char* widget(const char* prefix, core::GainName gain) {
    static std::string name;
    name = prefix + std::string(core::word(gain));
    return name.c_str();
  }
  double target(core::GainName gain) { return live().gain_target(gain, 0, 1); }
  QString advice(core::GainName gain) {
    const auto* label = find<QLabel>(widget("advice_", gain));
    return label->isVisible() ? label->text() : QString();
  }
  qsizetype held(core::GainName gain) {
    return count(saved_events(), ("gain_held " + std::string(core::word(gain)) + " ").c_str());
  }
  /// Slider, field, value now, target and marks tell the same.
  testing::AssertionResult agrees(core::GainName gain) {
    const auto* slider = static_cast<LimitSlider*>(find<QSlider>(widget("slider_", gain)));
    const double limit = live().gain_limit(gain), field = find<QDoubleSpinBox>(widget("spin_", gain))->value();
    const double knob = static_cast<double>(slider->value()) / LimitSlider::steps;
    const double top = slider->limit_mark() > 0.0 ? limit / slider->limit_mark() : 0.0;
    const auto now = find<QLabel>(widget("now_", gain))->text();
    const auto border = find<QLabel>(widget("limit_", gain))->text();
    const int places = find<QDoubleSpinBox>(widget("spin_", gain))->decimals();
    const double per_unit = std::pow(10.0, places);
    const QString rounded_down = QString::number(std::floor(limit * per_unit + 1e-6) / per_unit, 'f', places);
    const auto result = testing::AssertionFailure()
                        << core::word(gain) << ": target " << target(gain) << ", field " << field << ", knob " << knob
                        << " of " << top << ", now " << now.toStdString() << " at " << slider->now_mark() << ", limit "
                        << limit << ": " << border.toStdString() << " at " << slider->limit_mark();
    if (std::abs(field - target(gain)) > 0.51 / per_unit) return result;
    if (now != QStringLiteral("now %1").arg(field, 0, 'f', places)) return result;
    if (border != QStringLiteral("limit ") + rounded_down) return result;
    if (slider->limit_mark() <= 0.0 || slider->limit_mark() > 1.0) return result;
    if (std::abs(knob * top - target(gain)) > 0.6 * top / LimitSlider::steps) return result;
    if (std::abs(slider->now_mark() * top - target(gain)) > 1e-6) return result;
    if (target(gain) > limit + 1e-9) return result;
    return testing::AssertionSuccess();
  }
  void drag_knob(core::GainName gain, double share) {
    auto* slider = find<QSlider>(widget("slider_", gain));
    const auto at = [&](double where) {
      return QPoint(static_cast<int>(std::lround(7.5 + where * (slider->width() - 15))), slider->height() / 2);
    };
    const double from = static_cast<double>(slider->value()) / slider->maximum();
    QTest::mousePress(slider, Qt::LeftButton, {}, at(from));
    for (int k = 1; k <= 4; ++k) QTest::mouseMove(slider, at(from + (share - from) * k / 4));
    QTest::mouseRelease(slider, Qt::LeftButton, {}, at(share));
  }
};

TEST_F(GainRoom, IsMadeByTheOtherGainAndTheNumberThatTheWindowGives) {
  using core::GainName;
  start_at_ten_times();
  std::mt19937_64 any(20101208);
  static const QRegularExpression way(QStringLiteral("lower (k_\\S+) from (\\S+) to (\\S+) to allow (\\S+)$"));
  int rounds = 0;
  for (int round = 0; round < 8; ++round) {
    const GainName name = round % 2 == 0 ? GainName::k_yy : GainName::k_tt;
    const GainName other = round % 2 == 0 ? GainName::k_tt : GainName::k_yy;
    const double all = live().gain_limit(name) + target(other);  // of the two together
    const auto share = [&] { return std::uniform_real_distribution(0.2, 0.9)(any); };
    const double given = std::round(all * share() * 1e4) / 1e4, wanted = std::ceil(all * share() * 1e4) / 1e4;
    type(name, 0.0);
    ASSERT_TRUE(eventually([&] { return target(name) == 0.0; }));
    type(other, given);
    ASSERT_TRUE(eventually([&] { return std::abs(target(other) - given) < 1e-9; }));
    ASSERT_TRUE(eventually([&] { return agrees(name); })) << agrees(name).message();
    if (wanted <= live().gain_limit(name)) continue;
    ++rounds;
    type(name, wanted);
    EXPECT_TRUE(advice(name).contains(QStringLiteral("cannot be more than"))) << "nothing is said before it is asked";
    ASSERT_TRUE(eventually([&] { return std::abs(target(name) - live().gain_limit(name)) < 1e-9; }));
    ASSERT_TRUE(eventually([&] { return agrees(name); })) << agrees(name).message();
    const QRegularExpressionMatch told = way.match(advice(name));
    ASSERT_TRUE(told.hasMatch()) << advice(name).toStdString();
    EXPECT_EQ(told.captured(1), other == GainName::k_tt ? QStringLiteral("k_\u03b8\u03b8") : QStringLiteral("k_yy"));
    EXPECT_NEAR(told.captured(2).toDouble(), given, 0.51e-4);
    EXPECT_NEAR(told.captured(4).toDouble(), wanted, 1e-9);
    EXPECT_TRUE(find<QSlider>(widget("slider_", name))->toolTip().contains(advice(name)));
    EXPECT_TRUE(eventually([&] { return find<QLabel>("alert")->text().contains(told.captured()); }))
        << find<QLabel>("alert")->text().toStdString();
    const qsizetype before = held(name);
    type(other, told.captured(3).toDouble());
    ASSERT_TRUE(eventually([&] { return target(other) == told.captured(3).toDouble(); }));
    EXPECT_TRUE(eventually([&] { return advice(name).isEmpty(); }))
        << "there is room now: " << advice(name).toStdString();
    type(name, wanted);
    EXPECT_TRUE(eventually([&] { return std::abs(target(name) - wanted) < 1e-12; }))
        << target(name) << " of " << wanted;
    EXPECT_EQ(held(name), before) << "the number that was given is not enough";
  }
  EXPECT_GE(rounds, 3) << "there was room all the time";
}

TEST_F(GainRoom, IsSaidNotToBeThereWhereNoOtherGainMakesIt) {
  using core::GainName;
  start();
  type(GainName::k_xx, 2.0 * live().gain_limit(GainName::k_xx));
  EXPECT_TRUE(eventually([&] {
    return advice(GainName::k_xx).endsWith(QStringLiteral("a larger one takes a slower reference (18f)"));
  })) << advice(GainName::k_xx).toStdString();
  const double all = live().gain_limit(GainName::k_yy) + target(GainName::k_tt);
  type(GainName::k_yy, all + 0.001);
  EXPECT_TRUE(eventually([&] {
    return advice(GainName::k_yy).contains(QStringLiteral("even k_\u03b8\u03b8 = 0 is not enough"));
  })) << advice(GainName::k_yy).toStdString();
  EXPECT_TRUE(eventually([&] { return agrees(GainName::k_yy); })) << agrees(GainName::k_yy).message();
  type(GainName::k_yy, 0.01);
  EXPECT_TRUE(eventually([&] { return advice(GainName::k_yy).isEmpty(); })) << "what is no longer asked for is advised";
}

TEST_F(GainRoom, IsShownAlikeEverywhereWhileTwoGainsAreDraggedPastTheirCommonBorderAndBack) {
  using core::GainName;
  start_at_ten_times();
  const auto expect_all_agree = [&](const char* step) {
    for (const GainName gain : core::gain_names)
      EXPECT_TRUE(eventually([&] { return agrees(gain); })) << step << ": " << agrees(gain).message();
  };
  expect_all_agree("at the start");
  const double yy = target(GainName::k_yy), tt = target(GainName::k_tt);
  drag_knob(GainName::k_tt, 1.0);
  ASSERT_TRUE(eventually([&] { return target(GainName::k_tt) > tt + 0.01; }));
  expect_all_agree("k_tt past its border");
  EXPECT_NEAR(target(GainName::k_tt), live().gain_limit(GainName::k_tt), 1e-9);
  EXPECT_NEAR(live().gain_limit(GainName::k_yy), yy, 1e-9) << "k_tt has taken all that k_yy leaves";
  drag_knob(GainName::k_yy, 1.0);
  ASSERT_TRUE(eventually([&] { return held(GainName::k_yy) == 1; }));
  expect_all_agree("k_yy past its border");
  EXPECT_FALSE(advice(GainName::k_yy).isEmpty());
  drag_knob(GainName::k_tt, 0.1);
  ASSERT_TRUE(eventually([&] { return target(GainName::k_tt) < live().gain_limit(GainName::k_tt) / 2; }));
  expect_all_agree("k_tt back");
  EXPECT_TRUE(eventually([&] { return advice(GainName::k_yy).isEmpty(); })) << advice(GainName::k_yy).toStdString();
  for (int step = 0; step < 2; ++step) {
    QTest::mouseClick(find<QToolButton>("undo_gain"), Qt::LeftButton);
    expect_all_agree("undone");
  }
}

TEST_F(Operator, HoldsOneRobotAndLetsItGo) {
  start();
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, robot(2));
  auto* hold = find<QAbstractButton>("hold_robot");
  ASSERT_TRUE(eventually([&] { return hold->isEnabled(); }));
  EXPECT_TRUE(hold->text().contains(QLatin1Char('3')));
  QTest::mouseClick(hold, Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return record().robots[2].wheels == core::WheelSpeeds{} && running(); }));
  EXPECT_NE(record().robots[0].wheels, core::WheelSpeeds{}) << "the others drive on";
  auto* table = find<QAbstractItemView>("robots");
  ASSERT_TRUE(eventually(
      [&] { return table->model()->index(2, RobotsModel::mode).data().toString() == QStringLiteral("held"); }));
  ASSERT_TRUE(eventually([&] { return hold->text().startsWith(QStringLiteral("Let")); }));
  const ModeStyle seen = arena().scene().style_of(2, colours(window.palette()));
  EXPECT_EQ(seen.name, QStringLiteral("held")) << "in the arena as in the table";
  QHelpEvent tip(QEvent::ToolTip, robot(2), arena().mapToGlobal(robot(2)));
  QCoreApplication::sendEvent(&arena(), &tip);
  EXPECT_FALSE(QToolTip::text().contains(QStringLiteral("stopped"))) << QToolTip::text().toStdString();
  QTest::mouseClick(hold, Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return record().robots[2].wheels != core::WheelSpeeds{}; }));
  const QStringList events = saved_events();
  EXPECT_EQ(count(events, "hold r3"), 1);
  EXPECT_EQ(count(events, "release r3"), 1);
}

TEST_F(Operator, FiltersTheEvents) {
  start();
  find<QDoubleSpinBox>("spin_k_yy")->setValue(find<QDoubleSpinBox>("spin_k_yy")->maximum());
  drag(robot(1), robot(1) + QPoint(-30, 0));
  auto* log = find<QAbstractItemView>("event_log");
  const auto rows_with = [&](int column, const QString& text) {
    return log->model()->match(log->model()->index(0, column), Qt::DisplayRole, text, -1, Qt::MatchExactly).size();
  };
  ASSERT_TRUE(eventually([&] {
    return rows_with(1, QStringLiteral("!")) > 0 && rows_with(2, QStringLiteral("Robot 2 was moved by hand")) > 0;
  })) << "of a gain that is held, and of the hand";
  const int all = log->model()->rowCount();
  auto* level = find<QComboBox>("event_level");
  level->setCurrentIndex(2);
  EXPECT_LT(log->model()->rowCount(), all);
  ASSERT_GE(log->model()->rowCount(), 1) << "gain_held is a warning";
  EXPECT_EQ(log->model()->index(0, 1).data().toString(), QStringLiteral("!"));
  level->setCurrentIndex(0);
  find<QLineEdit>("event_words")->setText(QStringLiteral("R2"));
  ASSERT_GE(log->model()->rowCount(), 1);
  for (int row = 0; row < log->model()->rowCount(); ++row)
    EXPECT_TRUE(log->model()->index(row, 2).data(Qt::ToolTipRole).toString().contains(QStringLiteral("r2")));
  EXPECT_EQ(log->model()->index(0, 2).data().toString(), QStringLiteral("Robot 2 was moved by hand"));
}

}  // namespace
}  // namespace skein::ui::test
