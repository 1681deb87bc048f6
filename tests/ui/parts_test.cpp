// The window's parts on their own.
#include <gtest/gtest.h>

#include <QAccessible>
#include <QApplication>
#include <QClipboard>
#include <QFileDialog>
#include <QLineEdit>
#include <QRegularExpression>
#include <QSignalSpy>
#include <QTableView>
#include <QTemporaryDir>
#include <QTest>
#include <array>
#include <cmath>
#include <memory>
#include <tuple>

#include "app/experiment/experiment_file.h"
#include "ui/arena/arena_map.h"
#include "ui/arena/arena_view.h"
#include "ui/base/dialogs.h"
#include "ui/base/modes.h"
#include "ui/base/number_field.h"
#include "ui/base/why.h"
#include "ui/gains/pair_table.h"
#include "ui/main/help.h"
#include "ui/robots/robots_model.h"
#include "ui/run/replay_run.h"
#include "ui/run/run_history.h"
#include "ui/status/alert_strip.h"
#include "ui/status/event_log.h"

namespace skein::ui::test {
namespace {

/// Two robots of a running experiment, so far apart along x [m]; the law drives both.
app::TickRecord two_robots(double apart = 0.0) {
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(2);
  for (app::RobotRecord& robot : record.robots) {
    robot.truth = {0.0, 0.0, 0.0};
    robot.pose_age = 0.04;
    robot.law = {0.14, 0.2};
  }
  record.robots[1].truth.x = apart;
  return record;
}

TEST(Why, SaysInOneSentenceWhatGovernsARobot) {
  const Circumstances now;
  app::TickRecord record = two_robots(0.091);
  app::RobotRecord& r = record.robots[0];
  r.command = {0.03, 0.2};
  r.error = {0.02, 0.0, 0.0};
  r.mode = app::tracking;
  EXPECT_TRUE(why(record, 0, now).contains(QStringLiteral("2.0 cm off"))) << why(record, 0, now).toStdString();
  r.mode = app::tracking | app::limited;
  r.limits = app::limit_v;
  EXPECT_TRUE(why(record, 0, now).contains(QStringLiteral("asks 0.140 m/s"))) << why(record, 0, now).toStdString();
  r.mode = app::tracking | app::shielded | app::limited;
  EXPECT_TRUE(why(record, 0, now).contains(QStringLiteral("0.030 m/s"))) << why(record, 0, now).toStdString();
  EXPECT_TRUE(why(record, 0, now).contains(QStringLiteral("robot 2, 9.1 cm"))) << why(record, 0, now).toStdString();
  r.mode = app::stopped | app::lost;
  r.pose_age = 0.45;
  EXPECT_TRUE(why(record, 0, now).contains(QStringLiteral("not seen"))) << why(record, 0, now).toStdString();
}

TEST(Why, NamesALinkAndALawThatGiveNoNumberAndNotAHandThatHoldsNobody) {
  Circumstances now;
  now.held = {0};
  app::TickRecord record = two_robots();
  app::RobotRecord& r = record.robots[0];
  const auto says = [&](const char* words) {
    EXPECT_TRUE(why(record, 0, now).contains(QLatin1String(words))) << why(record, 0, now).toStdString();
  };
  r.mode = app::stopped;
  says("held");
  now.held.clear();
  EXPECT_FALSE(why(record, 0, now).contains(QStringLiteral("held"))) << "by nobody";
  now.disobedient = {0};
  says("did not drive as it was commanded");
  now.disobedient.clear();
  for (const app::Phase phase : {app::Phase::running, app::Phase::staging}) {
    record.phase = phase;
    r.mode = app::stopped | app::late;
    says("stands: its link");
    EXPECT_FALSE(why(record, 0, now).contains(QStringLiteral("held"))) << "nobody can let it go";
    r.mode = app::stopped;
    EXPECT_FALSE(why(record, 0, now).contains(QStringLiteral("drives"))) << "it stands";
    r.law = {app::none, app::none};
    says("no number");
    r.law = {0.14, 0.2};
    r.mode = app::tracking | app::late;
    r.command = {0.07, 0.1};
    says("slowed to 0.070 m/s (the law asks 0.140 m/s): its link");
  }
}

TEST(Why, NamesTheObstacleOrTheEdgeThatARobotIsSlowedFor) {
  const app::Experiment experiment = app::paper_experiment();
  Circumstances now(experiment);
  app::TickRecord record = two_robots(0.2);
  app::RobotRecord& r = record.robots[0];
  r.command = {0.03, 0.2};
  r.nominal.pose = {0.05, 0.0, 0.0};
  const auto says = [&](const char* words) {
    EXPECT_TRUE(why(record, 0, now).contains(QLatin1String(words))) << why(record, 0, now).toStdString();
  };
  r.mode = app::tracking | app::shielded;
  says("for robot 2, 20.0 cm away");
  record.events.clear();
  record.events.add(app::events::PutObstacle{1, {0.0, 0.1, 0.04}});
  now.note(record);
  says("0.030 m/s (the law asks 0.140 m/s) for obstacle 2, 2.5 cm between them");
  r.mode = app::avoiding;
  says("drives round obstacle 2, 2.5 cm between them, 5.0 cm from its place");
  record.events.clear();
  record.events.add(app::events::PutObstacle{1, {}});
  now.note(record);
  says("on a detour, 5.0 cm from its place");
  EXPECT_FALSE(why(record, 0, now).contains(QStringLiteral("robot 2"))) << "which is too far away";
  r.mode = app::tracking | app::shielded;
  r.truth.x = 0.5 * experiment.arena_width - 0.06;
  says("for the arena's edge, 2.5 cm between them");
}

TEST(Why, SaysThatARobotWasMovedUntilItIsInPlaceAgain) {
  Circumstances now(app::paper_experiment());
  app::TickRecord record = two_robots();
  app::RobotRecord& r = record.robots[1];
  r.mode = app::tracking;
  r.error = {0.0, 0.0, 0.0};
  const auto at = [&](double t, double error) {
    record.t = t;
    r.error.x = error;
    now.note(record);
    record.events.clear();
    return why(record, 1, now).toStdString();
  };
  EXPECT_EQ(at(1.0, 0.0), "tracks its place, 0.0 cm off");
  record.events.add(app::events::Move{1, {0.1, 0.0, 0.0}});
  EXPECT_EQ(at(2.0, 0.0), "tracks its place, 0.0 cm off; moved by hand 0.0 s ago") << "its camera is not as fast";
  EXPECT_EQ(at(3.5, 0.04), "tracks its place, 4.0 cm off; moved by hand 1.5 s ago");
  EXPECT_EQ(at(5.0, 0.009), "tracks its place, 0.9 cm off");
  EXPECT_EQ(at(9.0, 0.04), "tracks its place, 4.0 cm off") << "something else drove it away";
  record.events.add(app::events::Kick{1, 0.5, 0.0});
  EXPECT_EQ(at(10.0, 0.04), "tracks its place, 4.0 cm off; kicked 0.0 s ago");
  record.events.add(app::events::Perturb{1, 0.1, 0.0, 0.0});
  EXPECT_EQ(at(11.0, 0.04), "tracks its place, 4.0 cm off; pushed by the experiment 0.0 s ago");
}

TEST(Help, NamesReplaysBesideSimulationsWhereTheKeysServeBoth) {
  for (const QString& keys : {QStringLiteral("F6"), QStringLiteral("Ctrl+Up, Ctrl+Down")}) {
    const QString text = shortcuts_text();
    const qsizetype row = text.indexOf(keys);
    ASSERT_GE(row, 0) << keys.toStdString();
    const QString told = text.mid(row, text.indexOf(QStringLiteral("</tr>"), row) - row);
    EXPECT_TRUE(told.contains(QStringLiteral("simulation")) && told.contains(QStringLiteral("replay")))
        << told.toStdString();
  }
}

TEST(EventLog, CutsNoSentenceOff) {
  EventLog log;
  log.resize(280, 400);
  log.show();
  const QString sentence = QStringLiteral(
      "STOPPED: robot 3: the link is stale, its battery is low, and it has not acknowledged its stop since 18.04 s");
  log.note(1.0, QStringLiteral("start"), Severity::note);
  log.note(2.0, sentence, Severity::alarm);
  const auto needed = [&](const QString& text) {
    const int width = log.columnWidth(EventModel::event) - 8;  // the cell's own margins
    return log.fontMetrics().boundingRect(QRect(0, 0, width, 10000), Qt::TextWordWrap, text).height();
  };
  EXPECT_GE(log.rowHeight(1), needed(sentence));
  EXPECT_GT(log.rowHeight(1), 2 * log.rowHeight(0)) << "the control: it needs several lines";
  log.resize(1400, 400);
  EXPECT_TRUE(QTest::qWaitFor([&] { return log.rowHeight(1) == log.rowHeight(0); })) << "one line is enough now";
  log.resize(280, 400);
  EXPECT_TRUE(QTest::qWaitFor([&] { return log.rowHeight(1) >= needed(sentence); }));
  log.filter().set_words(QStringLiteral("start"));
  log.filter().set_words({});
  EXPECT_GE(log.rowHeight(1), needed(sentence)) << "after it was filtered away and came back";
  EXPECT_TRUE(log.model()->index(1, EventModel::event).data(Qt::ToolTipRole).toString().startsWith(sentence));
}

TEST(EventLog, BreaksLongNamesOfFiles) {
  EventLog log;
  log.resize(280, 400);
  log.show();
  const QString folder = QStringLiteral("/home/operator/.local/share/skein/runs/2026-11-22_143133_platoon-loopback");
  log.note(1.0, QStringLiteral("Kept in ") + folder, Severity::good);
  const QModelIndex cell = log.model()->index(0, EventModel::event);
  const int room = log.columnWidth(EventModel::event) - 8;
  for (const QString& piece : cell.data().toString().split(QRegularExpression(QStringLiteral("[ \u200b]"))))
    EXPECT_LE(log.fontMetrics().horizontalAdvance(piece), room) << piece.toStdString();
  EXPECT_EQ(cell.data(Qt::AccessibleTextRole).toString(), QStringLiteral("Kept in ") + folder);
  log.selectAll();
  QTest::keyClick(&log, Qt::Key_C, Qt::ControlModifier);
  EXPECT_TRUE(QApplication::clipboard()->text().endsWith(folder)) << "what is copied is the folder's name";
}

TEST(Dialogs, StandClearOfStopOnEveryScreen) {
  for (const QSize size : {QSize(800, 600), QSize(1280, 800), QSize(2560, 1440)}) {
    const QRect screen(QPoint(), size), stop(size.width() - 160, 56, 150, 56);
    for (const QSize wanted : {QSize(380, 200), QSize(784, 552), QSize(980, 744), QSize(2560, 1440)}) {
      QRect dialog(QPoint(), wanted);
      dialog.moveCenter(screen.center());
      const QRect clear = clear_of(dialog, stop, screen);
      EXPECT_FALSE(clear.intersects(stop)) << size.width() << ": " << wanted.width();
      EXPECT_TRUE(screen.contains(clear) || clear == dialog);
      EXPECT_TRUE(clear.size() == wanted || !dialog.intersects(stop) || clear.width() == stop.left() ||
                  clear.height() == size.height() - stop.bottom() - 1)
          << "smaller than need be";
      if (!dialog.intersects(stop)) {
        EXPECT_EQ(clear, dialog) << "moved without need";
      }
    }
  }
}

TEST(ArenaMap, ACircleLooksRoundHoweverLargeItIs) {
  ArenaMap map;
  map.show_plan(2.0, 1.5);
  map.resize({800, 600});
  for (const double radius : {0.002, 0.01, 0.035, 0.1, 0.3}) {
    const QPolygonF circle = map.outline({0.0, 0.0}, radius, radius);
    const double pixels = radius * map.scale_at({0.0, 0.0});
    const QPointF centre = map.to_screen({0.0, 0.0});
    EXPECT_EQ(circle.first(), circle.last());
    for (qsizetype k = 1; k < circle.size(); ++k) {
      const QPointF middle = (circle[k - 1] + circle[k]) / 2 - centre;
      EXPECT_NEAR(std::hypot(middle.x(), middle.y()), pixels, 0.15) << radius;
    }
  }
}

TEST(ArenaMap, GoesThereAndBack) {
  ArenaMap map;
  map.resize({700, 500});
  map.show_plan(2.0, 1.5);
  map.zoom(3.0, {100, 400});
  map.pan({30, -20});
  for (const QPointF floor : {QPointF(0, 0), QPointF(0.7, -0.4), QPointF(-0.9, 0.7)}) {
    const QPointF back = map.to_floor(map.to_screen(floor));
    EXPECT_NEAR(back.x(), floor.x(), 1e-12);
    EXPECT_NEAR(back.y(), floor.y(), 1e-12);
  }
}

TEST(ArenaMap, FollowsACurvedLensBothWays) {
  ArenaMap map;
  map.resize({700, 500});
  map.show_picture({1280, 960}, [](QPointF p) {  // a camera that bulges
    const double k = 1.0 - 0.08 * (p.x() * p.x() + p.y() * p.y());
    return QPointF(640 + 560 * k * p.x(), 480 - 560 * k * p.y());
  });
  for (const QPointF floor : {QPointF(0, 0), QPointF(0.7, -0.4), QPointF(-0.9, 0.7)}) {
    const QPointF back = map.to_floor(map.to_screen(floor));
    EXPECT_NEAR(back.x(), floor.x(), 1e-5);
    EXPECT_NEAR(back.y(), floor.y(), 1e-5);
  }
  EXPECT_TRUE(map.sheet().width() / map.sheet().height() - 1280.0 / 960.0 < 1e-9) << "the picture is bent";
}

TEST(ArenaMap, KeepsWhatIsUnderThePointer) {
  ArenaMap map;
  map.resize({700, 500});
  map.show_plan(2.0, 1.5);
  const QPointF pointer(420, 180);
  const QPointF before = map.to_floor(pointer);
  map.zoom(2.5, pointer);
  const QPointF after = map.to_floor(pointer);
  EXPECT_NEAR(before.x(), after.x(), 1e-12);
  EXPECT_NEAR(before.y(), after.y(), 1e-12);
}

app::TickRecord standing(const app::Experiment& experiment) {
  app::TickRecord record;
  record.robots.resize(experiment.robots.size());
  record.delta.resize(experiment.robots.size() - 1);
  for (std::size_t i = 0; i < record.robots.size(); ++i) {
    record.robots[i].pose = {0.2 * static_cast<double>(i), 0.0, 0.0};
    record.robots[i].measurement = {record.robots[i].pose, 0.0};
  }
  return record;
}

TEST(ArenaView, LeavesRealRobotsToRealHands) {
  app::Experiment experiment = app::paper_experiment();
  experiment.robots[1].link = app::RobotSpec::Link::device;
  ArenaView arena;
  arena.resize(700, 500);
  arena.show_experiment(experiment);
  arena.show_record(standing(experiment));
  arena.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&arena));
  const QSignalSpy refused(&arena, &ArenaView::refused), moved(&arena, &ArenaView::move_wanted);
  const QPoint real = arena.map().to_screen({0.2, 0.0}).toPoint();
  QTest::mousePress(&arena, Qt::LeftButton, {}, real);
  QTest::mouseMove(&arena, real + QPoint(50, 50));
  QTest::mouseRelease(&arena, Qt::LeftButton, {}, real + QPoint(50, 50));
  EXPECT_EQ(refused.count(), 1);
  EXPECT_EQ(moved.count(), 0);
}

