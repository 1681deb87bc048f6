// Couplings of pairs: set, switched off and on during a run, never past (18), and repeated from the record.
#include "app/tick/couplings.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <random>
#include <sstream>

#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/fixture.h"

namespace skein::app {
namespace {

using commands::Couple, commands::SetGain, commands::SetPairGain;
using core::GainName;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

/// The couplings of the paper's experiment, and what happened to them.
struct Desk {
  explicit Desk(const Experiment& e = paper_experiment())
      : experiment(e), gains(make_gains(e)), couplings(e, gains, make_reference(e)->demand(e.controller.k_y)) {}

  std::string obey(const auto& command, bool ready = false) {
    EventList events;
    if constexpr (requires { command.on; })
      couplings.couple(command, ready, false, events);
    else
      couplings.set(command, ready, false, events);
    return describe(events);
  }
  /// Ticks until nothing moves; (18) and a bounded rate all the while.
  void settle() {
    const std::vector<core::Twist> fastest(4, core::Twist{0.05, 0.05 / 0.119});
    for (int k = 0; k < 500; ++k) {
      const double before = gains.k_yy(0, 1);
      couplings.step(0.04, gains);
      EXPECT_LE(std::abs(gains.k_yy(0, 1) - before), 1.7 / 3 / 5 * 0.04 + 1e-12);
      core::use_policy(gains, fastest);
      for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(core::margins(gains, i, fastest[i]).hold());
    }
  }

