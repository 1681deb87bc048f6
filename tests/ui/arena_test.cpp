// The operator's gestures in the arena: kick, obstacles, ruler, couplings, keyboard; and why real robots are left
// alone.
#include <QAction>
#include <QApplication>
#include <QHelpEvent>
#include <QLabel>
#include <QSettings>
#include <QToolTip>
#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <vector>

#include "operator.h"
#include "ui/base/settings.h"
#include "ui/base/why.h"

namespace skein::ui::test {
namespace {

class Arena : public Operator {
 protected:
  void use(const char* tool) { find<QAction>(tool)->trigger(); }
};

TEST_F(Arena, KicksARobotWithShiftAndADrag) {
  start();
  const QPoint from = robot(1);
  drag(from, from + QPoint(0, -60), Qt::ShiftModifier);
  const auto kick = last<app::events::Kick>(1);
  EXPECT_NEAR(kick.vx, 0.0, 0.05);
  EXPECT_GT(kick.vy, 0.3) << "upwards on the screen is +y";
  EXPECT_EQ(count(saved_events(), "kick r2 "), 1);
  EXPECT_EQ(count(saved_events(), "move r2 "), 0);
}

TEST_F(Arena, KicksNoHarderThanAMetreASecondAndNotByAccident) {
  start();
  use("tool_kick");
  drag(robot(0), robot(0) + QPoint(8, 0));  // not out of the robot
  EXPECT_TRUE(eventually([&] {
    return find<QLabel>("alert")->text().contains(QStringLiteral("Robot 1 is not kicked"));
  })) << find<QLabel>("alert")->text().toStdString();
  drag(robot(2), floor(0.9, -0.7));
  const auto kick = last<app::events::Kick>(2);
  EXPECT_NEAR(std::hypot(kick.vx, kick.vy), 1.0, 1e-9);
  EXPECT_EQ(count(saved_events(), "kick r1"), 0);
}

TEST_F(Arena, DropsDragsResizesAndTakesAwayAnObstacle) {
  start();
  use("tool_obstacle");
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, floor(0.0, 0.0));
  const core::Obstacle dropped = last<app::events::PutObstacle>(0).obstacle;
  EXPECT_NEAR(dropped.x, 0.0, 0.01);
  EXPECT_NEAR(dropped.radius, 0.04, 1e-9);
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(0.0, 0.0) == 0; }));

  use("tool_hand");
  drag(floor(0.0, 0.0), floor(0.2, -0.2));
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(0.2, -0.2) == 0; })) << "it was not dragged";
  wheel(floor(0.2, -0.2), 3);
  ASSERT_TRUE(eventually([&] { return arena().scene().circumstances.obstacles[0].radius > 0.05; }))
      << "it has not grown";

  drag(floor(0.2, -0.2), floor(0.0, 0.95));  // off the floor
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(0.2, -0.2) < 0; })) << "it was not taken away";
  EXPECT_EQ(count(saved_events(), "obstacle o1 "), 4);
}

TEST_F(Arena, LeavesALargeObstacleOfTheFileAsLargeAndSaysSo) {
  app::Experiment experiment = app::paper_experiment();
  experiment.obstacles = {{-0.3, 0.0, 0.4}};
  open_and_wait(experiment);
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(-0.3, 0.0) == 0; }));
  wheel(floor(-0.3, 0.0), 1);
  EXPECT_TRUE(eventually([&] { return find<QLabel>("alert")->text().contains(QStringLiteral("Obstacle 1 stays")); }))
      << find<QLabel>("alert")->text().toStdString();
  EXPECT_EQ(arena().scene().circumstances.obstacles[0].radius, 0.4);
  wheel(floor(-0.3, 0.0), -1);
  EXPECT_TRUE(eventually([&] { return arena().scene().circumstances.obstacles[0].radius < 0.4; })) << "control";
  EXPECT_GT(arena().scene().circumstances.obstacles[0].radius, 0.3);
}

TEST_F(Arena, DrawsAnObstacleOutToItsSizeAndDeletesItByKey) {
  start();
  use("tool_obstacle");
  drag(floor(-0.2, 0.0), floor(-0.1, 0.0));
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(-0.2, 0.0) == 0; }));
  EXPECT_NEAR(arena().scene().circumstances.obstacles[0].radius, 0.1, 0.01);
  use("tool_hand");
  arena().setFocus();
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, floor(-0.2, 0.0));
  key(Qt::Key_Delete);
  EXPECT_TRUE(eventually([&] { return arena().scene().obstacle_at(-0.2, 0.0) < 0; }));
}

TEST_F(Arena, AnObstacleInTheWayIsAvoided) {
  start();
  use("tool_obstacle");
  const core::Pose ahead = app::make_reference(live().experiment())->at(0, record().t + 2.0).pose;
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, floor(ahead.x, ahead.y));
  EXPECT_TRUE(eventually([&] { return record().robots[0].is(app::avoiding); }));
}

TEST_F(Arena, AnObstacleFromBeforeTheStartIsInTheRecord) {
  window.resize(1280, 800);
  window.show();
  window.open(app::paper_experiment(), false);
  ASSERT_TRUE(eventually([&] { return live().is_open() && live().latest() != nullptr; }));
  use("tool_obstacle");
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, floor(0.0, 0.0));
  ASSERT_TRUE(eventually([&] { return arena().scene().obstacle_at(0.0, 0.0) == 0; }));
  window.go();
  ASSERT_TRUE(eventually([&] { return running() && record().t > 0.1; }));
  EXPECT_EQ(count(saved_events(), "obstacle o1 "), 1);
}

