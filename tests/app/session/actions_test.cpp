// [[operator]] tables: a file does what a hand did in the window.
#include <gtest/gtest.h>

#include <functional>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/experiment/run_text.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "tests/app/rows.h"

namespace skein::app {
namespace {

using test::Rows;

using Hand = std::function<void(Session&, double)>;  // at time t, asked every 16 ticks; before the start: t = -1

Rows run(const Experiment& experiment, const Hand& hand, std::ostream* csv = nullptr) {
  Rows rows;
  std::ostringstream nowhere;
  CsvWriter writer(csv ? *csv : nowhere, experiment);
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&rows, &writer}});
  EXPECT_TRUE(session);
  if (hand) hand(**session, -1.0);
  (*session)->run([&] {
    if (hand) hand(**session, rows.rows.empty() ? 0.0 : rows.rows.back().t);
    return true;
  });
  return rows;
}

Experiment twelve_seconds() {
  auto experiment = parse_experiment(paper_experiment().source, "platoon.toml", {"duration=12"});
  EXPECT_TRUE(experiment);
  return *experiment;
}

Experiment parsed(const std::string& text) {
  auto experiment = parse_experiment(text, "done.toml");
  EXPECT_TRUE(experiment) << experiment.error().front().message();
  return experiment ? *experiment : Experiment{};
}

/// The last tick is that before the end: a kick in the tick that ends the run would be all that its results are of.
TEST(Actions, OfTheFileHappenBeforeTheEnd) {
  const char* const at_the_end =
      "duration = 2\n[[perturb]]\nt = 1.96\nrobot = 1\ndx = 0.01\n[[perturb]]\nt = 2\nrobot = 2\ndx = 0.1\n"
      "[[operator]]\nt = 1.97\ndoes = 'move r3 x=0 y=0 theta=0'\n[[operator]]\nt = 2\ndoes = 'hold r4'\n";
  const Rows rows = run(parsed(at_the_end), {});
  EXPECT_EQ(rows.rows.size(), 50u);
  EXPECT_EQ(rows.count<events::Perturb>(), 1);
  EXPECT_FALSE(rows.has<events::Move>());
  EXPECT_FALSE(rows.has<events::Hold>());
}

/// One thing after the other, each once.
Hand busy_hand() {
  return [done = 0](Session& session, double t) mutable {
    const auto at = [&](int step, double when) { return done == step && t >= when && ++done; };
    if (at(0, -1.0)) {
      EXPECT_TRUE(session.set_gain(core::GainName::k_yy, 0.05));
      EXPECT_TRUE(session.couple(0, 3, false));
      ASSERT_TRUE(session.add_obstacle({0.7, 0.5, 0.04}));
    }
    if (at(1, 2.0)) {
      ASSERT_TRUE(session.kick_robot(1, 0.4, -0.1));
    }
    if (at(2, 3.0)) {
      EXPECT_TRUE(session.set_gain(core::GainName::k_xx, 1, 2, 0.02, 3.0));
    }
    if (at(3, 4.0)) {
      ASSERT_TRUE(session.move_robot(3, {-0.8, -0.6, 1.0}));
    }
    if (at(4, 5.0)) {
      ASSERT_TRUE(session.move_obstacle(0, {0.6, -0.35, 0.05}));
    }
    if (at(5, 6.0)) {
      ASSERT_TRUE(session.hold_robot(0, true));
    }
    if (at(6, 7.0)) {
      ASSERT_TRUE(session.hold_robot(0, false));
    }
    if (at(7, 8.0)) {  // held at the limit
      EXPECT_TRUE(session.set_gain(core::GainName::k_tt, 1.0));
    }
    if (at(8, 9.0)) {
      EXPECT_TRUE(session.couple(0, 3, true));
    }
    if (at(9, 10.0)) {
      ASSERT_TRUE(session.remove_obstacle(0));
    }
  };
}

TEST(Actions, DoWhatAHandDidToTheBit) {
  const Experiment experiment = twelve_seconds();
  const Rows by_hand = run(experiment, busy_hand());
  ASSERT_GE(by_hand.actions().size(), 11u);
  const Experiment written = parsed(text_as_done(experiment, by_hand.all()));
  const Rows by_file = run(written, nullptr);
  EXPECT_EQ(by_file.actions(), by_hand.actions());
  ASSERT_EQ(by_file.rows.size(), by_hand.rows.size());
  for (std::size_t k = 0; k < by_hand.rows.size(); ++k) {
    EXPECT_EQ(by_file.rows[k].k_tt, by_hand.rows[k].k_tt) << k;
    for (std::size_t i = 0; i < 4; ++i) {
      const core::Pose &a = by_file.rows[k].robots[i].truth, &b = by_hand.rows[k].robots[i].truth;
      ASSERT_EQ(a.x, b.x) << "tick " << k << ", robot " << i + 1;
      ASSERT_EQ(a.y, b.y) << "tick " << k << ", robot " << i + 1;
    }
  }
  // What the file does by itself is not written down once more.
  EXPECT_EQ(text_as_done(written, by_file.all()), written.source);
}