TEST(ArenaScene, DrawsNoLineWhereAHandCarriedARobot) {
  const app::Experiment experiment = app::paper_experiment();
  ArenaScene scene;
  scene.reset(experiment);
  app::TickRecord record = standing(experiment);
  for (const double x : {0.0, 0.002, 0.004, 0.3, 0.302}) {
    record.t += 0.04;
    record.robots[0].pose.x = x;
    scene.show_record(record);
  }
  ASSERT_EQ(scene.trails[0].size(), 5u);
  EXPECT_TRUE(scene.trails[0][3].jump);
  EXPECT_FALSE(scene.trails[0][4].jump);
  record.t += 100.0;
  scene.show_record(record);
  EXPECT_TRUE(scene.trails[0].size() <= 1) << "trails fade";
}

TEST(Numbers, ThatCanBeReadInTwoWaysAreNotTakenAndBothAreNamed) {
  for (const auto& [text, one, other] : {std::tuple("1,000", "1.000", "1000"), {"-12,345", "-12.345", "-12345"}}) {
    EXPECT_EQ(parse_number(QString::fromLatin1(text)), std::nullopt) << text;
    const QString readings = why_refused(QString::fromLatin1(text), QStringLiteral("a number"));
    EXPECT_TRUE(readings.contains(QStringLiteral(" %1 ").arg(QLatin1String(one)))) << readings.toStdString();
    EXPECT_TRUE(readings.contains(QStringLiteral(" %1:").arg(QLatin1String(other)))) << readings.toStdString();
  }
  for (const auto& [text, number] : {std::pair("0,125", 0.125),
                                     {"1,5", 1.5},
                                     {"1,00", 1.0},
                                     {"1,0000", 1.0},
                                     {"1234,567", 1234.567},
                                     {"1.000", 1.0},
                                     {",125", 0.125}})
    EXPECT_EQ(parse_number(QString::fromLatin1(text)), number) << text;
  EXPECT_EQ(parse_number(QStringLiteral("1,000,000")), std::nullopt);
}