TEST_F(Arena, MeasuresADistance) {
  start();
  use("tool_measure");
  drag(floor(-0.3, -0.3), floor(0.0, 0.1));
  ASSERT_TRUE(arena().scene().ruler);
  const QPointF way = arena().scene().ruler->to - arena().scene().ruler->from;
  EXPECT_NEAR(std::hypot(way.x(), way.y()), 0.5, 0.01);
  EXPECT_EQ(count(saved_events(), "move"), 0);
  use("tool_hand");
  EXPECT_FALSE(arena().scene().ruler) << "the ruler goes with its tool";
}

TEST_F(Arena, IsWorkedWithTheKeyboardAlone) {
  start();
  arena().setFocus();
  ASSERT_TRUE(eventually([&] { return arena().hasFocus(); }));
  key(Qt::Key_3);
  EXPECT_EQ(arena().scene().selected, 2);
  const core::Pose before = *arena().scene().pose(2);
  key(Qt::Key_Up);
  EXPECT_NEAR(moved(2).y - before.y, 0.02, 0.01);
  key(Qt::Key_M);
  EXPECT_EQ(arena().tool(), ArenaTool::measure);
  key(Qt::Key_H);
  EXPECT_EQ(arena().tool(), ArenaTool::hand);
}

TEST_F(Arena, HasNoCouplingsWhereTheLawHasNone) {
  auto experiment =
      app::parse_experiment(app::paper_experiment().source, "leader.toml", {"controller.kind=\"leader_follower\""});
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  start(*experiment);
  bool clicked = false;
  QObject::connect(&arena(), &ArenaView::coupling_clicked, &arena(), [&](int, int) { clicked = true; });
  QTest::mouseClick(&arena(), Qt::LeftButton, Qt::NoModifier, (robot(0) + robot(1)) / 2);
  EXPECT_FALSE(clicked);
  EXPECT_FALSE(arena().scene().draws_couplings());
}

TEST_F(Arena, SwitchesACouplingWithAClickAndBackWithUndo) {
  start();
  const QPoint middle = (robot(0) + robot(1)) / 2;
  std::optional<std::array<int, 2>> clicked;
  QObject::connect(&arena(), &ArenaView::coupling_clicked, &arena(), [&](int i, int j) { clicked = {i, j}; });
  QTest::mouseClick(&arena(), Qt::LeftButton, {}, middle);
  ASSERT_TRUE(clicked);
  EXPECT_EQ((*clicked)[1] - (*clicked)[0], 1);
  const auto i = static_cast<std::size_t>((*clicked)[0]), j = static_cast<std::size_t>((*clicked)[1]);
  ASSERT_TRUE(eventually([&] { return !live().coupled(i, j); })) << "the click did not switch it off";
  ASSERT_TRUE(eventually([&] { return live().gain(core::GainName::k_xx, i, j) == 0.0; }));
  ASSERT_TRUE(eventually([&] { return arena().scene().couplings[i * 4 + j] == 0.0; })) << "its line is still there";
  EXPECT_GT(live().gain(core::GainName::k_xx, 2, 3), 0.0) << "the others are as they were";
  key(Qt::Key_Z, nullptr, Qt::ControlModifier);
  EXPECT_TRUE(eventually([&] { return live().coupled(i, j); })) << "undo";
}

TEST_F(Arena, TheTipOfALostRobotShowsWhatTheCameraSeesOfItsTag) {
  start();
  app::TickRecord lost_row = record();
  lost_row.robots[1].mode |= app::lost;
  ArenaView alone;
  alone.resize(640, 480);
  alone.show();
  alone.show_experiment(live().experiment());
  alone.show_record(lost_row);
  app::UnseenTag tag{.tag = 2, .why = core::NotSeen::covered, .sentence = "tag 2 is there, but part of it is covered"};
  tag.picture = std::make_shared<const app::Picture>(app::Picture{2, 2, {0, 255, 255, 0}});
  alone.set_unseen({tag, tag, tag, tag});
  const auto tip = [&](std::size_t robot) {
    const core::Pose pose = *alone.scene().pose(robot);
    const QPoint at = alone.map().to_screen({pose.x, pose.y}).toPoint();
    QHelpEvent event(QEvent::ToolTip, at, alone.mapToGlobal(at));
    QCoreApplication::sendEvent(&alone, &event);
    return QToolTip::text();
  };
  EXPECT_TRUE(tip(1).contains(QStringLiteral("part of it is covered"))) << tip(1).toStdString();
  EXPECT_TRUE(tip(1).contains(QStringLiteral("<img"))) << tip(1).toStdString();
  EXPECT_FALSE(tip(0).contains(QStringLiteral("covered"))) << "the control: this one is seen";
}

