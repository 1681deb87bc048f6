// While a gain's slider is held: what the next seconds would be.
#include <unistd.h>

#include <QSlider>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "operator.h"
#include "tests/places.h"
#include "tests/processes.h"
#include "ui/main/preview_controller.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui::test {
namespace {

class Preview : public Operator {
 protected:
  PreviewController& preview() { return *window.findChild<PreviewController*>(); }
  QSlider* slider() { return find<QSlider>("slider_k_xx"); }
  bool shown() { return preview().shown() != nullptr; }
  bool drawn() { return !arena().scene().foreseen.empty(); }
  bool plotted() {
    const auto& foreseen = find<PlotsPanel>("plots")->foreseen();
    return foreseen && !foreseen->empty();
  }
  /// Presses the knob and draws it to this share of its way.
  void draw_knob(double to) {
    const auto x = [&](double share) { return static_cast<int>(8 + share * (slider()->width() - 16)); };
    const int y = slider()->height() / 2;
    QTest::mousePress(slider(), Qt::LeftButton, {}, {x(slider()->value() / 1000.0), y});
    QTest::mouseMove(slider(), {x(to), y});
    ASSERT_TRUE(slider()->isSliderDown()) << "the knob was not hit";
  }
  void let_knob_go() { QTest::mouseRelease(slider(), Qt::LeftButton, {}, slider()->rect().center()); }

  static std::size_t threads() {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& task : std::filesystem::directory_iterator("/proc/self/task")) ++count;
    return count;
  }
};

TEST_F(Preview, IsWhatTheRunThenDoes) {
  start();
  drag(robot(1), robot(1) + QPoint(40, 30));
  moved(1);
  window.set_speed(10.0);  // at any speed but 1 every tick has exactly its time
  draw_knob(0.1);
  ASSERT_TRUE(eventually([&] { return shown() && record().k_xx == live().gain_target(core::GainName::k_xx, 0, 1); }));
  // One that was asked for since the gain has reached its value: from here on nobody touches anything.
  const LookAhead::Rows before = preview().shown();
  ASSERT_TRUE(eventually([&] { return shown() && preview().shown() != before; }));
  const LookAhead::Rows foreseen = preview().shown();
  EXPECT_TRUE(drawn());
  EXPECT_TRUE(plotted());
  EXPECT_TRUE(preview().hint().startsWith(QStringLiteral("Pale: the next 10 s with k_xx")))
      << preview().hint().toStdString();
  EXPECT_FALSE(preview().hint().contains(QStringLiteral("model"))) << preview().hint().toStdString();
  const app::TickRecord end = foreseen->back();
  ASSERT_EQ(foreseen->size(), 250U);
  ASSERT_TRUE(eventually([&] { return record().t >= end.t; }));
  let_knob_go();
  int compared = 0;
  for (const auto& row : live().history().rows())
    for (const app::TickRecord& then : *foreseen) {
      if (row->tick != then.tick) continue;
      ++compared;
      for (std::size_t i = 0; i < 4; ++i)
        ASSERT_LE(core::distance(row->robots[i].truth, then.robots[i].truth), 1e-9) << row->t << " s, robot " << i + 1;
    }
  EXPECT_EQ(compared, 250);
}

TEST_F(Preview, GoesWhenTheKnobIsLetGo) {
  start();
  draw_knob(0.5);
  ASSERT_TRUE(eventually([&] { return drawn(); }));
  EXPECT_TRUE(eventually([&] { return arena().scene().hint.startsWith(QStringLiteral("Pale")); }));
  let_knob_go();
  EXPECT_FALSE(drawn());
  EXPECT_FALSE(plotted());
  EXPECT_TRUE(preview().hint().isEmpty());
}

TEST_F(Preview, StaysForASecondAfterAKey) {
  start();
  slider()->setFocus();
  key(Qt::Key_Right);
  ASSERT_TRUE(eventually([&] { return drawn(); }));
  EXPECT_TRUE(eventually([&] { return !drawn(); }));
  EXPECT_FALSE(plotted());
}

TEST_F(Preview, OfARunThatIsNotUnderWayIsThatOfItsStart) {
  window.resize(1280, 800);
  window.show();
  window.activateWindow();
  window.open(app::paper_experiment(), false);
  ASSERT_TRUE(QTest::qWaitForWindowActive(&window));
  ASSERT_TRUE(eventually([&] { return live().latest() != nullptr; }));
  draw_knob(0.5);
  ASSERT_TRUE(eventually([&] { return shown(); }));
  EXPECT_EQ(preview().shown()->front().tick, 0);
  EXPECT_EQ(live().phase(), app::Phase::ready) << "it is only a preview";
  let_knob_go();
}