TEST(NumberField, ReadsACommaAndSaysWhyANumberIsNotTaken) {
  NumberField field;
  field.setDecimals(1);
  field.setRange(0.0, 600.0);
  field.setSuffix(QStringLiteral(" s"));
  field.setSpecialValueText(QStringLiteral("at once"));
  QString refused;
  QObject::connect(&field, &NumberField::refused, &field, [&](const QString& why) { refused = why; });
  const auto type = [&](const char* text) {
    refused.clear();
    field.selectAll();
    QTest::keyClicks(&field, QString::fromLatin1(text));
    QTest::keyClick(&field, Qt::Key_Return);
    return field.value();
  };
  EXPECT_EQ(field.text(), QStringLiteral("at once"));
  EXPECT_EQ(type("1,5"), 1.5);
  EXPECT_TRUE(refused.isEmpty()) << refused.toStdString();
  EXPECT_EQ(type("2,000"), 1.5) << "nobody knows whether 2 or 2000 is meant";
  EXPECT_TRUE(refused.contains(QStringLiteral("2.000 or 2000"))) << refused.toStdString();
  EXPECT_EQ(type("1.2.3"), 1.5);
  EXPECT_TRUE(refused.contains(QStringLiteral("found 1.2.3"))) << refused.toStdString();
  EXPECT_EQ(type("0"), 0.0);
  EXPECT_EQ(field.text(), QStringLiteral("at once"));
  QTest::keyClick(&field, Qt::Key_Return);
  EXPECT_TRUE(refused.isEmpty()) << refused.toStdString();
}