TEST_F(Arena, ATipGoesWithItsRobotThatDrivesOnAndEndsWhenTheMouseLeaves) {
  start();
  const auto tells = [&](const char* robot) {
    const std::size_t i = 1;
    const core::Pose pose = *arena().scene().pose(i);
    return QToolTip::isVisible() && QToolTip::text().contains(QLatin1String(robot)) &&
           QToolTip::text().contains(QStringLiteral("x %1 m").arg(pose.x, 0, 'f', 3)) &&
           QToolTip::text().contains(why(record(), i, arena().scene().circumstances).toHtmlEscaped());
  };
  // A tip ends that comes under the pointer: it takes the mouse from the window.
  QCursor::setPos(window.mapToGlobal(QPoint(0, 0)));
  ASSERT_TRUE(eventually([&] { return !arena().underMouse(); }));
  arena().select(1);
  arena().setFocus();
  find<QAction>("focus_tip")->trigger();
  const core::Pose before = *arena().scene().pose(1);
  ASSERT_TRUE(QToolTip::text().contains(QStringLiteral("Robot 2")));
  // Farther than the robot's body: nothing is left where the tip was asked for.
  ASSERT_TRUE(eventually([&] { return core::distance(*arena().scene().pose(1), before) > 0.1; }));
  EXPECT_TRUE(eventually([&] { return tells("Robot 2"); })) << QToolTip::text().toStdString();

  // The same for a mouse that rests; then it leaves.
  QHelpEvent rests(QEvent::ToolTip, robot(1), arena().mapToGlobal(robot(1)));
  QCoreApplication::sendEvent(&arena(), &rests);
  EXPECT_TRUE(eventually([&] { return tells("Robot 2"); }));
  QEvent leaves(QEvent::Leave);
  QCoreApplication::sendEvent(&arena(), &leaves);
  EXPECT_TRUE(eventually([&] { return !QToolTip::isVisible(); })) << "it stays for ever";
}

TEST_F(Arena, LeavesRealRobotsAloneAndSaysWhy) {
  start();
  app::Experiment real = live().experiment();
  real.robots[1].link = app::RobotSpec::Link::device;
  const app::TickRecord seen = record();  // the arena alone: no robot is there to be opened
  ArenaView alone;
  alone.resize(640, 480);
  alone.show();
  alone.show_experiment(real);
  alone.show_record(seen);
  QString why;
  int gestures = 0;
  QObject::connect(&alone, &ArenaView::refused, &alone, [&](const QString& text) { why = text; });
  QObject::connect(&alone, &ArenaView::move_wanted, &alone, [&] { ++gestures; });
  QObject::connect(&alone, &ArenaView::kick_wanted, &alone, [&] { ++gestures; });
  const core::Pose pose = *alone.scene().pose(1);
  for (const auto modifiers : {Qt::KeyboardModifiers(Qt::NoModifier), Qt::KeyboardModifiers(Qt::ShiftModifier)}) {
    why.clear();
    const QPoint at = alone.map().to_screen({pose.x, pose.y}).toPoint();
    QTest::mousePress(&alone, Qt::LeftButton, modifiers, at);
    QTest::mouseMove(&alone, at + QPoint(60, 0));
    QTest::mouseRelease(&alone, Qt::LeftButton, modifiers, at + QPoint(60, 0));
    EXPECT_TRUE(why.contains(QStringLiteral("real"))) << why.toStdString();
  }
  EXPECT_EQ(gestures, 0);
}

TEST(ArenaGround, IsThatOfTheViewThatIsShownWhateverWasDrawnBefore) {
  const app::Experiment paper = app::paper_experiment();
  const auto eight = app::parse_experiment(paper.source, "platoon.toml", {"reference.path.width=0.8"});
  ASSERT_TRUE(eight);
  using Change = std::function<void(ArenaView&)>;
  const std::vector<Change> changes{
      [](ArenaView& view) { view.zoom_in(); },
      [](ArenaView& view) { view.resize(500, 480); },
      [](ArenaView& view) { view.show_grid(false); },
      [](ArenaView& view) { view.setPalette(palette(Theme::dark)); },
      [&](ArenaView& view) { view.show_experiment(*eight); },
      [](ArenaView& view) { view.zoom_in(); },
      [](ArenaView& view) { view.show_grid(true); },
      [](ArenaView& view) {
        QFont large = view.font();
        large.setPointSizeF(2 * large.pointSizeF());
        view.setFont(large);
      },
  };
  QWidget window;
  window.resize(640, 480);
  window.show();
  const auto begin = [&](ArenaView& view) {
    view.setPalette(palette(Theme::light));
    view.show();
    view.resize(640, 480);
    view.show_experiment(paper);
  };
  ArenaView long_shown(&window);
  begin(long_shown);
  QImage before = long_shown.grab().toImage();
  for (std::size_t k = 0; k < changes.size(); ++k) {
    changes[k](long_shown);
    const QImage now = long_shown.grab().toImage();
    EXPECT_NE(now, before) << k;
    ArenaView fresh(&window);  // has drawn nothing before
    begin(fresh);
    for (std::size_t j = 0; j <= k; ++j) changes[j](fresh);
    EXPECT_EQ(now, fresh.grab().toImage()) << k;
    before = now;
  }
}

/// The last one of a camera that is frozen looks like any other.
TEST(ArenaPicture, SaysThatItIsOld) {
  app::Picture picture{
      .width = 320, .height = 240, .grey = std::vector<std::uint8_t>(320 * 240, 128), .captured_at = 5.0};
  ArenaView view;
  view.resize(640, 480);
  view.show_experiment(app::paper_experiment());
  view.set_camera([](QPointF floor) { return QPointF(160.0 + 100.0 * floor.x(), 120.0 - 100.0 * floor.y()); });
  view.show_picture(true);
  view.set_picture(picture);
  const auto has_band = [&](double now) {
    app::TickRecord record;
    record.robots.resize(4);
    record.now = now;
    view.show_record(record);
    const QImage shown = view.grab().toImage();
    const QPoint left = view.map().sheet().center().toPoint() - QPoint(view.map().sheet().toRect().width() / 2 - 4, 0);
    return shown.pixelColor(left) == colours(view.palette()).alarm_fill;
  };
  EXPECT_FALSE(has_band(5.2));
  EXPECT_EQ(view.scene().old_picture(), QString());
  EXPECT_TRUE(has_band(17.0));
  EXPECT_EQ(view.scene().old_picture(), QStringLiteral("This picture is 12 s old"));
  picture.captured_at = 17.0;
  view.set_picture(picture);
  EXPECT_FALSE(has_band(17.1));
}