TEST(Actions, AreInTheRecordSoThatItCanBeReplayed) {
  const Experiment experiment = twelve_seconds();
  const Rows by_hand = run(experiment, busy_hand());
  std::stringstream csv;
  run(parsed(text_as_done(experiment, by_hand.all())), nullptr, &csv);
  const auto again = replay(csv, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_GT(again->commands, 1000);
  EXPECT_EQ(again->different, 0) << again->first;
}

TEST(Actions, PutRobotsWhereTheyStoodAtTheStart) {
  const Experiment experiment = twelve_seconds();
  const Rows by_hand = run(experiment, [done = false](Session& session, double) mutable {
    if (!std::exchange(done, true)) {
      ASSERT_TRUE(session.move_robot(2, {-0.3, 0.2, 0.5}));
    }
  });
  const core::Pose stood = by_hand.rows.front().robots[2].truth;
  EXPECT_EQ(stood.x, -0.3);
  const Rows by_file = run(parsed(text_as_done(experiment, by_hand.all())), nullptr);
  EXPECT_EQ(by_file.rows.front().robots[2].truth.x, stood.x);
  EXPECT_EQ(by_file.rows.back().robots[2].truth.x, by_hand.rows.back().robots[2].truth.x);
}

TEST(Actions, KeepTheirObstaclesNumbersToThemselves) {
  auto experiment =
      parsed(twelve_seconds().source + "\n[[operator]]\nt = 5\ndoes = \"obstacle o1 x=0.6 y=0.5 radius=0.04\"\n");
  auto session = Session::open(experiment, Session::Clock::virtual_);
  ASSERT_TRUE(session);
  const auto number = (*session)->add_obstacle({0.0, 0.0, 0.05});
  ASSERT_TRUE(number);
  EXPECT_EQ(*number, 1u);
}

TEST(Actions, AreRefusedWhereTheyMakeNoSense) {
  const std::vector<std::pair<const char*, const char*>> wrong{
      {"kick r9 vx=0 vy=0", "allowed: a robot, r1 to r4"},
      {"kick r2", "allowed: \"move r1"},
      {"kick r2 vy=0.1 vx=0.2", "allowed: \"move r1"},
      {"stop", "allowed: \"move r1"},
      {"pair_gain r1 r1 k_xx 0 -> 0.01", "allowed: two different robots"},
      {"gain k_zz 0 -> 0.01", "allowed: \"move r1"},
      {"gain c_xx 0 -> 0.01", "allowed: k_xx, k_tt or k_yy"},
      {"gain k_xx 0 -> -1", "a value of 0 or more"},
      {"obstacle o99 x=0 y=0 radius=0.1", "allowed: obstacles o1 to o16"},
      {"obstacle o1 x=3 y=0 radius=0.1", "allowed: a place inside the arena"},
      {"move r1 x=nan y=0 theta=0", "allowed: \"move r1"},
  };
  for (const auto& [does, why] : wrong) {
    const auto read = parse_experiment(std::string("[[operator]]\nt = 1\ndoes = \"") + does + "\"\n", "e.toml");
    ASSERT_FALSE(read) << does;
    const std::string said = read.error().front().message();
    EXPECT_NE(said.find("e.toml:3:8: operator.1.does: found \""), std::string::npos) << said;
    EXPECT_NE(said.find(why), std::string::npos) << said;
  }
  const auto read = parse_experiment("[[operator]]\nt = 1", "e.toml");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().front().message(),
            "e.toml:1:1: operator.1.does: missing, allowed: the action, such as \"kick r2 vx=0.3 vy=0\"");
}

TEST(RunText, WritesGainsAsOneNumberOrForEveryPair) {
  const Experiment paper = paper_experiment();
  core::CouplingGains gains = paper.controller.gains;
  gains.k_xx.fill(0.004);
  gains.k_tt.set(0, 2, 0.0);
  const auto text = text_with_gains(paper.source, gains);
  ASSERT_TRUE(text) << text.error();
  const Experiment again = parsed(*text);
  EXPECT_EQ(again.controller.gains.k_xx, gains.k_xx);
  EXPECT_EQ(again.controller.gains.k_tt, gains.k_tt);
  EXPECT_EQ(again.controller.gains.k_yy, gains.k_yy);
  EXPECT_NE(text->find("k_xx = 0.004"), std::string::npos);
  EXPECT_NE(text->find("[1, 3, 0]"), std::string::npos);
}

Experiment leader_follower(const std::string& more = {}) {
  auto experiment = parse_experiment(paper_experiment().source + more, "leader.toml",
                                     {"duration=30", "controller.kind=\"leader_follower\""});
  EXPECT_TRUE(experiment) << experiment.error().front().message();
  return experiment.value_or(Experiment{});
}

