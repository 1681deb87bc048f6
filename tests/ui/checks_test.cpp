// The check list before a start: what it shows, what it lets through, and how things are mended from it.
#include <QAbstractItemView>
#include <QAction>
#include <QLabel>
#include <QScrollArea>
#include <QScrollBar>
#include <QTabWidget>

#include "operator.h"
#include "tests/places.h"
#include "ui/calibration/floor_page.h"

namespace skein::ui::test {
namespace {

class Checks : public Operator {
 protected:
  void open_and_wait(const app::Experiment& experiment = app::paper_experiment()) {
    window.resize(1280, 800);
    window.show();
    window.activateWindow();
    window.open(experiment, false);
    ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
    ASSERT_TRUE(eventually([&] { return find<QPushButton>("go")->isEnabled(); }));
  }
  bool seen() { return find("check_list")->isVisible(); }
};

TEST_F(Checks, StayAwayWhereAllIsWell) {
  open_and_wait();
  EXPECT_FALSE(seen());
  window.go();
  EXPECT_TRUE(eventually([&] { return running(); }));
  EXPECT_FALSE(seen());
}

TEST_F(Checks, CanBeLookedAtAnyTime) {
  open_and_wait();
  find<QAction>("view_checks")->trigger();
  EXPECT_TRUE(seen());
  EXPECT_TRUE(eventually([&] { return find<QLabel>("check_gains")->text().contains(QStringLiteral("(18)")); }));
  for (const char* name : {"camera", "settings", "tags", "links", "batteries", "gains", "reference", "places"})
    EXPECT_TRUE(eventually([&] {
      return find<QLabel>((std::string("check_mark_") + name).c_str())->text().contains(QStringLiteral("✓"));
    })) << name;
  EXPECT_FALSE(find("start_anyway")->isVisible());
}

TEST_F(Checks, NameARobotOutOfItsPlaceAndBringItBack) {
  open_and_wait();
  drag(robot(1), floor(0.0, 0.0));
  ASSERT_TRUE(eventually([&] { return seen(); }));
  EXPECT_TRUE(find<QLabel>("check_places")->text().contains(QStringLiteral("robot 2")));
  window.go();
  EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("Not started")))
      << find<QLabel>("alert")->text().toStdString();
  EXPECT_TRUE(eventually([&] { return arena().scene().banner.contains(QStringLiteral("robot 2")); }));
  EXPECT_TRUE(arena().scene().alert.isEmpty()) << "twice, one below the other: " << arena().scene().alert.toStdString();
  QTest::mouseClick(find<QPushButton>("mend_places"), Qt::LeftButton);
  ASSERT_TRUE(eventually([&] {
    EXPECT_FALSE(arena().scene().alert.contains(QStringLiteral("Not started"))) << "the banner says what holds now";
    return !seen() && arena().scene().banner.contains(QStringLiteral("Ready"));
  })) << "it was not brought back";
  EXPECT_EQ(live().phase(), app::Phase::ready) << "Start was refused, and must not come back by itself";
  window.go();
  EXPECT_TRUE(eventually([&] { return running(); }));
}

TEST_F(Checks, ShowWholeWhatFails) {
  open_and_wait();
  drag(robot(1), floor(0.0, 0.0));
  ASSERT_TRUE(eventually([&] { return seen(); }));
  const auto whole = [&](const char* name) {
    return eventually([&] { return find(name)->visibleRegion() == QRegion(find(name)->rect()); });
  };
  for (const char* name : {"check_camera", "check_gains", "check_places", "mend_places"})
    EXPECT_TRUE(whole(name)) << name << " at 1280x800";
  window.resize(800, 600);
  EXPECT_TRUE(whole("check_places")) << "where there is no room for all";
  EXPECT_TRUE(whole("mend_places"));
}

TEST_F(Checks, NeedNoScrollBarWhereTheArenaHasRoomToSpare) {
  app::Experiment experiment = app::paper_experiment();
  experiment.camera.source = "v4l2:/dev/no-such-camera";
  experiment.camera.calibration = "overhead.toml";
  experiment.directory = skein::test::in_source("resources/cameras");
  open_and_wait(experiment);
  ASSERT_TRUE(eventually([&] { return seen(); }));
  const auto* bar = find("check_list")->findChild<QScrollArea*>()->verticalScrollBar();
  for (const int width : {1280, 1240, 1200, 1320, 1360, 1400, 1280}) {
    window.resize(width, 800);
    EXPECT_TRUE(eventually([&] { return window.width() == width && bar->maximum() == 0; }))
        << bar->maximum() << " px are hidden at " << width;
    EXPECT_GE(arena().height(), 130) << width;
  }
}

TEST_F(Checks, ShowTheCameraWhoseAutomaticsAreToBeSwitchedOff) {
  open_and_wait();
  find<QPushButton>("mend_settings")->click();
  EXPECT_TRUE(eventually([&] { return find("camera_page")->isVisible(); }));
}

TEST_F(Checks, AreOverruledWhereThatEndangersNobody) {
  open_and_wait();
  drag(robot(1), floor(0.0, 0.0));
  ASSERT_TRUE(eventually([&] { return seen() && find("start_anyway")->isVisible(); }));
  QTest::mouseClick(find<QPushButton>("start_anyway"), Qt::LeftButton);
  EXPECT_TRUE(eventually([&] { return running(); }));
  EXPECT_TRUE(eventually([&] { return !seen(); }));
}

TEST_F(Checks, NobodyStartsBlind) {
  app::Experiment blind = app::paper_experiment();
  blind.simulation.dropout = 1.0;  // no pose ever comes
  open_and_wait(blind);
  ASSERT_TRUE(eventually([&] { return seen(); }));
  EXPECT_FALSE(find("start_anyway")->isVisible());
  window.go();
  EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("tag")))
      << find<QLabel>("alert")->text().toStdString();
  QTest::qWait(100);
  EXPECT_EQ(live().phase(), app::Phase::ready);
}

TEST_F(Checks, ACameraThatMovedOffItsMarksIsCalibratedByThem) {
  auto moved = app::load_experiment(
      skein::test::in_source("resources/experiments/platoon.toml"),
      {"camera.source=synthetic", "camera.calibration=../cameras/marked.toml", "camera.bump_at=0"});
  ASSERT_TRUE(moved.has_value());
  open_and_wait(*moved);
  auto* reason = find<QLabel>("check_camera");
  ASSERT_TRUE(eventually([&] { return reason->text().contains(QStringLiteral("6 marks on the floor are 4")); }))
      << reason->text().toStdString();
  EXPECT_TRUE(seen());
  EXPECT_FALSE(find("start_anyway")->isVisible());
  window.go();
  EXPECT_TRUE(find<QLabel>("alert")->text().contains(QStringLiteral("6 marks on the floor are 4")))
      << "the alarm lasts";
  EXPECT_EQ(live().phase(), app::Phase::ready);
  QTest::mouseClick(find<QPushButton>("mend_camera"), Qt::LeftButton);
  EXPECT_EQ(find<QTabWidget>("calibration_tabs")->currentIndex(), 1);
  const auto* tags = find<QAbstractItemView>("floor_tags")->model();
  ASSERT_EQ(tags->rowCount(), 6);
  EXPECT_EQ(tags->index(5, FloorModel::id).data().toInt(), 25);
  delete find("calibration_dialog");
}

}  // namespace
}  // namespace skein::ui::test