TEST(ArenaHint, SaysAllOfALongHintInANarrowWindow) {
  const auto ink_at = [](int width) {
    ArenaView view;
    view.show_experiment(app::paper_experiment());
    view.set_hint(
        QStringLiteral("Drag a robot out of the formation; turn it with the mouse wheel; Shift+drag kicks it"));
    view.resize(width, 500);
    const QImage picture = view.grab().toImage();
    const QColor notice = colours(view.palette()).notice;
    int inked = 0;
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x)
        inked += std::abs(picture.pixelColor(x, y).hue() - notice.hue()) < 4 &&
                 picture.pixelColor(x, y).saturation() > notice.saturation() / 2;
    return inked;
  };
  const int wide = ink_at(1000), narrow = ink_at(240);
  EXPECT_GT(wide, 5000);
  EXPECT_GT(narrow, wide * 3 / 4) << "in one line there is room for a third of it";
}

/// How much of a robot's body is seen in the arena, among these messages. [px]
int body_seen(const QString& banner, const QString& hint, double x, double y) {
  ArenaView view;
  view.resize(620, 460);
  view.show_experiment(app::paper_experiment());
  app::TickRecord record;
  record.robots.resize(4);
  for (std::size_t i = 0; i < 4; ++i) record.robots[i].truth = {-0.9, 0.1 * static_cast<double>(i), 0.0};
  record.robots[1].truth = {x, y, 0.0};
  view.show_record(record);
  view.set_banner(banner, false);
  view.set_hint(hint);
  const QImage picture = view.grab().toImage();
  const QPoint of = view.map().to_screen({x, y}).toPoint();
  int seen = 0;
  for (int dy = -8; dy <= 8; ++dy)
    for (int dx = -8; dx <= 8; ++dx)
      seen += picture.pixelColor(of + QPoint(dx, dy)) == colours(view.palette()).robot(1);
  return seen;
}

TEST(ArenaHint, AndBannerHideNoRobotWhereThereIsRoomBesideIt) {
  const QString banner = QStringLiteral("Paused \u2013 reference and robots stand");
  const QString hint = QStringLiteral("Drag a robot out of the formation; turn it with the mouse wheel");
  for (const double y : {0.71, 0.6, 0.5, 0.0, -0.45, -0.55, -0.65}) {
    const int bare = body_seen({}, {}, 0.0, y);
    ASSERT_GT(bare, 20);
    EXPECT_GT(body_seen(banner, hint, 0.0, y), bare * 9 / 10) << "a message lies over the robot at " << y;
  }
}

/// Of robot i in eight rows of eight about the middle.
double column_of(int i) {
  const int number = i % 8;
  return number - 3.5;
}
double row_of(int i) {
  const int number = i / 8;
  return number - 3.5;
}

TEST(ArenaHint, ThatOnlyTeachesIsNotShownWhereItWouldHideRobots) {
  const auto seen = [](int robots, const QString& hint, bool gives_way) {
    ArenaView view;
    view.resize(480, 330);
    app::Experiment experiment = app::paper_experiment();
    experiment.robots.resize(static_cast<std::size_t>(robots), experiment.robots.front());
    view.show_experiment(experiment);
    view.show_couplings(false);
    app::TickRecord record;
    record.robots.resize(experiment.robots.size());
    for (int i = 0; i < robots; ++i)
      record.robots[static_cast<std::size_t>(i)].truth = {column_of(i) * 0.2, row_of(i) * 0.16, 0.0};
    view.show_record(record);
    view.set_hint(hint, gives_way);
    return view.grab().toImage();
  };
  const QString hint = QStringLiteral("Drag a robot out of the formation; turn it with the mouse wheel");
  EXPECT_EQ(seen(64, hint, true), seen(64, {}, true)) << "it lies over robots";
  EXPECT_NE(seen(64, hint, false), seen(64, {}, false)) << "control: what is asked for is always said";
  EXPECT_NE(seen(1, hint, true), seen(1, {}, true)) << "control: there is room beside one robot";
}

/// The paper's platoon of so many robots at this time, in an arena of this size; how many of its bodies a message
/// hides.
int hidden(QSize size, std::size_t robots, double t, const QString& banner, const QString& alert) {
  app::Experiment experiment = app::paper_experiment();
  experiment.robots.resize(robots, experiment.robots.front());
  for (app::RobotSpec& robot : experiment.robots) robot.start.reset();
  const auto reference = app::make_reference(experiment);
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(robots);
  for (std::size_t i = 0; i < robots; ++i) {
    record.robots[i].truth = reference->at(i, t).pose;
    record.robots[i].nominal.pose = {100.0, 100.0, 0.0};
  }
  const auto picture = [&](const QString& over, const QString& below) {
    ArenaView view;
    view.resize(size);
    view.show_experiment(experiment);
    view.show_record(record);
    view.set_banner(over, true);
    view.set_alert(below, Qt::darkRed);
    return view.grab().toImage();
  };
  ArenaMap map;
  map.resize(size);
  map.show_plan(experiment.arena_width, experiment.arena_height);
  const QImage bare = picture({}, {}), said = picture(banner, alert);
  EXPECT_NE(bare, said) << "it is not said at all";
  int count = 0;
  for (const app::RobotRecord& robot : record.robots) {
    const QPoint centre = map.to_screen({robot.truth.x, robot.truth.y}).toPoint();
    bool whole = true;
    for (int dy = -5; dy <= 5; ++dy)
      for (int dx = -5; dx <= 5; ++dx) {
        const QPoint at = centre + QPoint(dx, dy);
        whole = whole && bare.pixelColor(at) == said.pixelColor(at);
      }
    count += whole ? 0 : 1;
  }
  return count;
}