TEST(NumberField, SaysWhatItTakesOfANumberBeyondItsRange) {
  NumberField field;
  field.setDecimals(1);
  field.setRange(0.0, 600.0);
  field.setSuffix(QStringLiteral(" s"));
  field.setSpecialValueText(QStringLiteral("at once"));
  QString told;
  QObject::connect(&field, &NumberField::refused, &field, [&](const QString& why) { told = why; });
  const auto type = [&](const char* text) {
    told.clear();
    field.selectAll();
    QTest::keyClicks(&field, QString::fromLatin1(text));
    QTest::keyClick(&field, Qt::Key_Return);
    return field.value();
  };
  EXPECT_EQ(type("700"), 600.0);
  EXPECT_EQ(told.toStdString(), "found 700, allowed: 0.0 to 600.0; 600.0 s is taken");
  EXPECT_EQ(field.text().toStdString(), "600.0 s");
  EXPECT_EQ(type("-1"), 0.0);
  EXPECT_EQ(told.toStdString(), "found -1, allowed: 0.0 to 600.0; 0.0 s is taken");
  EXPECT_EQ(type("600"), 600.0) << "control";
  EXPECT_EQ(told.toStdString(), "");
}

TEST(PairTable, ShowsSmallGainsOfManyRobotsWhole) {
  PairTable table;
  table.resize(250, 300);
  table.show();
  constexpr std::size_t robots = 20;
  table.show_robots(robots);
  table.refresh([](core::GainName, std::size_t, std::size_t) { return PairModel::Pair{0.00126, 0.1, true}; });
  const auto* cells = static_cast<const QTableView*>(table.cells());
  const QString text = cells->model()->index(0, 1).data().toString();
  EXPECT_EQ(text, QStringLiteral("0.00126"));
  EXPECT_GE(cells->columnWidth(1), cells->fontMetrics().horizontalAdvance(text) + 6) << "cut off";
}

