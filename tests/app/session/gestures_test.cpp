// The operator's hand in a run: kicks, and obstacles that come and go. Everything is in the record, and the record
// drives the same tick again, bit for bit.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "tests/app/rows.h"

namespace skein::app {
namespace {

using test::Rows;

using Gesture = std::function<void(Session&, double)>;  // at time t; before the start: t = -1

struct Recorded {
  Rows rows;
  std::string csv;
};

/// A run on the virtual clock; `gesture` is asked every 16 ticks.
void drive(Recorded& run, const Experiment& experiment, const Gesture& before, const Gesture& during) {
  std::ostringstream text;
  CsvWriter writer(text, experiment);
  auto opened = Session::open(experiment, Session::Clock::virtual_, {false, {&run.rows, &writer}});
  ASSERT_TRUE(opened) << opened.error();
  Session& session = **opened;
  before(session, -1.0);
  EXPECT_EQ(session.run([&] {
    during(session, run.rows.rows.empty() ? 0.0 : run.rows.rows.back().t);
    return true;
  }),
            Phase::finished);
  run.csv = text.str();
}

Experiment short_run() {
  auto experiment = parse_experiment(paper_experiment().source, "platoon.toml", {"duration=12"});
  EXPECT_TRUE(experiment);
  return *experiment;
}

const Gesture nothing = [](Session&, double) {};

void expect_replayed(const Recorded& run) {
  std::istringstream csv(run.csv);
  const auto again = replay(csv, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->different, 0) << again->first;
  EXPECT_EQ(again->ticks, static_cast<std::int64_t>(run.rows.rows.size()));
}

TEST(Gestures, AKickedRobotSlidesAndComesBack) {
  Recorded run;
  bool kicked = false;
  const Gesture kick = [&](Session& session, double t) {
    if (t < 2.0 || kicked) return;
    kicked = true;
    ASSERT_TRUE(session.kick_robot(1, 0.6, 0.0));
  };
  drive(run, short_run(), nothing, kick);
  ASSERT_EQ(run.rows.count<events::Kick>(), 1);
  const auto& rows = run.rows.rows;
  std::size_t k = 0;
  while (rows[k].events.empty() || !is<events::Kick>(*rows[k].events.begin())) ++k;
  // 0.6^2 / (2 * 3) m of slide, within 0.2 s; meanwhile it steers back already.
  EXPECT_GT(rows[k + 4].robots[1].truth.x - rows[k - 1].robots[1].truth.x, 0.04);
  EXPECT_GT(rows[k + 2].tracking_error(), 0.03);
  EXPECT_LT(rows.back().tracking_error(), 0.01);
  expect_replayed(run);
}

/// Start and pause come to the same tick: what is replayed has begun as well.
TEST(Gestures, ARunThatIsPausedAsItStartsIsReplayed) {
  Recorded run;
  int asked = 0;
  const Gesture pause = [&](Session& session, double) {
    ++asked;
    if (asked == 1) {
      EXPECT_TRUE(session.pause());
    } else if (asked == 2) {
      EXPECT_TRUE(session.move_robot(0, {0.3, 0.4, 1.0}));
    } else if (asked == 3) {
      EXPECT_TRUE(session.resume());
    }
  };
  drive(run, short_run(), nothing, pause);
  EXPECT_EQ(run.rows.count<events::Start>(), 1);
  EXPECT_EQ(run.rows.count<events::Pause>(), 1);
  EXPECT_EQ(run.rows.count<events::Move>(), 1);
  EXPECT_EQ(run.rows.count<events::Resume>(), 1);
  expect_replayed(run);
}

TEST(Gestures, ObstaclesAreDroppedMovedAndTakenAwayAndReplayed) {
  Recorded run;
  std::size_t first = 0, early = 0;
  int step = 0;
  const Gesture before = [&](Session& session, double) {
    const auto added = session.add_obstacle({0.9, 0.7, 0.02});  // before the start: the record must have it as well
    ASSERT_TRUE(added) << added.error();
    early = *added;
  };
  const Gesture during = [&](Session& session, double t) {
    if (step == 0 && t >= 1.0) {
      // In the way of robot 1: where its reference will be in 1.5 s.
      const core::Pose ahead = make_reference(session.experiment())->at(0, t + 1.5).pose;
      const auto added = session.add_obstacle({ahead.x, ahead.y, 0.03});
      ASSERT_TRUE(added) << added.error();
      first = *added;
      ++step;
    } else if (step == 1 && t >= 5.0) {
      ASSERT_TRUE(session.move_obstacle(first, {-0.9, -0.7, 0.03}));
      ++step;
    } else if (step == 2 && t >= 6.0) {
      ASSERT_TRUE(session.remove_obstacle(early));
      ++step;
    }
  };
  drive(run, short_run(), before, during);
  EXPECT_NE(first, early);
  EXPECT_EQ(run.rows.count<events::PutObstacle>(), 4) << "dropped early, dropped, moved, taken away";
  EXPECT_GE(run.rows.count<events::Avoid>(), 1) << "robot 1 drove through it";
  EXPECT_LT(run.rows.rows.back().tracking_error(), 0.02) << "the obstacle has gone, the robot has not come back";
  expect_replayed(run);
}

TEST(Gestures, ARobotThatIsHeldStandsAndTheOthersDriveOn) {
  Recorded run;
  int step = 0;
  const Gesture during = [&](Session& session, double t) {
    if (step == 0 && t >= 2.0) {
      ASSERT_TRUE(session.hold_robot(3, true));
      ++step;
    } else if (step == 1 && t >= 4.0) {
      ASSERT_TRUE(session.hold_robot(3, false));
      ++step;
    }
  };
  drive(run, short_run(), nothing, during);
  bool held = false;
  double error_of_the_rest = 0.0;
  for (const TickRecord& row : run.rows.rows) {
    for (const Event& event : row.events) {
      if (is<events::Hold>(event)) held = true;
      if (is<events::Release>(event)) held = false;
    }
    if (!held) continue;
    EXPECT_EQ(row.robots[3].wheels, core::WheelSpeeds{});
    EXPECT_TRUE(row.robots[3].is(stopped));
    EXPECT_FALSE(row.robots[3].is(lost));
    EXPECT_TRUE(std::isnan(row.robots[3].error.x));
    for (std::size_t i = 0; i < 3; ++i)
      error_of_the_rest = std::fmax(error_of_the_rest, std::hypot(row.robots[i].error.x, row.robots[i].error.y));
  }
  EXPECT_EQ(run.rows.count<events::Hold>(), 1);
  EXPECT_EQ(run.rows.count<events::Release>(), 1);
  EXPECT_LT(error_of_the_rest, 1e-3) << "they waited for it";
  expect_replayed(run);
}

TEST(Gestures, AreRefusedWithAReason) {
  auto opened = Session::open(paper_experiment(), Session::Clock::virtual_);
  ASSERT_TRUE(opened);
  Session& session = **opened;
  EXPECT_FALSE(session.kick_robot(4, 0.1, 0.0));
  EXPECT_FALSE(session.kick_robot(0, std::nan(""), 0.0));
  EXPECT_FALSE(session.add_obstacle({5.0, 0.0, 0.1}));
  EXPECT_FALSE(session.add_obstacle({0.0, 0.0, 0.0}));
  EXPECT_FALSE(session.remove_obstacle(1000));
  for (std::size_t k = 0; k < core::ObstacleField::room_for_more; ++k)
    EXPECT_TRUE(session.add_obstacle({0.5, 0.5, 0.01}));
  const auto one_more = session.add_obstacle({0.5, 0.5, 0.01});
  ASSERT_FALSE(one_more);
  EXPECT_NE(one_more.error().find("no more"), std::string::npos) << one_more.error();
  ASSERT_TRUE(session.remove_obstacle(3));
  EXPECT_EQ(session.add_obstacle({0.1, 0.1, 0.01}).value_or(99), 3u) << "the number that became free";
}

}  // namespace
}  // namespace skein::app