TEST(ArenaMessages, HideNoRobotOfAPlatoonInASmallWindowWhereverItIs) {
  const QSize small(512, 298);  // the arena of a window of 800x600
  const QString alert =
      QStringLiteral("LIMITED: the law commands robot 2 more than (14) or its wheels allow; it drives at its limits");
  const QString banner = QStringLiteral("STOPPED by operator \u2013 new run: Ctrl+N");
  for (const std::size_t robots : {4U, 20U})
    for (int k = 0; k < 21; ++k) {
      const double t = 4.0 * k;
      EXPECT_EQ(hidden(small, robots, t, {}, alert), 0) << robots << " robots, " << t << " s";
      EXPECT_EQ(hidden(small, robots, t, banner, {}), 0) << robots << " robots, " << t << " s";
    }
}

TEST(ArenaMessages, TouchNoBadgeOfARobot) {
  for (int k = 0; k < 40; ++k) {  // a robot just below the place of a message, nearer and nearer
    const double y = 0.2 + 0.01 * k;
    const auto seen = [&](const QString& alert, std::uint8_t mode) {
      ArenaView view;
      view.resize(620, 460);
      view.show_experiment(app::paper_experiment());
      app::TickRecord record;
      record.phase = app::Phase::running;
      record.robots.resize(4);
      for (app::RobotRecord& robot : record.robots) {
        robot.truth = robot.pose = {std::nan(""), 0.0, 0.0};
        robot.measurement.captured_at = core::Measurement::never;
        robot.nominal.pose = {100.0, 100.0, 0.0};
      }
      record.robots[0].truth = {0.0, y, 0.0};
      record.robots[0].mode = mode;
      view.show_record(record);
      view.set_alert(alert, Qt::darkRed);
      return view.grab().toImage();
    };
    const QString alert = QStringLiteral("LOST: robot 2 \u2013 no tag seen, it stands");
    const std::uint8_t braked = app::tracking | app::shielded;
    const QImage bare = seen({}, braked), said = seen(alert, braked), plain = seen({}, app::tracking);
    int badge = 0, hidden = 0;  // pixels of what the mode adds to the robot
    for (int py = 0; py < bare.height(); ++py)
      for (int px = 0; px < bare.width(); ++px)
        if (bare.pixelColor(px, py) != plain.pixelColor(px, py) && py < bare.height() - 60) {  // not of the legend
          ++badge;
          hidden += said.pixelColor(px, py) != bare.pixelColor(px, py);
        }
    ASSERT_GT(badge, 50);
    EXPECT_EQ(hidden, 0) << "at " << y;
  }
}

TEST(ArenaMessages, HideNoObstacleWhereThereIsRoomBesideIt) {
  const QString banner = QStringLiteral("STOPPED by operator \u2013 new run: Ctrl+N");
  for (const double y : {0.7, 0.6, 0.5, 0.4, 0.0, -0.4, -0.5, -0.6}) {
    app::Experiment experiment = app::paper_experiment();
    experiment.obstacles = {{0.0, y, 0.05}};
    const auto seen = [&](const QString& said) {
      ArenaView view;
      view.resize(620, 460);
      view.show_experiment(experiment);
      view.set_banner(said, true);
      view.set_hint(said, false);
      const QPoint centre = view.map().to_screen({0.0, y}).toPoint();
      return std::pair(view.grab().toImage(), QRect(centre - QPoint(8, 8), QSize(17, 17)));
    };
    const auto [bare, place] = seen({});
    const auto [said, same_place] = seen(banner);
    EXPECT_NE(bare, said);
    EXPECT_EQ(bare.copy(place), said.copy(same_place)) << "a message lies over the obstacle at " << y;
  }
}

TEST(ArenaMessages, LieNotOverWhatTheRulerMeasures) {
  ArenaView view;
  view.resize(620, 460);
  view.show_experiment(app::paper_experiment());
  view.grab();  // it has its size from here on
  view.set_tool(ArenaTool::measure);
  const QPoint from(260, 98), to(360, 98);
  QTest::mousePress(&view, Qt::LeftButton, {}, from);
  for (int k = 1; k <= 5; ++k) QTest::mouseMove(&view, from + (to - from) * k / 5);
  QTest::mouseRelease(&view, Qt::LeftButton, {}, to);
  ASSERT_TRUE(view.scene().ruler);
  const QRect numbers(260, 48, 100, 12);
  const QImage bare = view.grab().toImage();
  view.set_alert(QStringLiteral("k_yy is held at 0.1899, its limit: lower another one"), Qt::darkRed);
  const QImage said = view.grab().toImage();
  EXPECT_NE(bare, said);
  EXPECT_EQ(bare.copy(numbers), said.copy(numbers));
}