  Experiment experiment;
  core::Gains gains;
  Couplings couplings;
};

TEST(Couplings, OfOnePairAreSetAndHeldWhere18Ends) {
  Desk desk;
  EXPECT_EQ(desk.obey(SetPairGain{2, 1, GainName::k_xx, 0.012}), "pair_gain r2 r3 k_xx 0.008 -> 0.012");
  desk.settle();
  EXPECT_DOUBLE_EQ(desk.gains.k_xx(1, 2), 0.012);
  EXPECT_DOUBLE_EQ(desk.gains.k_xx(0, 1), 0.008);
  // (18f) with 5 % left to tracking: 0.095 - 0.05 - 2 * 0.008.
  EXPECT_THAT(desk.obey(SetPairGain{0, 3, GainName::k_xx, 1.0}), StartsWith("pair_gain_held r1 r4 k_xx 1 -> 0.028999"));
  desk.settle();
  EXPECT_NEAR(desk.gains.k_xx(0, 3), 0.029, 1e-12);
  EXPECT_THAT(desk.obey(SetPairGain{0, 3, GainName::k_yy, 100.0}), HasSubstr("pair_gain_held r1 r4 k_yy 100 -> "));
  desk.settle();
  EXPECT_EQ(desk.obey(SetPairGain{2, 2, GainName::k_xx, 0.01}), "") << "nobody is coupled to himself";
  EXPECT_EQ(desk.obey(SetPairGain{2, 7, GainName::k_xx, 0.01}), "");
}

TEST(Couplings, AreSwitchedOffAndComeBackAsTheyWere) {
  Desk desk;
  desk.obey(SetPairGain{0, 1, GainName::k_yy, 0.1});
  EXPECT_EQ(desk.obey(Couple{1, 0, false}), "uncouple r1 r2");
  EXPECT_FALSE(desk.couplings.coupled(0, 1));
  desk.settle();
  for (const GainName name : core::gain_names) {
    EXPECT_EQ(core::table(desk.couplings.now(), name)(0, 1), 0.0);
    EXPECT_GT(core::table(desk.couplings.now(), name)(0, 2), 0.0);
  }
  // What is said of all pairs counts for it as well, once it is back.
  desk.obey(SetGain{GainName::k_tt, 0.03});
  desk.settle();
  EXPECT_EQ(desk.gains.k_tt(0, 1), 0.0);
  EXPECT_DOUBLE_EQ(desk.gains.k_tt(2, 3), 0.03);
  EXPECT_EQ(desk.obey(Couple{0, 1, true}), "couple r1 r2");
  desk.settle();
  EXPECT_DOUBLE_EQ(desk.gains.k_tt(0, 1), 0.03);
  EXPECT_DOUBLE_EQ(desk.gains.k_yy(0, 1), 0.1);
  EXPECT_EQ(desk.obey(Couple{0, 1, true}), "") << "it is";
}

TEST(Couplings, ComeBackWithLessWhereOthersHaveTakenTheirRoom) {
  Desk desk;
  desk.obey(Couple{0, 1, false});
  desk.settle();
  // Robot 1's room of 0.045 m/s: 0.025 and 0.016 leave 0.004.
  desk.obey(SetPairGain{0, 2, GainName::k_xx, 0.025});
  desk.obey(SetPairGain{0, 3, GainName::k_xx, 0.016});
  desk.settle();
  EXPECT_THAT(desk.obey(Couple{0, 1, true}), StartsWith("pair_gain_held r1 r2 k_xx 0.008 -> 0.00"));
  desk.settle();
  EXPECT_NEAR(desk.gains.k_xx(0, 1), 0.004, 1e-12);
}

TEST(Couplings, ChangeInTheFileEveryParameterOfEveryPair) {
  const Experiment e = good(
      "[controller]\nl_xx = [[1, 2, 50]]\nc_yy = 2\n[[gain_change]]\nt = 1\nramp = 4\nl_xx = 20\nc_tt = [[1, 3, "
      "0.08]]");
  const core::Gains start = make_gains(e);
  EXPECT_EQ(start.l_xx(0, 1), 50.0);
  EXPECT_EQ(start.l_xx(0, 2), 0.0);
  EXPECT_EQ(start.c_yy, core::PairTable(4, 2.0));
  Desk desk(e);
  EventList events;
  desk.couplings.follow_file(1.0, events);
  EXPECT_EQ(describe(events), "schedule c_tt 0.04 -> 0.08; schedule l_xx 50 -> 20");
  for (int k = 0; k < 50; ++k) desk.couplings.step(0.04, desk.gains);
  EXPECT_NEAR(desk.gains.l_xx(0, 1), 35.0, 1e-9);
  EXPECT_NEAR(desk.gains.l_xx(2, 3), 10.0, 1e-9);
  EXPECT_NEAR(desk.gains.c_tt(0, 2), 0.06, 1e-12);
  EXPECT_NEAR(desk.gains.c_tt(0, 1), 0.02, 1e-12);
}

TEST(Couplings, TakeARampAsLongAsItIsAskedForAndNeverShorterThanIsSafe) {
  Desk desk;
  EXPECT_EQ(desk.obey(SetGain{GainName::k_xx, 0.002, 30.0}), "gain k_xx 0.008 -> 0.002 ramp=30");
  for (int k = 0; k < 375; ++k) desk.couplings.step(0.04, desk.gains);
  EXPECT_NEAR(desk.gains.k_xx(0, 1), 0.005, 1e-9) << "half of the way in half of the time";
  desk.settle();
  EXPECT_DOUBLE_EQ(desk.gains.k_xx(2, 3), 0.002);
  EXPECT_EQ(desk.obey(SetPairGain{0, 1, GainName::k_yy, 0.1, 0.01}), "pair_gain r1 r2 k_yy 0.08 -> 0.1 ramp=0.01");
  desk.settle();  // at the bounded rate
  EXPECT_DOUBLE_EQ(desk.gains.k_yy(0, 1), 0.1);
}

TEST(Couplings, OnTheWayTakeNoMoreThanThereIs) {
  Desk desk;
  const SetGain slow{GainName::k_tt, 0.0, 60.0};
  desk.obey(SetGain{GainName::k_tt, 1.0});
  desk.settle();
  desk.obey(slow);
  desk.obey(SetGain{GainName::k_yy, 1.0});
  EXPECT_GT(desk.couplings.target().k_yy.largest(), 0.2);
  desk.settle();  // checks (18) all the way
  EXPECT_LT(desk.gains.k_yy.largest(), 0.9 * desk.couplings.target().k_yy.largest()) << "k_tt still takes its share";
  for (int k = 0; k < 3; ++k) desk.settle();
  EXPECT_DOUBLE_EQ(desk.gains.k_yy.largest(), desk.couplings.target().k_yy.largest());
}

TEST(Couplings, OfTheFileAreHeldBesideTheOperators) {
  const Experiment e = good("[[gain_change]]\nt = 1\nramp = 2\nk_yy = 0.2");
  Desk desk(e);
  EventList events;
  desk.obey(SetGain{GainName::k_tt, 1.0});
  desk.couplings.follow_file(1.0, events);
  EXPECT_THAT(describe(events), HasSubstr("schedule k_yy 0.08 -> 0.2; gain_held k_yy 0.2 -> 0.0"));
  desk.settle();
  Desk alone(e);
  events.clear();
  alone.couplings.follow_file(1.0, events);
  EXPECT_EQ(describe(events), "schedule k_yy 0.08 -> 0.2");
}

TEST(Couplings, FixedTrackingGainsAreRefusedWhere18FailsAndKeptOtherwise) {
  const std::string fixed = "[controller]\npolicy = 'fixed'\nk_x = 0.02\nk_theta = 0.3\n";
  EXPECT_THAT(
      messages("[controller]\npolicy = 'fixed'\nk_x = 0.03\nk_theta = 0.3"),
      Contains(StartsWith("e.toml:3:7: controller.k_x: (18f) fails for robot 1 by 0.004: 0.1 - reference 0.05 - "
                          "couplings 0.024 leaves 0.026 for k_x = 0.03, allowed: up to 0.026")));
  EXPECT_THAT(messages("[controller]\npolicy = 'fixed'\nk_x = 0.02"),
              Contains(StartsWith("e.toml:1:1: controller.k_theta: missing")));
  EXPECT_THAT(messages("[controller]\nk_x = 0.02"), Contains(StartsWith("e.toml:2:7: controller.k_x: found 0.02")));
  EXPECT_THAT(messages(fixed + "[[gain_change]]\nt = 3\nk_xx = 0.012"),
              Contains(HasSubstr("gain_change.1: (18f) fails for robot 1 by 0.006")));
  Experiment e = good(fixed + "[[perturb]]\nt = 1\nrobot = 2\ndy = -0.1");
  e.duration = 10.0;
  for (const TickRecord& row : test::simulate(e))
    for (const RobotRecord& robot : row.robots) {
      ASSERT_EQ(robot.k_x, 0.02);
      ASSERT_TRUE(robot.margins.hold());
    }
  // Online they are the limit.
  Desk desk(e);
  EXPECT_THAT(desk.obey(SetGain{GainName::k_xx, 1.0}), StartsWith("gain_held k_xx 1 -> 0.01"));
}

const std::string varying =
    "[controller]\npolicy = 'fixed'\nk_x = 0.02\nk_theta = 0.3\ncoupling = 'bounded'\n"
    "[[gain_change]]\nt = 2\nramp = 4\nk_x = 0.01\nk_theta = [[1, 0.2], [3, 0.4]]\nk_xx = 0.013\n"
    "[[gain_change]]\nt = 7\nk_x = [[2, 0.025]]\nk_xx = 0.008\n"
    "[[perturb]]\nt = 1\nrobot = 2\ndy = -0.1\n";

TEST(TrackingGains, FollowTheirCourseInTheFileRobotByRobot) {
  Experiment e = good("duration = 12\n" + varying);
  const std::vector<TickRecord> rows = test::simulate(e);
  const auto at = [&](double t) -> const TickRecord& {
    return rows[static_cast<std::size_t>(std::lround(t * e.rate))];
  };
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(at(1.9).robots[i].k_x, 0.02);
    EXPECT_NEAR(at(4.0).robots[i].k_x, 0.015, 1e-4) << "half of the ramp";
    EXPECT_DOUBLE_EQ(at(6.5).robots[i].k_x, 0.01);
    EXPECT_DOUBLE_EQ(at(11.0).robots[i].k_x, i == 1 ? 0.025 : 0.01);
    EXPECT_DOUBLE_EQ(at(11.0).robots[i].k_theta, i == 0 ? 0.2 : i == 2 ? 0.4 : 0.3);
  }
  for (std::size_t k = 1; k < rows.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i) {
      const RobotRecord &robot = rows[k].robots[i], &before = rows[k - 1].robots[i];
      ASSERT_TRUE(robot.margins.hold()) << rows[k].t;
      ASSERT_LE(std::abs(robot.k_x - before.k_x), 0.015 * 0.04 + 1e-12) << "Theorem 1 wants continuous gains";
    }
  std::string events;
  for (const TickRecord& row : rows) events += describe(row.events) + "; ";
  EXPECT_THAT(events,
              HasSubstr("schedule k_xx 0.008 -> 0.013; schedule k_x 0.02 -> 0.01; schedule k_theta 0.3 -> 0.4"));
  EXPECT_THAT(events, HasSubstr("schedule k_x 0.01 -> 0.025"));
}

TEST(TrackingGains, OfARobotAreItsOwn) {
  const std::string four = "[[robot]]\n[[robot]]\nk_x = 0.01\n[[robot]]\nk_theta = 0.1\n[[robot]]\n";
  const std::string fixed = "[controller]\npolicy = 'fixed'\nk_x = 0.02\nk_theta = 0.3\n";
  const core::Gains gains = make_gains(good(fixed + four));
  EXPECT_THAT(gains.k_x, testing::ElementsAre(0.02, 0.01, 0.02, 0.02));
  EXPECT_THAT(gains.k_theta, testing::ElementsAre(0.3, 0.3, 0.1, 0.3));
  EXPECT_THAT(messages(four), Contains(HasSubstr("robot.2.k_x: found 0.01, allowed: with policy = \"fixed\"")));
  EXPECT_THAT(messages(fixed + "[[robot]]\n[[robot]]\nk_x = 0.05\n[[robot]]\n[[robot]]\n"),
              Contains(HasSubstr("robot.2.k_x: (18f) fails for robot 2 by 0.024")));
}

TEST(TrackingGains, ThatTheFileCannotHaveAreNamed) {
  const std::string fixed = "[controller]\npolicy = 'fixed'\nk_x = 0.02\nk_theta = 0.3\n[[gain_change]]\nt = 3\n";
  EXPECT_THAT(messages(fixed + "k_x = 0.03"), Contains(HasSubstr("gain_change.1: (18f) fails for robot 1 by 0.004")));
  EXPECT_THAT(messages(fixed + "k_x = [[4, 0.03]]"),
              Contains(HasSubstr("gain_change.1: (18f) fails for robot 4 by 0.004")));
  EXPECT_THAT(messages(fixed + "k_x = 0"),
              Contains(HasSubstr("gain_change.1.k_x: found 0, allowed: a number above 0")));
  EXPECT_THAT(
      messages(fixed + "k_theta = [[5, 0.1]]"),
      Contains(HasSubstr("gain_change.1.k_theta.1: found [5, 0.1], allowed: [i, value] with a robot from 1 to 4")));
  EXPECT_THAT(messages(fixed + "k_theta = [[2, 0.1], [2, 0.2]]"),
              Contains(HasSubstr("gain_change.1.k_theta.2: found robot 2 again, allowed: each robot once")));
  EXPECT_THAT(messages(fixed + "k_theta = [0.1, 0.2]"), Contains(HasSubstr("gain_change.1.k_theta.1: found 0.1")));
  EXPECT_THAT(messages("[[gain_change]]\nt = 3\nk_x = 0.02"),
              Contains(HasSubstr("gain_change.1.k_x: found 0.02, allowed: with policy = \"fixed\"")));
}

/// The operator may use what the file never takes; the file, what it does not give to tracking at that time.
TEST(TrackingGains, AreKeptFreeForTheWholeRun) {
  Desk desk(good("duration = 12\n" + varying));
  // Robot 2 gets 0.025 from 7 s on: 0.1 - 0.05 - 0.025 = 3 * 0.00833.
  EXPECT_THAT(desk.obey(SetGain{GainName::k_xx, 1.0}), StartsWith("gain_held k_xx 1 -> 0.00833"));
  EventList events;
  desk.couplings.follow_file(2.0, events);
  EXPECT_THAT(describe(events), testing::Not(HasSubstr("gain_held"))) << "k_x makes room for it";
  desk.settle();
  EXPECT_DOUBLE_EQ(desk.gains.k_xx(0, 1), 0.013);
  desk.couplings.follow_file(7.0, events);
  desk.settle();  // checks (18) all the way
  EXPECT_DOUBLE_EQ(desk.gains.k_x[1], 0.025);
}

/// Every course within (18) keeps (14) with the bounded coupling, whatever the errors.
TEST(TrackingGains, OfAnyCourseWithin18KeepTheLimits) {
  std::mt19937_64 random(20101208);
  const auto part = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  double most_v = 0.0, most_omega = 0.0;
  for (int course = 0; course < 60; ++course) {
    Experiment e = paper_experiment();
    e.duration = 6.0;
    e.controller.policy = core::GainPolicy::fixed;
    e.controller.coupling = core::Coupling::bounded;
    e.controller.k_x = part(0.001, 0.026), e.controller.k_theta = part(0.01, 0.4);
    for (const double t : {1.0, 3.0}) {
      GainChange change;
      change.t = t;
      change.ramp = part(0.1, 2.0);
      for (int i = 0; i < 4; ++i) {
        change.tracking[core::TrackingGain::k_x].push_back(part(0.001, 0.026));
        change.tracking[core::TrackingGain::k_theta].push_back(part(0.01, 0.4));
      }
      e.gain_changes.push_back(change);
    }
    e.perturbations = {{0.4, 1, part(-0.2, 0.2), part(-0.2, 0.2), part(-3.0, 3.0)}};
    e.shield.enabled = e.avoidance.enabled = false;
    for (const TickRecord& row : test::simulate(e))
      for (const RobotRecord& robot : row.robots) {
        ASSERT_TRUE(robot.margins.hold()) << course;
        most_v = std::max(most_v, std::abs(robot.law.v)), most_omega = std::max(most_omega, std::abs(robot.law.omega));
      }
  }
  EXPECT_LE(most_v, 0.1 + 1e-12);
  EXPECT_LE(most_omega, 1.7 + 1e-12);
  EXPECT_GT(most_v, 0.07) << "no course added what k_x may add to the reference's 0.05";
}

/// The record of a whole run; the fifth time that the operator is asked, he does something.
std::string record_of(const Experiment& e, const std::function<void(Session&)>& does) {
  std::ostringstream text;
  CsvWriter writer(text, e);
  auto session = Session::open(e, Session::Clock::virtual_, {.sinks = {&writer}});
  if (!session) {
    ADD_FAILURE() << session.error();
    return {};
  }
  int asked = 0;
  (*session)->run([&] {
    if (++asked == 5) does(**session);
    return true;
  });
  (*session)->close();
  return text.str();
}

void expect_that_it_repeats(const std::string& record, std::int64_t ticks) {
  std::istringstream recorded(record);
  const auto result = replay(recorded, "run.csv");
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->ticks, ticks);
  EXPECT_EQ(result->different, 0) << result->first;
}

