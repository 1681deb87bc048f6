// The check list before a start: what it shows, what it lets through, and how things are mended from it.
#include <QAbstractItemView>
#include <QAction>
#include <QLabel>
#include <QMessageBox>
#include <QPlainTextEdit>
#include <QScrollArea>
#include <QScrollBar>
#include <QTabWidget>
#include <QVBoxLayout>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <set>

#include "app/calibration/calibration_file.h"
#include "operator.h"
#include "tests/files.h"
#include "tests/places.h"
#include "ui/base/picture.h"
#include "ui/calibration/floor_page.h"
#include "ui/editor/experiment_editor.h"
#include "ui/status/check_list.h"
#include "vision/synthetic/synthetic_camera.h"

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
  EXPECT_TRUE(find<QLabel>("phase")->text().contains(QStringLiteral("Not ready")));
  EXPECT_EQ(arena().scene().banner.toStdString(), "") << "the list right above it says that";
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

TEST_F(Checks, LeaveTheArenaItsRoomInASmallWindow) {
  open_and_wait();
  window.resize(800, 600);
  drag(robot(1), floor(0.0, 0.0));
  ASSERT_TRUE(eventually([&] { return seen() && find("checks_folded")->isVisible(); }));
  EXPECT_TRUE(eventually([&] { return arena().height() >= 190; })) << arena().height() << " px are left of it";
  EXPECT_FALSE(find("check_gains")->isVisible());
  EXPECT_TRUE(find<QLabel>("checks_folded")->text().startsWith(QStringLiteral("7 ")));
  find<QAction>("view_checks")->trigger();
  EXPECT_TRUE(eventually([&] { return find("check_gains")->isVisible(); })) << "whoever asks for the list gets all";
  EXPECT_FALSE(find("checks_folded")->isVisible());
}

/// What fails stands at the end of the list, and reasons above it take several lines.
TEST_F(Checks, ShowWhatFailsBelowLongReasons) {
  QWidget place;
  auto* list = new CheckList(&place);
  auto* layout = new QVBoxLayout(&place);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(list);
  auto* arena = new QWidget;
  arena->setMinimumHeight(150);
  layout->addWidget(arena, 1);
  std::vector<app::Check> checks;
  for (const auto what :
       {app::Check::What::camera, app::Check::What::settings, app::Check::What::tags, app::Check::What::links,
        app::Check::What::batteries, app::Check::What::gains, app::Check::What::reference, app::Check::What::places}) {
    app::Check check{};
    check.what = what;
    check.state = app::Check::State::holds;
    for (int word = 0; word < 25; ++word) check.reason += "reason ";
    checks.push_back(check);
  }
  checks.back().state = app::Check::State::fails;
  checks.back().button = true;
  place.resize(480, 460);
  place.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&place));
  for (const int width : {480, 700, 420}) {
    place.resize(width, 460);
    list->show_checks(checks);
    auto* failing = list->findChild<QLabel*>(QStringLiteral("check_places"));
    EXPECT_TRUE(eventually([&] { return failing->visibleRegion() == QRegion(failing->rect()); })) << width;
    EXPECT_GE(arena->height(), 190) << width;
  }
}