TEST(ArenaCrowd, ScaleAndLegendHideNoRobot) {
  const QSize size(512, 298);
  app::Experiment experiment = app::paper_experiment();
  ArenaView view;
  view.resize(size);
  view.show_experiment(experiment);
  app::TickRecord record;
  record.robots.resize(4);
  for (std::size_t i = 0; i < 4; ++i) {
    record.robots[i].truth = {-0.8 + 0.15 * static_cast<double>(i), -0.62, 0.0};  // on the scale
    record.robots[i].mode = app::shielded;                                        // which has a legend
  }
  record.robots[3].truth = {0.85, -0.62, 0.0};  // on the legend
  view.show_record(record);
  const QImage picture = view.grab().toImage();
  for (std::size_t i = 0; i < 4; ++i) {
    const core::Pose& pose = record.robots[i].truth;
    const QPoint centre = view.map().to_screen({pose.x, pose.y}).toPoint();
    int seen = 0;
    for (int dy = -8; dy <= 8; ++dy)
      for (int dx = -8; dx <= 8; ++dx)
        seen += picture.pixelColor(centre + QPoint(dx, dy)) == colours(view.palette()).robot(i) ? 1 : 0;
    EXPECT_GT(seen, 20) << "of robot " << i + 1;
  }
}

TEST(ArenaCrowd, LegendLeavesTheScaleReadableWhereBothHaveNoRoomSideBySide) {
  ArenaView view;
  view.resize(250, 130);
  view.show_experiment(app::paper_experiment());
  app::TickRecord record;
  record.robots.resize(4);
  for (std::size_t i = 0; i < 4; ++i) record.robots[i].truth = {-0.8 + 0.4 * static_cast<double>(i), 0.6, 0.0};
  const auto shown = [&](std::uint8_t mode) {
    for (app::RobotRecord& robot : record.robots) robot.mode = mode;
    view.show_record(record);
    return view.grab().toImage();
  };
  const QPoint corner = view.map().to_screen({-1.0, -0.75}).toPoint();
  const QRect scale(corner.x() + 12, corner.y() - 36, static_cast<int>(view.map().scale_at({0, 0})), 30);  // of 1 m
  const QImage without = shown(app::tracking), with = shown(app::stopped);
  EXPECT_NE(without, with);
  EXPECT_EQ(without.copy(scale), with.copy(scale));
}

/// Where the check list takes the arena's room, the floor is small: a long scale would hide what stands there.
TEST(ArenaScale, TakesAtMostAThirdOfTheFloor) {
  ArenaView view;
  view.show_experiment(app::paper_experiment());
  for (const QSize size : {QSize(250, 130), QSize(560, 180), QSize(560, 430), QSize(1600, 900)}) {
    view.resize(size);
    const QImage picture = view.grab().toImage();
    const QPoint corner = view.map().to_screen({-1.0, -0.75}).toPoint();
    const int floor = view.map().to_screen({1.0, -0.75}).toPoint().x() - corner.x();
    int longest = 0;
    for (int y = corner.y() - 30, run = 0; y < corner.y() - 8; ++y, run = 0)
      for (int x = corner.x() + 8; x < corner.x() + floor - 8; ++x) {
        run = picture.pixelColor(x, y).lightness() < 90 ? run + 1 : 0;
        longest = std::max(longest, run);
      }
    EXPECT_LE(longest, floor / 3 + 2) << size.width() << " x " << size.height();
    EXPECT_GE(longest, floor / 12) << size.width() << " x " << size.height() << ": the control: it is there";
  }
}

/// How the robots of a crowd are, and whether their couplings are drawn.
struct CrowdLook {
  std::uint8_t mode = app::tracking | app::shielded;
  bool couplings = false;
  int selected = -1;
};

/// 64 robots in rows, this far apart [m], on a floor of this width; `alone`: where only this one is seen.
QImage crowd(QSize size, double width, double apart, int alone = -1, CrowdLook look = {}) {
  ArenaView view;
  view.resize(size);
  app::Experiment experiment = app::paper_experiment();
  experiment.arena_width = width;
  experiment.arena_height = 0.75 * width;
  experiment.avoidance.enabled = experiment.shield.enabled = false;
  experiment.robots.resize(64, experiment.robots.front());
  view.show_experiment(experiment);
  view.show_couplings(look.couplings);
  for (std::size_t i = 0; i < 64; ++i)
    for (std::size_t j = i + 1; j < 64; ++j) view.set_coupling(i, j, 0.5);
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(64);
  for (int i = 0; i < 64; ++i) {
    app::RobotRecord& robot = record.robots[static_cast<std::size_t>(i)];
    const core::Pose pose{column_of(i) * apart, row_of(i) * apart, 0.1 * i};
    robot.nominal.pose = {100.0, 100.0, 0.0};
    robot.mode = look.mode;
    robot.measurement.captured_at = core::Measurement::never;
    robot.truth = robot.pose = {std::nan(""), 0.0, 0.0};
    if (alone < 0 || alone == i) robot.truth = pose;
  }
  view.show_record(record);
  view.select(look.selected);
  return view.grab().toImage();
}