TEST(ReplayRun, SaysWhichRecordedBatteryIsLow) {
  auto recorded = std::make_shared<app::RecordedRun>();
  recorded->experiment = app::paper_experiment();
  recorded->experiment.robots[3].type = core::find_robot_type("khepera4");
  app::TickRecord row = standing(recorded->experiment);
  const std::array volts{3.4, 3.9, app::none, 6.5};
  for (std::size_t i = 0; i < volts.size(); ++i) row.robots[i].link.battery = volts[i];
  recorded->rows = {row};
  ReplayRun run;
  run.load(recorded);
  std::vector<bool> low;
  for (const app::RobotStatus& robot : run.robots()) low.push_back(robot.battery_low);
  EXPECT_EQ(low, (std::vector{true, false, false, true}));
}

TEST(RunHistory, KeepsTheRunOnly) {
  RunHistory history;
  app::TickRecord record;
  record.events.add(app::events::Move{});
  history.add(record);  // a move while robots stand ready is no row of the run
  EXPECT_EQ(history.size(), 0u);
  record.phase = app::Phase::running;
  history.add(record);
  record.phase = app::Phase::paused;
  history.add(record);  // something happened
  record.events.clear();
  history.add(record);  // nothing did
  EXPECT_EQ(history.size(), 2u);
}

TEST(RunHistory, IsBounded) {
  RunHistory history(100 * sizeof(app::TickRecord));
  app::TickRecord record;
  record.phase = app::Phase::running;
  for (int tick = 0; tick < 250; ++tick) {
    record.tick = tick;
    history.add(record);
  }
  EXPECT_EQ(history.size(), 100u);
  EXPECT_EQ(history.dropped(), 150u);
  EXPECT_EQ(history.rows().front()->tick, 150);
}

TEST(Modes, ShowTheGravest) {
  const Colours c = colours(palette(Theme::light));
  EXPECT_EQ(mode_style(app::lost | app::stopped | app::tracking, c).mode, app::lost);
  EXPECT_EQ(mode_style(app::avoiding | app::shielded | app::limited, c).mode, app::shielded);
  EXPECT_TRUE(mode_style(app::tracking, c).symbol.isEmpty());
  EXPECT_EQ(mode_text(app::avoiding | app::limited), QStringLiteral("avoiding+limited"));
}

TEST(RobotsModel, SaysWhatIsWrongWithALink) {
  const app::Experiment experiment = app::paper_experiment();
  RobotsModel model;
  model.set_colours(colours(palette(Theme::light)));
  model.show_experiment(experiment);
  std::vector<app::RobotStatus> links(4);
  links[2].link = app::LinkState::failed;
  links[2].reason = "no route to it";
  links[2].round_trip = 0.0123;
  model.show_record(standing(experiment), {links});
  const auto cell = [&](int column, int role) { return model.data(model.index(2, column), role); };
  EXPECT_EQ(cell(RobotsModel::link, Qt::DisplayRole).toString(), QStringLiteral("failed"));
  EXPECT_TRUE(cell(RobotsModel::link, Qt::ToolTipRole).toString().contains(QStringLiteral("no route to it")));
  EXPECT_EQ(cell(RobotsModel::round_trip, Qt::DisplayRole).toString(), QStringLiteral("12.3 ms"));
  EXPECT_TRUE(cell(RobotsModel::link, Qt::ForegroundRole).isValid());
}