TEST_F(Checks, SayWhatStartAnywayOverrules) {
  open_and_wait();
  drag(robot(1), floor(0.0, 0.0));
  ASSERT_TRUE(eventually([&] { return seen() && find("start_anyway")->isVisible(); }));
  EXPECT_TRUE(find<QLabel>("start_anyway_text")->text().contains(QStringLiteral("marked !")));
  const auto middle = [&](const char* name) { return find(name)->geometry().center().y(); };
  ASSERT_TRUE(eventually([&] { return middle("start_anyway") > middle("mend_places"); }));
  EXPECT_NEAR(middle("start_anyway"), middle("start_anyway_text"), 2);
  for (const char* check : {"check_reference", "check_places"})
    EXPECT_GT(std::abs(middle("start_anyway") - middle(check)), 10) << "it stands beside " << check;
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
  EXPECT_TRUE(eventually([&] { return find<QLabel>("pace")->text().contains(QStringLiteral("Hz")); }));
  EXPECT_FALSE(find<QLabel>("pace")->text().contains(QStringLiteral("closest pair"))) << "nobody knows";
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

TEST_F(Checks, NobodyIsSentToCalibrateACameraThatIsFrozen) {
  auto frozen = app::load_experiment(skein::test::in_source("resources/experiments/platoon.toml"),
                                     {"camera.source=synthetic", "camera.freeze_at=0.5"});
  ASSERT_TRUE(frozen.has_value());
  open_and_wait(*frozen);
  auto* reason = find<QLabel>("check_camera");
  ASSERT_TRUE(eventually([&] { return reason->text().contains(QStringLiteral("the same picture again and again")); }))
      << reason->text().toStdString();
  EXPECT_FALSE(find<QPushButton>("mend_camera")->isVisible());
}

/// Robots in their places, with tags of 40 mm under a camera that is calibrated for 60 mm; all in one folder.
class TagsOfAnotherSize : public Checks {
 protected:
  explicit TagsOfAnotherSize(app::Experiment robots = app::paper_experiment()) : robots_(std::move(robots)) {}
  void SetUp() override {
    Checks::SetUp();
    auto calibration = vision::overhead_calibration(robots_.arena_width, robots_.arena_height);
    calibration.tag_size = 0.04;
    const auto reference = app::make_reference(robots_);
    std::vector<vision::SyntheticTag> tags;
    for (std::size_t k = 0; k < robots_.robots.size(); ++k)
      tags.push_back({robots_.robots[k].tag, reference->at(k, 0.0).pose, calibration.tag_size});
    vision::Frame frame;
    vision::SyntheticCamera(calibration).render(tags, 0.0, frame);
    ASSERT_TRUE(QDir(dir.path()).mkdir(QStringLiteral("film")));
    const QString first = dir.filePath(QStringLiteral("film/0000.pgm"));
    ASSERT_TRUE(image_of(app::Picture{frame.width, frame.height, {frame.grey.begin(), frame.grey.end()}}).save(first));
    for (int k = 1; k < 1500; ++k)  // a minute
      std::filesystem::create_hard_link(
          first.toStdString(),
          dir.filePath(QStringLiteral("film/%1.pgm").arg(k, 4, 10, QLatin1Char('0'))).toStdString());
    calibration.tag_size = 0.06;
    ASSERT_TRUE(app::save_calibration(calibration, dir.filePath(QStringLiteral("cal.toml")).toStdString()));
    write(text);
  }
  void write(const std::string& content) { std::ofstream(file.toStdString(), std::ios::trunc) << content; }
  std::string written() { return skein::test::read_file(file.toStdString()); }
  /// Until the list says why, and offers what mends it.
  void open_file_and_wait() {
    window.resize(1280, 800);
    window.show();
    window.activateWindow();
    window.open_file(file);
    ASSERT_TRUE(eventually([&] { return find<QPushButton>("mend_tag_size")->isVisible(); }))
        << find<QLabel>("check_tags")->text().toStdString();
  }
  const app::Experiment robots_;
  QTemporaryDir dir;
  const QString file = dir.filePath(QStringLiteral("robots.toml"));
  std::string text = "# four robots\n[camera]\nsource = \"images:" + dir.path().toStdString() +
                     "/film\"  # a film\ncalibration = \"cal.toml\"\n";
};

TEST_F(TagsOfAnotherSize, AreShownAndMendedByAButton) {
  open_file_and_wait();
  auto* button = find<QPushButton>("mend_tag_size");
  EXPECT_EQ(button->text(), QStringLiteral("Set tag size 40 mm"));
  EXPECT_EQ(button->accessibleName(), QStringLiteral("All tags seen: Set tag size 40 mm"));
  for (int robot = 1; robot <= 4; ++robot) {
    auto* picture = find<QLabel>(("tag_picture_" + std::to_string(robot)).c_str());
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->accessibleName(), QStringLiteral("Tag %1 of robot %1, as the camera shows it").arg(robot));
    EXPECT_TRUE(picture->toolTip().contains(QStringLiteral("33 % smaller than [tags] size 60 mm")))
        << picture->toolTip().toStdString();
    EXPECT_GE(picture->pixmap(Qt::ReturnByValue).width(), 50);
  }
  button->setFocus();
  key(Qt::Key_Return);
  ASSERT_TRUE(eventually([&] { return live().experiment().tag_size == 0.04; })) << "it was not set up again";
  EXPECT_EQ(written(), text + "\n[tags]\nsize = 0.04\n") << "with its comments";
  ASSERT_TRUE(eventually([&] { return live().latest() && !record().robots[3].is(app::lost) && !seen(); }));
  find<QAction>("view_checks")->trigger();
  EXPECT_TRUE(find<QLabel>("check_tags")->text().contains(QStringLiteral("all 4 robots")))
      << find<QLabel>("check_tags")->text().toStdString();
  EXPECT_FALSE(button->isVisible());
  EXPECT_FALSE(find("tag_pictures")->isVisible());
  auto* editor = window.findChild<ExperimentEditor*>();
  ASSERT_TRUE(editor) << "what was written can be undone there";
  editor->findChild<QPlainTextEdit*>()->undo();
  EXPECT_EQ(editor->text().toStdString(), text);
}

TEST_F(TagsOfAnotherSize, WhatSomebodyElseWroteIsNotWrittenOver) {
  open_file_and_wait();
  write(text + "# theirs\n");
  find<QPushButton>("mend_tag_size")->click();
  EXPECT_TRUE(window.findChild<QMessageBox*>(QStringLiteral("editor_overwrite_dialog"))) << "nobody is asked";
  EXPECT_EQ(written(), text + "# theirs\n");
  EXPECT_EQ(live().experiment().tag_size, std::nullopt);
}