TEST(ArenaCrowd, Of64RobotsTheCouplingsOfNeighboursAreDrawnAndThoseOfTheSelectedRobot) {
  const auto picture = [](bool couplings, int selected) {
    return crowd({480, 330}, 2.0, 0.13, -1, {.mode = app::tracking, .couplings = couplings, .selected = selected});
  };
  const auto drawn = [&](int selected) {  // pixels of couplings
    const QImage with = picture(true, selected), without = picture(false, selected);
    int pixels = 0;
    for (int y = 0; y < with.height(); ++y)
      for (int x = 0; x < with.width(); ++x) pixels += with.pixel(x, y) != without.pixel(x, y);
    return pixels;
  };
  const int neighbours = drawn(-1), of_robot_20 = drawn(19);
  EXPECT_GT(neighbours, 500);
  EXPECT_LT(neighbours, 480 * 330 / 10) << "a haze";
  EXPECT_GT(of_robot_20, neighbours + 2000);
}

TEST(ArenaCrowd, EveryNumberOf64RobotsCanBeReadWhereThereIsRoom) {
  // Robots that nearly touch in a small window, and small ones that are as far apart as their numbers need.
  for (const auto& [width, apart] : {std::pair{1.2, 0.085}, {2.0, 0.13}, {4.0, 0.25}}) {
    const QSize size(480, 330);
    const QImage all = crowd(size, width, apart);
    int least = 1000;
    for (int i = 0; i < 64; i += 3) {
      const QImage one = crowd(size, width, apart, i);
      ArenaMap map;
      map.resize(size);
      map.show_plan(width, 0.75 * width);
      const QPoint centre = map.to_screen({column_of(i) * apart, row_of(i) * apart}).toPoint();
      const QColor body = colours(QPalette()).robot(static_cast<std::size_t>(i));
      int written = 0, kept = 0;
      for (int dy = -4; dy <= 4; ++dy)
        for (int dx = -3; dx <= 3; ++dx) {
          const QPoint at = centre + QPoint(dx, dy);
          if (one.pixelColor(at) == body) continue;
          ++written;
          kept += all.pixelColor(at) == one.pixelColor(at);
        }
      ASSERT_GE(written, 4) << "of " << i + 1;
      least = std::min(least, 100 * kept / written);
      EXPECT_GE(100 * kept, 95 * written) << i + 1 << ", " << apart << " m apart on " << width << " m";
    }
    EXPECT_GE(least, 95);
  }
}

/// Two robots that look to the left, or one of them alone, with a badge each.
QImage two_robots(QPointF one, QPointF two, int alone = -1) {
  ArenaView view;
  view.resize(480, 330);
  app::Experiment experiment = app::paper_experiment();
  experiment.arena_width = 1.2;
  experiment.arena_height = 0.9;
  experiment.robots.resize(2);
  view.show_experiment(experiment);
  view.show_couplings(false);
  view.show_regions(false);
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(2);
  for (int i = 0; i < 2; ++i) {
    app::RobotRecord& robot = record.robots[static_cast<std::size_t>(i)];
    const QPointF at = i == 0 ? one : two;
    robot.nominal.pose = {100.0, 100.0, 0.0};
    robot.mode = app::tracking | app::shielded;
    robot.measurement.captured_at = core::Measurement::never;
    robot.truth = robot.pose = {std::nan(""), 0.0, 0.0};
    if (alone < 0 || alone == i) robot.truth = {at.x(), at.y(), core::pi};
  }
  view.show_record(record);
  return view.grab().toImage();
}

TEST(ArenaCrowd, ANumberLiesOverTheBodyAndTheBadgeOfANeighbour) {
  ArenaMap map;
  map.resize({480, 330});
  map.show_plan(1.2, 0.9);
  const QPointF first(0.0, 0.0);
  // The body of the second would lie on the first's number; the badge of the first on the second's.
  for (const auto& [second, i] : {std::pair(QPointF(0.035, 0.0), 0), std::pair(QPointF(0.04, 0.04), 1)}) {
    const QImage both = two_robots(first, second), one = two_robots(first, second, i);
    const QPoint centre = map.to_screen(i == 0 ? first : second).toPoint();
    const QColor ink = ink_on(colours(QPalette()).robot(static_cast<std::size_t>(i)));
    int written = 0, kept = 0;
    for (int dy = -7; dy <= 7; ++dy)
      for (int dx = -4; dx <= 7; ++dx) {  // not the notch at the left
        const QPoint at = centre + QPoint(dx, dy);
        if (one.pixelColor(at) != ink) continue;
        ++written;
        kept += both.pixelColor(at) == ink ? 1 : 0;
      }
    EXPECT_GE(written, 4) << i + 1;  // where fonts are smoothed more, few pixels are all ink
    EXPECT_EQ(kept, written) << i + 1;
  }
}

TEST(ArenaCrowd, NumbersThatHaveNoRoomAreLeftOutAndTheOthersAreWhole) {
  const QSize size(480, 330);
  constexpr double width = 4.0, apart = 0.1;  // 10 px
  ArenaMap map;
  map.resize(size);
  map.show_plan(width, 0.75 * width);
  const auto whole = [&](const QImage& all, int i) {
    const QImage one = crowd(size, width, apart, i, {.mode = app::tracking});
    const QPoint centre = map.to_screen({column_of(i) * apart, row_of(i) * apart}).toPoint();
    const QRect figures(centre - QPoint(5, 3), QSize(11, 7));
    return all.copy(figures) == one.copy(figures);
  };
  for (const int selected : {-1, 20, 21}) {
    const QImage all = crowd(size, width, apart, -1, {.mode = app::tracking, .selected = selected});
    int readable = 0;
    for (int i = 0; i < 64; ++i) readable += i == selected || whole(all, i);
    EXPECT_GE(readable, 24) << "every other in a row, at least";
  }
}