TEST(RobotsModel, SaysWhyThereIsADash) {
  app::Experiment experiment = app::paper_experiment();
  experiment.robots[1].link = app::RobotSpec::Link::loopback;
  RobotsModel model;
  model.show_experiment(experiment);
  std::vector<app::RobotStatus> links(experiment.robots.size());
  const auto tip = [&](int robot, RobotsModel::Column column) {
    const QModelIndex cell = model.index(robot, column);
    EXPECT_EQ(cell.data(), RobotsModel::nothing());
    return cell.data(Qt::ToolTipRole).toString();
  };
  for (const bool recorded : {false, true}) {
    RobotsModel::Known known{links};
    known.recorded = recorded;
    model.show_record(standing(experiment), known);
    for (const auto column : {RobotsModel::round_trip, RobotsModel::battery, RobotsModel::firmware}) {
      EXPECT_TRUE(tip(0, column).contains(QStringLiteral("without a link"))) << tip(0, column).toStdString();
      EXPECT_EQ(tip(1, column).contains(QStringLiteral("recording")), recorded) << tip(1, column).toStdString();
      EXPECT_GT(tip(1, column).size(), 15) << tip(1, column).toStdString();
    }
  }
}

TEST(RobotsModel, PrintsNoSignBeforeTheZerosOfWheelsThatStand) {
  const app::Experiment experiment = app::paper_experiment();
  RobotsModel model;
  model.show_experiment(experiment);
  app::TickRecord record = standing(experiment);
  record.robots[0].wheels = {-0.0, -0.3};
  record.robots[1].wheels = {-412.0, 0.4};
  model.show_record(record, {});
  const auto wheels = [&](int row) {
    return model.data(model.index(row, RobotsModel::wheels), Qt::DisplayRole).toString();
  };
  EXPECT_EQ(wheels(0), QStringLiteral("0 / 0"));
  EXPECT_EQ(wheels(1), QStringLiteral("-412 / 0"));
}

TEST(ArenaView, PrintsNoSignBeforeTheZerosOfARobotsPlace) {
  const app::Experiment experiment = app::paper_experiment();
  ArenaView view;
  view.show_experiment(experiment);
  app::TickRecord record = standing(experiment);
  record.robots[0].truth = {-0.0004, -0.0, -0.001};
  view.show_record(record);
  const QAccessibleInterface* const told = QAccessible::queryAccessibleInterface(&view);
  const QString spoken = told->text(QAccessible::Value) + told->text(QAccessible::Description);
  EXPECT_TRUE(spoken.contains(QStringLiteral("Robot 1 at x 0.00 m, y 0.00 m, heading 0°"))) << spoken.toStdString();
}

TEST(AlertStrip, SaysThatLimitsBiteAsLongAsTheyDo) {
  AlertStrip strip;
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(2);
  const auto drive = [&](double from, double to, std::uint8_t mode) {
    constexpr double period = 0.04;
    const auto ticks = static_cast<int>(std::lround(std::ceil((to - from) / period - 1e-9)));
    for (int k = 0; k < ticks; ++k) {
      record.t = from + period * k;
      record.robots[1].mode = mode;
      strip.show_record(record);
    }
    return strip.text();
  };
  EXPECT_FALSE(drive(0.0, 0.8, app::limited).contains(QStringLiteral("LIMITED"))) << "a short one is no news";
  EXPECT_TRUE(drive(0.8, 2.0, app::limited).contains(QStringLiteral("robot 2")));
  EXPECT_FALSE(drive(2.0, 2.1, app::tracking).contains(QStringLiteral("LIMITED"))) << "it is over";
}

TEST(AlertStrip, SaysThatThereIsNoRouteUntilTheRobotDrives) {
  AlertStrip strip;
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(3);
  const auto drive = [&](double seconds, double v) {
    for (const double end = record.t + seconds; record.t < end; record.t += 0.04) {
      record.robots[2].command.v = v;
      strip.show_record(record);
      record.events.clear();
    }
    return strip.text();
  };
  record.events.add(app::events::NoWay{2, app::events::nobody, 0.0018});
  EXPECT_TRUE(drive(20.0, 0.0).contains(QStringLiteral("Robot 3 waits: no route to its place leaves the 1.8 mm")))
      << strip.text().toStdString();
  EXPECT_FALSE(drive(1.0, 0.08).contains(QStringLiteral("waits"))) << "it drives";
  record.events.add(app::events::NoWay{0});
  record.events.add(app::events::NoWay{2});
  EXPECT_TRUE(drive(1.0, 0.0).contains(QStringLiteral("Robots 1, 3 stand"))) << strip.text().toStdString();
  record.phase = app::Phase::paused;
  EXPECT_TRUE(drive(1.0, 0.0).contains(QStringLiteral("Robots 1, 3 stand"))) << "a pause finds no route";
  record.phase = app::Phase::stopped;
  EXPECT_FALSE(drive(0.1, 0.0).contains(QStringLiteral("stand"))) << "the run is over";
  record.phase = app::Phase::staging;
  record.events.add(app::events::NoWay{2});
  EXPECT_TRUE(drive(1.0, 0.08).contains(QStringLiteral("Robot 3 stands: there is no route to its place")))
      << "on the way to the starts too, and long enough to be read where it drives on at once";
  EXPECT_FALSE(drive(3.0, 0.08).contains(QStringLiteral("stands")));
}