TEST_F(Preview, IsEndedByStop) {
  start();
  draw_knob(0.5);
  ASSERT_TRUE(eventually([&] { return drawn(); }));
  key(Qt::Key_Space);
  ASSERT_TRUE(eventually([&] { return stopped(); }));
  EXPECT_TRUE(eventually([&] { return !drawn() && !plotted(); }));
  QTest::mouseMove(slider(), {20, slider()->height() / 2});
  EXPECT_FALSE(shown()) << "nothing moves any more";
  let_knob_go();
}

TEST_F(Preview, OfRobotsThatAreNotSimulatedSaysSo) {
  const auto experiment = app::load_experiment(skein::test::in_source("resources/experiments/platoon-loopback.toml"));
  ASSERT_TRUE(experiment);
  start(*experiment);
  draw_knob(0.5);
  ASSERT_TRUE(eventually([&] { return drawn(); }));
  EXPECT_TRUE(preview().hint().contains(QStringLiteral("robots as the model has them")))
      << preview().hint().toStdString();
  let_knob_go();
}

TEST_F(Preview, OfPlannedRoutesIsDrawnToo) {
  const auto experiment =
      app::parse_experiment(app::paper_experiment().source, "plan.toml", {"avoidance.kind=\"plan\""});
  ASSERT_TRUE(experiment);
  start(*experiment);
  draw_knob(0.5);
  EXPECT_TRUE(eventually([&] { return drawn() && plotted(); }));
  EXPECT_FALSE(slider()->toolTip().contains(QStringLiteral("No preview"))) << slider()->toolTip().toStdString();
  let_knob_go();
}

TEST_F(Preview, OfALawsParameterIsDrawnToo) {
  const auto experiment =
      app::parse_experiment(app::paper_experiment().source, "other.toml", {"controller.kind=\"virtual_structure\""});
  ASSERT_TRUE(experiment);
  start(*experiment);
  ASSERT_FALSE(live().parameters().empty());
  const QString name = QString::fromStdString(live().parameters().front().name);
  const std::string slider_name = "slider_" + name.toStdString();
  ASSERT_TRUE(eventually([&] { return window.findChild<QSlider*>(QString::fromStdString(slider_name)) != nullptr; }));
  auto* knob = find<QSlider>(slider_name.c_str());
  ASSERT_TRUE(eventually([&] { return knob->isVisible() && knob->isEnabled(); }));
  EXPECT_FALSE(knob->toolTip().contains(QStringLiteral("No preview"))) << knob->toolTip().toStdString();
  knob->setFocus();
  ASSERT_TRUE(eventually([&] { return knob->hasFocus(); }));
  key(Qt::Key_Right);
  ASSERT_TRUE(eventually([&] { return drawn() && plotted(); }));
  EXPECT_TRUE(preview().hint().startsWith(QStringLiteral("Pale: the next 10 s with ") + name))
      << preview().hint().toStdString();
  EXPECT_TRUE(eventually([&] { return !drawn() && !plotted(); })) << "a second after the key";
}

std::string law_program() {
  return std::filesystem::path(skein::test::program()).replace_filename("skein_test_law").string();
}

/// The window over a law of the user's own, a program.
class OwnPreview : public Preview {
 protected:
  /// `does`: where it is started for a preview, before it drives.
  void run(const std::string& does = "true", const std::string& experiment = "platoon.toml",
           const std::string& allowed = "true") {
    const std::string command = "sh -c 'test -z \\\"$SKEIN_PREVIEW\\\" || " + does + "; exec " + law_program() + "'";
    const auto read = app::load_experiment(skein::test::in_source("resources/experiments/" + experiment),
                                           {"controller.command=\"" + command + "\"", "controller.preview=" + allowed});
    ASSERT_TRUE(read) << read.error().front().message();
    start(*read);
    ASSERT_TRUE(eventually([&] { return window.findChild<QSlider*>(QStringLiteral("slider_k_x")) != nullptr; }));
    ASSERT_TRUE(eventually([&] { return knob()->isVisible() && knob()->isEnabled(); }));
  }
  QSlider* knob() { return find<QSlider>("slider_k_x"); }
  /// The knob is held until the mouse lets it go.
  void hold() {
    const QPoint at(8 + static_cast<int>(knob()->value() / 1000.0 * (knob()->width() - 16)), knob()->height() / 2);
    QTest::mousePress(knob(), Qt::LeftButton, {}, at);
    QTest::mouseMove(knob(), at + QPoint(30, 0));
    ASSERT_TRUE(knob()->isSliderDown()) << "the knob was not hit";
  }
  void release() { QTest::mouseRelease(knob(), Qt::LeftButton, {}, knob()->rect().center()); }
  /// Processes of the controller that this one has started, that of the run included.
  static std::size_t processes(const std::string& word = "skein_test_law") {
    const std::string child = "PPid:\t" + std::to_string(getpid()) + "\n";
    std::size_t count = 0;
    for (const auto& process : std::filesystem::directory_iterator("/proc")) {
      std::ostringstream status;
      status << std::ifstream(process.path() / "status").rdbuf();
      const bool ours = status.str().find(child) != std::string::npos;
      if (ours && skein::test::words_of_process(process.path()).find(word) != std::string::npos) ++count;
    }
    return count;
  }
};