TEST(ArenaCrowd, TheNumberOfASmallRobotStandsOnItsColourAndNotOnTheFloor) {
  const QSize size(480, 330);
  constexpr double width = 4.0, apart = 0.25;
  ArenaMap map;
  map.resize(size);
  map.show_plan(width, 0.75 * width);
  const QColor floor = colours(QPalette()).floor;
  for (const int i : {0, 4, 8, 63}) {  // of one digit, and of two
    const QImage one = crowd(size, width, apart, i);
    const QPoint centre = map.to_screen({column_of(i) * apart, row_of(i) * apart}).toPoint();
    int bare = 0;
    for (int dy = -4; dy <= 4; ++dy)
      for (int dx = -2; dx <= 2; ++dx) bare += one.pixelColor(centre + QPoint(dx, dy)) == floor;
    EXPECT_EQ(bare, 0) << "the floor is seen beside the figures of " << i + 1;
  }
}

TEST_F(Arena, Of64RobotsHasEachInTheTableByTheKeyboard) {
  app::Experiment experiment = app::paper_experiment();
  experiment.perturbations.clear();
  experiment.robots.resize(64, experiment.robots.front());
  for (std::size_t i = 0; i < 64; ++i) {
    experiment.robots[i].tag = static_cast<int>(i + 1);
    experiment.robots[i].start.reset();
  }
  experiment.controller.gains = {core::PairTable(64),        core::PairTable(64),       core::PairTable(64),
                                 core::PairTable(64, 1.5),   core::PairTable(64, 0.04), core::PairTable(64, 1.5),
                                 core::PairTable(64, 100.0), core::PairTable(64, 100.0)};
  open_and_wait(experiment);
  key(Qt::Key_4, nullptr, Qt::ControlModifier);
  auto* table = find<QAbstractItemView>("robots");
  ASSERT_TRUE(eventually([&] { return table->hasFocus() && table->model()->rowCount() == 64; }));
  const auto expect_at = [&](int row, const char* how) {
    EXPECT_EQ(table->currentIndex().row(), row) << how;
    EXPECT_EQ(arena().scene().selected, row) << how;
    EXPECT_TRUE(table->viewport()->rect().contains(table->visualRect(table->currentIndex()).center())) << how;
  };
  key(Qt::Key_End, nullptr, Qt::ControlModifier);
  expect_at(63, "Ctrl+End");
  key(Qt::Key_Home, nullptr, Qt::ControlModifier);
  expect_at(0, "Ctrl+Home");
  for (int row = 1; row < 64; ++row) {
    key(Qt::Key_Down);
    expect_at(row, "Down");
  }
  const int usual = QApplication::keyboardInputInterval();
  QApplication::setKeyboardInputInterval(deadline_ms);  // two keys are one number, however busy the machine is
  for (const auto& [first, second, row] : {std::tuple{Qt::Key_4, Qt::Key_7, 46}, {Qt::Key_1, Qt::Key_2, 11}}) {
    key(first);
    key(second);
    expect_at(row, "by its number");
    table->keyboardSearch({});  // what is typed next is another number
  }
  QApplication::setKeyboardInputInterval(usual);
}

TEST_F(Arena, HasThePlotsBesideItInAWindowThatWasNarrowTheLastTime) {
  settings().clear();
  MainWindow first;
  first.resize(800, 600);
  first.show();
  const auto* behind = first.findChild<QWidget*>(QStringLiteral("plots_dock"));
  ASSERT_TRUE(eventually([&] { return first.isVisible() && behind->visibleRegion().isEmpty(); }));
  first.close();
  ASSERT_TRUE(eventually([&] { return !first.isVisible(); }));

  MainWindow second;  // begins with the first one's layout, and has more room
  second.show();
  second.resize(1280, 800);
  const auto* beside = second.findChild<QWidget*>(QStringLiteral("plots_dock"));
  const auto* gains = second.findChild<QWidget*>(QStringLiteral("gains_dock"));
  EXPECT_TRUE(eventually([&] { return !beside->visibleRegion().isEmpty() && !gains->visibleRegion().isEmpty(); }));
  second.close();
}

TEST_F(Arena, OfASmallWindowIsWiderThanThePanelsBesideIt) {
  start();
  const int plots = find("plots_dock")->width();
  find("results_dock")->raise();  // a tab that is behind another one
  window.resize(800, 600);
  EXPECT_TRUE(eventually([&] { return window.width() == 800 && arena().width() >= 480; })) << arena().width();
  EXPECT_TRUE(eventually([&] { return find("results_dock")->width() >= 240; })) << "the results cannot be read";
  find("log_dock")->raise();
  EXPECT_TRUE(eventually([&] { return find("log_dock")->width() >= 240; })) << "the events cannot be read";
  EXPECT_FALSE(find("gains_dock")->visibleRegion().isEmpty());
  find<QAction>("go_to_plots")->trigger();
  EXPECT_TRUE(eventually([&] { return !find("plots_dock")->visibleRegion().isEmpty(); }));
  window.resize(1280, 800);
  EXPECT_TRUE(eventually([&] {
    return window.width() == 1280 && std::abs(find("plots_dock")->width() - plots) < 3 &&
           !find("plots_dock")->visibleRegion().isEmpty() && !find("gains_dock")->visibleRegion().isEmpty();
  })) << "plots and gains are beside the arena again";
}

}  // namespace
}  // namespace skein::ui::test