TEST(FileDialog, BeginsInTheNearestFolderThatExists) {
  QTemporaryDir folder;
  QWidget window;
  const auto directory_for = [&](const QString& asked) {
    QFileDialog* dialog = file_dialog(&window, {QStringLiteral("Open"), QStringLiteral("test_dialog"), {}, asked, {}});
    const QString begins = dialog->directory().path();
    const bool file_named = !dialog->findChild<QLineEdit*>()->text().isEmpty();
    delete dialog;
    EXPECT_FALSE(file_named) << "the folder's name, taken for a file's";
    return begins;
  };
  EXPECT_EQ(directory_for(folder.path()), folder.path());
  EXPECT_EQ(directory_for(folder.filePath(QStringLiteral("skein/runs"))), folder.path());
}

TEST(FileDialog, OffersFoldersAtItsSideThatExist) {
  QTemporaryDir folder;
  QWidget window;
  const auto side_with = [&](const QStringList& places) {
    QFileDialog* dialog =
        file_dialog(&window, {QStringLiteral("Open"), QStringLiteral("test_dialog"), {}, {}, {}, places});
    const QList<QUrl> side = dialog->sidebarUrls();
    delete dialog;
    return side;
  };
  const QUrl offered = QUrl::fromLocalFile(folder.path());
  const QList<QUrl> bare = side_with({}), side = side_with({folder.path(), folder.filePath(QStringLiteral("none"))});
  EXPECT_EQ(side.size(), bare.size() + 1) << "what was there stays, and what does not exist is not offered";
  EXPECT_EQ(side.count(offered), 1);
  EXPECT_EQ(side_with({folder.path()}).count(offered), 1) << "once more each time";
}

TEST(AlertStrip, SaysWhyARobotIsNotSeenAsLongAsItIsLost) {
  for (const core::NotSeen why : core::all_of<core::NotSeen>()) {
    AlertStrip strip;
    app::TickRecord record;
    record.phase = app::Phase::running;
    record.robots.resize(2);
    const auto take = [&](app::Event event) {
      record.events.clear();
      record.events.add(event);
      strip.show_record(record);
      return strip.text();
    };
    const QString unexplained = take(app::events::Lost{1});
    const QString explained = take(app::events::NotSeen{1, why});
    EXPECT_TRUE(explained.startsWith(QStringLiteral("LOST: robot 2 ("))) << explained.toStdString();
    EXPECT_GT(explained.size(), unexplained.size() + 15) << "a sentence, not a word: " << explained.toStdString();
    EXPECT_EQ(strip.severity(), Severity::alarm);
    EXPECT_EQ(strip.lost_robots(), QStringLiteral("2"));
    EXPECT_FALSE(take(app::events::Found{1}).contains(QStringLiteral("LOST")));
  }
}

TEST(AlertStrip, SaysWhyALinkIsLostAndSoDoesTheLog) {
  const std::vector<app::RobotStatus> robots{{}, {.link = app::LinkState::stale, .reason = "no reply within 0.5 s"}};
  for (const bool lost : {true, false}) {
    app::TickRecord record;
    record.phase = app::Phase::running;
    record.robots.resize(2);
    record.events.add(app::events::Link{1, lost ? app::LinkState::stale : app::LinkState::up});
    AlertStrip strip;
    strip.show_record(record, robots);
    EventPanel panel;
    panel.show_record(record, robots);
    auto* const log = panel.findChild<QTableView*>();
    const QString row = log->model()->index(0, log->model()->columnCount() - 1).data().toString();
    for (const QString& said : {strip.text(), row}) {
      EXPECT_TRUE(said.contains(QStringLiteral("link of robot 2 is"))) << said.toStdString();
      EXPECT_EQ(said.contains(QStringLiteral("no reply within 0.5 s")), lost) << said.toStdString();
    }
  }
}