TEST_F(OwnPreview, AsksASecondProcessAndSaysSo) {
  run();
  EXPECT_FALSE(knob()->toolTip().contains(QStringLiteral("No preview"))) << knob()->toolTip().toStdString();
  EXPECT_EQ(processes(), 1U);
  hold();
  ASSERT_TRUE(eventually([&] { return drawn() && plotted(); })) << preview().hint().toStdString();
  EXPECT_TRUE(preview().hint().startsWith(QStringLiteral("Pale: the next 10 s with k_x")))
      << preview().hint().toStdString();
  EXPECT_TRUE(preview().hint().endsWith(
      QStringLiteral(", by a second process of the controller, without the memory of the first")))
      << preview().hint().toStdString();
  EXPECT_TRUE(eventually([&] { return processes() == 2; })) << "one is ready for the next value";
  const QString before = preview().hint();
  QTest::mouseMove(knob(), {knob()->width() / 2, knob()->height() / 2});
  EXPECT_TRUE(eventually([&] { return drawn() && preview().hint() != before; })) << "of the value that is held now";
  release();
  EXPECT_TRUE(eventually([&] { return processes() == 1; })) << processes();
  EXPECT_FALSE(drawn());
  EXPECT_TRUE(running());
}

TEST_F(OwnPreview, OfRobotsWithLinksStartsFromTheirPoses) {
  run("true", "platoon-loopback.toml");
  hold();
  ASSERT_TRUE(eventually([&] { return drawn() && plotted(); })) << preview().hint().toStdString();
  EXPECT_TRUE(preview().hint().contains(
      QStringLiteral(", robots as the model has them, by a second process of the controller")))
      << preview().hint().toStdString();
  release();
  EXPECT_TRUE(eventually([&] { return processes() == 1; })) << processes();
}

TEST_F(OwnPreview, EndsWithASentenceWhereTheSecondProcessFails) {
  run("exit 3");
  hold();
  ASSERT_TRUE(eventually([&] { return preview().hint().startsWith(QStringLiteral("No preview: ")); }))
      << preview().hint().toStdString();
  EXPECT_TRUE(preview().hint().contains(QStringLiteral("status 3"))) << preview().hint().toStdString();
  EXPECT_FALSE(drawn());
  EXPECT_TRUE(running());
  release();
  EXPECT_TRUE(preview().hint().isEmpty());
  EXPECT_EQ(processes(), 1U);
}

TEST_F(OwnPreview, LeavesNoProcessWhenTheWindowClosesWhileItStarts) {
  run("exec sleep 1000");
  hold();
  ASSERT_TRUE(eventually([&] { return processes("sleep") == 1; }));
  window.close();
  EXPECT_TRUE(eventually([&] { return processes("sleep") == 0 && processes() == 0; }))
      << processes("sleep") << ", " << processes();
}

TEST_F(OwnPreview, IsNotThereUnlessTheExperimentAllowsASecondProcess) {
  run("true", "platoon.toml", "false");
  EXPECT_TRUE(knob()->toolTip().contains(QStringLiteral("controller.preview"))) << knob()->toolTip().toStdString();
  hold();
  EXPECT_TRUE(preview().hint().startsWith(QStringLiteral("No preview: "))) << preview().hint().toStdString();
  EXPECT_EQ(processes(), 1U);
  release();
}

TEST_F(Preview, LeavesNoThreadWhenCancelled) {
  start();
  draw_knob(0.5);
  ASSERT_TRUE(eventually([&] { return drawn(); }));
  const std::size_t before = threads();
  for (int k = 0; k < 200; ++k) QTest::mouseMove(slider(), {20 + k, slider()->height() / 2});
  EXPECT_LE(threads(), before);
  let_knob_go();
  EXPECT_LE(threads(), before);
  EXPECT_FALSE(drawn());
}

TEST(LookAhead, EndsItsThreadWithItself) {
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
  };
  const auto before = threads();
  {
    LookAhead look_ahead;
    look_ahead.begin(app::paper_experiment());
    look_ahead.ask(app::commands::SetGain{core::GainName::k_xx, 0.01});
    EXPECT_GT(threads(), before);
  }
  EXPECT_EQ(threads(), before);
}

}  // namespace
}  // namespace skein::ui::test