TEST(TrackingGains, ThatChangedAreRepeatedFromTheRecord) {
  expect_that_it_repeats(record_of(good("duration = 12\n" + varying), [](Session&) {}), 300);
}

TEST(Couplings, ThatAreChangedDuringARunAreRepeatedFromItsRecord) {
  Experiment e = paper_experiment();
  e.duration = 30.0;
  std::ostringstream text;
  CsvWriter writer(text, e);
  auto session = Session::open(e, Session::Clock::virtual_, {.sinks = {&writer}});
  ASSERT_TRUE(session) << session.error();
  Session& s = **session;
  EXPECT_TRUE(s.set_gain(GainName::k_yy, 0.05));
  EXPECT_TRUE(s.set_gain(GainName::k_tt, 1, 3, 1.0));
  EXPECT_TRUE(s.couple(0, 2, false));
  int asked = 0;
  s.run([&] {
    if (++asked == 10) {
      EXPECT_TRUE(s.couple(1, 2, false));
    }
    if (asked == 20) {
      EXPECT_TRUE(s.set_gain(GainName::k_xx, 2, 1, 0.02));
      EXPECT_TRUE(s.set_gain(GainName::k_tt, 0.01));
    }
    if (asked == 25) {
      EXPECT_TRUE(s.couple(1, 2, true));
      EXPECT_TRUE(s.couple(0, 2, true));
    }
    if (asked == 28) {
      EXPECT_TRUE(s.set_gain(GainName::k_yy, 0.02, 7.5));
      EXPECT_TRUE(s.set_gain(GainName::k_tt, 0, 1, 0.02, 3.0));
    }
    if (asked == 30) {
      EXPECT_TRUE(s.set_gain(GainName::k_xx, 0, 3, 0.0));
    }
    return true;
  });
  EXPECT_TRUE(s.coupled(0, 2));
  EXPECT_EQ(s.gain_target(GainName::k_xx, 3, 0), 0.0);
  EXPECT_DOUBLE_EQ(s.gain(GainName::k_tt, 0, 2), 0.01);
  EXPECT_GT(s.gain_limit(GainName::k_xx, 0, 3), 0.008);
  s.close();
  EXPECT_THAT(text.str(), HasSubstr("uncouple r1 r3; pair_gain r2 r4 k_tt"));
  std::istringstream recorded(text.str());
  const auto result = replay(recorded, "run.csv");
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->ticks, 750);
  EXPECT_EQ(result->different, 0) << result->first;
}

TEST(Couplings, OfTheFileThatWereHeldAreRepeatedFromTheRecord) {
  const Experiment e = good("duration = 16\n[[gain_change]]\nt = 10\nramp = 2\nk_yy = 0.18");
  const std::string record =
      record_of(e, [](Session& session) { EXPECT_TRUE(session.set_gain(GainName::k_tt, 1.0, 4.0)); });
  EXPECT_THAT(record, HasSubstr("schedule k_yy 0.08 -> 0.18; gain_held k_yy 0.18 -> "));
  expect_that_it_repeats(record, 400);
}

}  // namespace
}  // namespace skein::app