TEST(AlertStrip, SaysEveryStateThatLastsTheGravestFirst) {
  AlertStrip strip;
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(3);
  const auto take = [&](double t, std::optional<app::Event> event = {}) {
    record.t = t;
    record.events.clear();
    if (event) record.events.add(*event);
    strip.show_record(record);
    return strip.text();
  };
  strip.warn_unguarded(QStringLiteral("NO GUARD"));
  EXPECT_EQ(strip.text(), QStringLiteral("NO GUARD"));
  EXPECT_TRUE(take(1.0, app::events::VRise{}).startsWith(QStringLiteral("V RISES")));
  record.robots[2].link.state = app::LinkState::stale;
  const QString all = take(1.1, app::events::Lost{0});
  EXPECT_TRUE(all.startsWith(QStringLiteral("LOST: robot 1"))) << all.toStdString();
  EXPECT_TRUE(all.contains(QStringLiteral("LINK DOWN: robot 3 (stale)"))) << all.toStdString();
  EXPECT_TRUE(all.contains(QStringLiteral("NO GUARD"))) << all.toStdString();
  EXPECT_EQ(strip.severity(), Severity::alarm);
  EXPECT_EQ(strip.loud(), all);
  strip.say(QStringLiteral("Saved"), Severity::good);
  EXPECT_EQ(strip.text(), all) << "an alarm is not talked over";
  record.robots[2].link.state = app::LinkState::up;
  take(8.0, app::events::Found{0});
  EXPECT_EQ(strip.text(), QStringLiteral("All robots are seen")) << "for a moment";
  EXPECT_FALSE(strip.loud().contains(QStringLiteral("LINK")));
  strip.say(QStringLiteral("Begun"), Severity::notice);
  strip.say(QStringLiteral("Done"), Severity::good);
  EXPECT_EQ(strip.text(), QStringLiteral("Done"));
  strip.hold(QStringLiteral("STOPPED"), Severity::alarm);
  EXPECT_EQ(take(8.1, app::events::Lost{1}), QStringLiteral("STOPPED"));
  strip.clear_alert();
  EXPECT_EQ(strip.loud(), QString());
}

TEST(AlertStrip, SaysAnAnswerToTheOperatorBesideAWarningThatHasJustBeenSaid) {
  AlertStrip strip;
  const QString warning = QStringLiteral("The window stalled for 1.6 s"),
                answer = QStringLiteral("The run is not repeated");
  strip.say(warning, Severity::warning);
  EXPECT_EQ(strip.text(), warning);
  strip.say(answer, Severity::notice);
  EXPECT_TRUE(strip.text().startsWith(answer)) << strip.text().toStdString();
  EXPECT_TRUE(strip.text().contains(warning)) << strip.text().toStdString();
  EXPECT_EQ(strip.severity(), Severity::warning);
  strip.say(QStringLiteral("Saved"), Severity::good);
  EXPECT_TRUE(strip.text().startsWith(QStringLiteral("Saved")) && strip.text().contains(warning));
  EXPECT_FALSE(strip.text().contains(answer)) << "one answer takes the other's place";
  strip.say(QStringLiteral("the disk is full"), Severity::warning);
  EXPECT_EQ(strip.text(), QStringLiteral("the disk is full")) << "so does one warning the other's";
  strip.hold(QStringLiteral("STOPPED"), Severity::alarm);
  strip.say(answer, Severity::notice);
  EXPECT_TRUE(strip.text().startsWith(QStringLiteral("STOPPED")) && strip.text().contains(answer))
      << strip.text().toStdString();
  strip.clear_alert();
  strip.say(QStringLiteral("the camera is gone"), Severity::alarm);
  strip.say(answer, Severity::notice);
  EXPECT_TRUE(strip.text().startsWith(QStringLiteral("the camera is gone"))) << "an alarm is read first";
  EXPECT_TRUE(strip.text().contains(answer)) << strip.text().toStdString();
}

TEST(AlertStrip, TellsAnAlarmOnceAsLongAsItLasts) {
  AlertStrip strip;
  const QSignalSpy alarms(&strip, &AlertStrip::alarmed);
  app::TickRecord record;
  record.phase = app::Phase::running;
  record.robots.resize(3);
  const auto tick = [&](double t, std::optional<app::Event> event = {}) {
    record.t = t;
    record.events.clear();
    if (event) record.events.add(*event);
    strip.show_record(record);
  };
  strip.warn_unguarded(QStringLiteral("NO GUARD"));
  tick(1.0, app::events::VRise{});
  EXPECT_EQ(alarms.size(), 0) << "warnings are read";
  tick(1.1, app::events::Lost{1});
  tick(1.2);
  tick(1.3);
  ASSERT_EQ(alarms.size(), 1);
  EXPECT_TRUE(alarms[0][0].toString().contains(QStringLiteral("LOST: robot 2")));
  tick(2.0, app::events::Found{1});
  tick(2.1, app::events::Lost{1});
  EXPECT_EQ(alarms.size(), 2) << "the same robot, lost once more";
  strip.warn_batteries({QStringLiteral("3")});
  strip.warn_batteries({QStringLiteral("3")});
  ASSERT_EQ(alarms.size(), 3);
  EXPECT_TRUE(alarms[2][0].toString().contains(QStringLiteral("BATTERY LOW: robot 3")));
  strip.warn_batteries({});
  strip.hold(QStringLiteral("STOPPED"), Severity::alarm);
  strip.hold(QStringLiteral("STOPPED"), Severity::alarm);
  ASSERT_EQ(alarms.size(), 4);
  EXPECT_EQ(alarms[3][0].toString(), QStringLiteral("STOPPED"));
}

}  // namespace
}  // namespace skein::ui::test