TEST_F(TagsOfAnotherSize, AreShownWholeInASmallWindow) {
  open_file_and_wait();
  for (const QSize size : {QSize(1280, 800), QSize(800, 600)}) {
    window.resize(size);
    for (const char* name : {"mend_tag_size", "tag_picture_1", "mend_tags"})
      EXPECT_TRUE(eventually([&] { return find(name)->visibleRegion() == QRegion(find(name)->rect()); }))
          << name << " at " << size.width();
    EXPECT_GE(find("tag_picture_1")->height(), 56) << "squeezed at " << size.width();
    const QRegion reason = find("check_tags")->visibleRegion();
    EXPECT_TRUE(reason.contains(QPoint(0, 0))) << "its beginning is scrolled away at " << size.width();
  }
}

class TenTagsOfAnotherSize : public TagsOfAnotherSize {
 protected:
  TenTagsOfAnotherSize()
      : TagsOfAnotherSize(
            app::load_experiment(skein::test::in_source("resources/experiments/antipodal-swap-10.toml")).value()) {
    text = robots_.source + text.substr(text.find('\n'));
  }
  const std::string tag_picture(int robot) { return "tag_picture_" + std::to_string(robot); }
  QScrollBar* bar() { return find("check_list")->findChild<QScrollArea*>()->verticalScrollBar(); }
  /// Scrolls through the list, a step at a time; the robots whose pictures were seen whole on the way.
  std::set<int> seen_on_the_way(const std::function<void()>& step) {
    std::set<int> seen;
    for (int steps = 0; steps < 100; ++steps) {
      QCoreApplication::sendPostedEvents();
      for (int robot = 1; robot <= 10; ++robot)
        if (auto* picture = find(tag_picture(robot).c_str());
            picture && picture->visibleRegion().boundingRect() == picture->rect())
          seen.insert(robot);
      if (bar()->value() == bar()->maximum()) break;
      step();
    }
    return seen;
  }
};

TEST_F(TenTagsOfAnotherSize, AreAllReachedByWheelAndKeys) {
  open_file_and_wait();
  const std::set<int> all{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  for (const QSize size : {QSize(1280, 800), QSize(800, 600)}) {
    window.resize(size);
    ASSERT_TRUE(eventually([&] { return window.size() == size && find(tag_picture(10).c_str())->isVisible(); }));
    lay_out();
    QWidget* const pictures = find("tag_pictures");
    for (int robot = 1; robot <= 10; ++robot) {
      const QLabel* picture = find<QLabel>(tag_picture(robot).c_str());
      EXPECT_GE(picture->height(), 56) << "squeezed";
      EXPECT_GE(picture->width(), picture->pixmap(Qt::ReturnByValue).width());
      const QRect cell(picture->parentWidget()->geometry());
      EXPECT_TRUE(pictures->rect().contains(cell)) << robot << " at " << size.width();
    }
    bar()->setValue(0);
    EXPECT_EQ(seen_on_the_way([&] {
                QWheelEvent event(QPointF(5, 5), bar()->mapToGlobal(QPointF(5, 5)), {}, {0, -40}, Qt::NoButton,
                                  Qt::NoModifier, Qt::NoScrollPhase, false);
                QCoreApplication::sendEvent(bar(), &event);
              }),
              all)
        << "by the wheel at " << size.width();
    bar()->setValue(0);
    find("mend_tag_size")->setFocus();
    EXPECT_EQ(seen_on_the_way([&] { key(Qt::Key_PageDown); }), all) << "by the keyboard at " << size.width();
  }
}

TEST_F(TenTagsOfAnotherSize, StayWhereTheOperatorHasScrolledThem) {
  open_file_and_wait();
  window.resize(800, 600);
  ASSERT_TRUE(eventually([&] { return bar()->maximum() > 0; }));
  lay_out();
  find("mend_tag_size")->setFocus();
  seen_on_the_way([&] { key(Qt::Key_PageDown); });
  const int there = bar()->value();
  ASSERT_GT(there, 0);
  const QLabel* const picture = find<QLabel>(tag_picture(10).c_str());
  const auto drawn = [&] { return find<QLabel>(tag_picture(10).c_str())->pixmap(Qt::ReturnByValue).cacheKey(); };
  const qint64 before = drawn();
  ASSERT_TRUE(eventually([&] { return drawn() != before; })) << "the camera looks for them every few seconds";
  EXPECT_EQ(bar()->value(), there);
  EXPECT_EQ(find<QLabel>(tag_picture(10).c_str()), picture) << "its tip would go each time";
}

}  // namespace
}  // namespace skein::ui::test