TEST(Actions, AParameterOfTheLawIsChangedRecordedAndReplayed) {
  std::ostringstream csv;
  const Experiment experiment = leader_follower();
  const Rows changed = run(
      experiment,
      [done = 0](Session& session, double t) mutable {
        if (t < 0.0) {
          EXPECT_TRUE(session.set_parameter("ahead", 0.04)) << "before the start";
        }
        if (t >= 19.0 && done++ == 0) {
          EXPECT_TRUE(session.set_parameter("alpha_l", 3.0));
        }
      },
      &csv);
  const auto actions = changed.actions();
  ASSERT_EQ(actions.size(), 2u) << testing::PrintToString(actions);
  EXPECT_EQ(actions[0], "0 parameter ahead 0.03 -> 0.04");
  EXPECT_NE(actions[1].find("parameter alpha_l 0.8 -> 3"), std::string::npos) << actions[1];

  // The control: the same run until the change, another one afterwards.
  const Rows before = run(experiment, [](Session& session, double t) {
    if (t < 0.0) {
      EXPECT_TRUE(session.set_parameter("ahead", 0.04));
    }
  });
  const auto apart = [&](std::size_t k) {
    return core::distance(changed.rows[k].robots[1].truth, before.rows[k].robots[1].truth);
  };
  ASSERT_EQ(changed.rows.size(), before.rows.size());
  EXPECT_EQ(apart(18 * 25), 0.0);
  double most = 0.0;
  for (std::size_t k = 0; k < changed.rows.size(); ++k) most = std::max(most, apart(k));
  EXPECT_GT(most, 0.005) << "robot 2 closes up on its leader faster";

  std::istringstream recorded(csv.str());
  const auto again = replay(recorded, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->commands, 4 * 30 * 25);
  EXPECT_EQ(again->different, 0) << again->first;

  const Rows repeated = run(parsed(text_as_done(experiment, changed.all())), {});
  EXPECT_EQ(repeated.actions(), changed.actions());
}

TEST(Actions, AParameterOutOfItsRangeIsRefusedWithTheRange) {
  auto session = Session::open(leader_follower(), Session::Clock::virtual_);
  ASSERT_TRUE(session);
  const auto refusal = [&](const char* name, double value) {
    const auto answer = (*session)->set_parameter(name, value);
    return answer ? std::string() : answer.error();
  };
  EXPECT_EQ(refusal("ahead", 0.6), "parameter ahead: found 0.6, allowed: 0.005 to 0.5 m");
  EXPECT_EQ(refusal("alpha_l", -1.0), "parameter alpha_l: found -1, allowed: 0 to 100 1/s");
  EXPECT_EQ(refusal("k_xx", 1.0), "parameter k_xx: found 1, allowed: alpha_l, alpha_phi, ahead");
  EXPECT_EQ(refusal("ahead", 0.5), "");
  auto paper = Session::open(twelve_seconds(), Session::Clock::virtual_);
  ASSERT_TRUE(paper);
  const auto none = (*paper)->set_parameter("ahead", 0.1);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error(), "parameter ahead: found 0.1, allowed: none: the law declares no parameters");
}

TEST(Actions, AParameterThatTheQueueHasNoRoomForIsRefused) {
  auto session = Session::open(leader_follower(), Session::Clock::virtual_);
  ASSERT_TRUE(session);
  int taken = 0;
  std::string refused;
  for (int k = 0; k < 10'000 && refused.empty(); ++k) {
    const auto answer = (*session)->set_parameter("alpha_l", 1.0 + 0.001 * (k % 1000));
    answer ? void(++taken) : void(refused = answer.error());
  }
  EXPECT_GT(taken, 64);
  EXPECT_EQ(refused, "too many commands at once: this one was not executed, repeat it");
  (*session)->run();
  EXPECT_TRUE((*session)->set_parameter("alpha_l", 2.0)) << "the ticks have made room";
}

TEST(Actions, AParameterThatTheLawDoesNotDeclareIsRefusedInAFile) {
  const auto wrong = [](const std::string& does) {
    const auto experiment =
        parse_experiment(paper_experiment().source + "\n[[operator]]\nt = 1\ndoes = \"" + does + "\"\n", "leader.toml",
                         {"controller.kind=\"leader_follower\""});
    return experiment ? std::string() : experiment.error().front().message();
  };
  EXPECT_EQ(wrong("parameter alpha_l 0.8 -> 1.5"), "");
  EXPECT_NE(wrong("parameter beta 0.8 -> 1.5").find("allowed: alpha_l, alpha_phi, ahead"), std::string::npos);
  EXPECT_NE(wrong("parameter alpha_l 0.8 -> 500").find("allowed: 0 to 100 1/s"), std::string::npos);
}

}  // namespace
}  // namespace skein::app
