// A run from Start to STOP with mouse and keyboard, and what the CSV says of it afterwards.
#include <QAbstractItemView>
#include <QDoubleSpinBox>
#include <QSlider>
#include <cmath>

#include "operator.h"

namespace skein::ui::test {
namespace {

TEST_F(Operator, SeesWhatCanBeDoneWithTheRobotsOnceTheyDrive) {
  start();
  EXPECT_FALSE(arena().scene().hint.isEmpty()) << "nobody says that robots can be dragged";
}

TEST_F(Operator, DragsARobotAndItKeepsItsHeading) {
  start();
  const double heading = arena().scene().pose(1)->theta;
  drag(robot(1), floor(0.3, 0.1));
  const core::Pose put = moved(1);
  EXPECT_NEAR(put.x, 0.3, 0.01);
  EXPECT_NEAR(put.y, 0.1, 0.01);
  EXPECT_NEAR(core::wrap_angle(put.theta - heading), 0.0, 0.1);
  EXPECT_TRUE(arena().scene().hint.isEmpty() || eventually([&] { return arena().scene().hint.isEmpty(); }));
  EXPECT_EQ(count(saved_events(), "move r2 "), 1);
}

TEST_F(Operator, CannotDropARobotOutsideTheArena) {
  start();
  drag(robot(0), {1, 1});
  const core::Pose put = moved(0);
  EXPECT_NEAR(put.x, -1.0 + core::standard_radius, 1e-9);
  EXPECT_NEAR(put.y, 0.75 - core::standard_radius, 1e-9);
}

TEST_F(Operator, TurnsARobotWithTheWheel) {
  start();
  const double before = record().robots[2].truth.theta;
  for (int notch = 0; notch < 4; ++notch) wheel(robot(2), 1);  // faster than ticks come: none may get lost
  EXPECT_NEAR(core::wrap_angle(moved(2).theta - before), core::pi / 3, 0.05);
  EXPECT_GE(count(saved_events(), "move r3 "), 1);
}

TEST_F(Operator, TurnsARobotFinelyWithShift) {
  start();
  const double before = record().robots[3].truth.theta;
  wheel(robot(3), 10, Qt::ShiftModifier);
  EXPECT_NEAR(core::wrap_angle(moved(3).theta - before), core::pi / 18, 0.03);
}

TEST_F(Operator, SelectsARobotEverywhere) {
  start();
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, robot(2));
  EXPECT_EQ(arena().scene().selected, 2);
  EXPECT_EQ(find<QAbstractItemView>("robots")->currentIndex().row(), 2);
}

TEST_F(Operator, MovesAGainWithTheSlider) {
  start();
  auto* slider = find<QSlider>("slider_k_xx");
  QTest::mouseClick(slider, Qt::LeftButton, {}, {slider->width() / 2, slider->height() / 2});
  const double wanted = find<QDoubleSpinBox>("spin_k_xx")->value();
  EXPECT_NE(wanted, 0.008);
  ASSERT_TRUE(eventually([&] { return std::abs(record().k_xx - wanted) < 1e-6; })) << "it never got there";
  EXPECT_EQ(count(saved_events(), "gain k_xx 0.008 -> "), 1);
}

TEST_F(Operator, FindsAGainHeldAtItsLimit) {
  start();
  auto* spin = find<QDoubleSpinBox>("spin_k_yy");
  const double limit = live().gain_limit(core::GainName::k_yy);
  ASSERT_LT(limit, spin->maximum());
  spin->setValue(spin->maximum());
  ASSERT_TRUE(eventually([&] { return std::abs(spin->value() - limit) < 1e-4; })) << "the box shows what does not hold";
  const QStringList events = saved_events();
  EXPECT_EQ(count(events, "gain_held k_yy "), 1);
  EXPECT_EQ(count(events, "gain k_yy "), 1);
  EXPECT_TRUE(eventually([&] { return find<QLabel>("alert")->text().contains(QStringLiteral("its limit")); }));
}

TEST_F(Operator, PutsTheGainsBackToTheFiles) {
  start();
  find<QDoubleSpinBox>("spin_k_xx")->setValue(0.004);
  ASSERT_TRUE(eventually([&] { return record().k_xx < 0.0079; }));
  QTest::mouseClick(find<QPushButton>("reset_gains"), Qt::LeftButton);
  EXPECT_EQ(find<QDoubleSpinBox>("spin_k_xx")->value(), 0.008);
  EXPECT_TRUE(eventually([&] { return std::abs(record().k_xx - 0.008) < 1e-9; }));
}

TEST_F(Operator, PausesAndResumes) {
  start();
  auto* go = find<QPushButton>("go");
  EXPECT_EQ(go->text(), QStringLiteral("Pause"));
  QTest::mouseClick(go, Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return live().phase() == app::Phase::paused; }));
  const double t = record().t;
  const double now = record().now;
  ASSERT_TRUE(eventually([&] { return record().now > now + 0.2; }));
  EXPECT_EQ(record().t, t) << "the experiment's clock ran on";
  EXPECT_EQ(record().robots[0].wheels.left, 0.0);
  ASSERT_TRUE(eventually([&] { return go->text() == QStringLiteral("Resume"); }));
  key(Qt::Key_F5);
  ASSERT_TRUE(eventually([&] { return running() && record().t > t; }));
  const QStringList events = saved_events();
  EXPECT_EQ(count(events, "pause"), 1);
  EXPECT_EQ(count(events, "resume"), 1);
}

TEST_F(Operator, StartsANewRunAfterStop) {
  start();
  key(Qt::Key_Escape);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  QTest::mouseClick(find<QPushButton>("new_run"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] { return live().latest() != nullptr && live().phase() == app::Phase::ready; }));
  EXPECT_EQ(live().history().size(), 0u);
  ASSERT_TRUE(eventually([&] { return find<QPushButton>("go")->isEnabled(); }));
  QTest::mouseClick(find<QPushButton>("go"), Qt::LeftButton);
  EXPECT_TRUE(eventually([&] { return running(); }));
}

TEST_F(Operator, FindsTheWholeRunInTheCsv) {
  start();
  drag(robot(1), robot(1) + QPoint(-30, 0));
  wheel(robot(2), 1);
  find<QDoubleSpinBox>("spin_k_xx")->setValue(0.01);
  ASSERT_TRUE(eventually([&] { return std::abs(record().k_xx - 0.01) < 1e-6; }));
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  const QStringList events = saved_events();
  EXPECT_EQ(events.value(0), QStringLiteral("start"));
  EXPECT_EQ(count(events, "move r2 "), 1);
  EXPECT_EQ(count(events, "move r3 "), 1);
  EXPECT_EQ(count(events, "gain k_xx 0.008 -> 0.01"), 1);
  EXPECT_EQ(events.last(), QStringLiteral("stop"));
}

}  // namespace
}  // namespace skein::ui::test
