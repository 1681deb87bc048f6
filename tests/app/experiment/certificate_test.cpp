// What is said of an experiment before it runs follows its gains wherever they go.
#include "app/experiment/certificate.h"
#include "app/experiment/ways.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stop_token>

#include "app/experiment/experiment_file.h"

namespace skein::app {
namespace {

/// The paper's experiment without the changes of its gains.
Experiment steady() {
  Experiment e = paper_experiment();
  e.gain_changes.clear();
  return e;
}

TEST(Certificate, JudgesTheDelayWithTheGainsOfEveryChange) {
  Experiment e = steady();
  const double coupled = smallest_delay_margin(e).margin.delay;
  GainChange couple;
  couple.t = 40.0;
  couple.ramp = 2.0;
  for (const core::GainName name : core::gain_names) {
    couple[name] = core::table(e.controller.gains, name);
    core::table(e.controller.gains, name).fill(0.0);
  }
  const double uncoupled = smallest_delay_margin(e).margin.delay;
  ASSERT_GT(uncoupled, 1.1 * coupled);
  e.gain_changes.assign(1, couple);
  EXPECT_DOUBLE_EQ(smallest_delay_margin(e).margin.delay, coupled);
}

TEST(Certificate, LooksAtTheMarginsWhereChangesEnd) {
  Experiment e = steady();
  const Certificate before = certify(e);
  ASSERT_TRUE(before.holds());
  GainChange change;
  change.t = 10.0;
  change.ramp = 5.0;
  change[core::GainName::k_xx] = core::PairTable(e.robots.size(), e.controller.v_max);
  e.gain_changes.assign(1, change);
  const Certificate after = certify(e);
  EXPECT_FALSE(after.holds());
  EXPECT_LT(after.robots[0].k_x.value, before.robots[0].k_x.value);
  EXPECT_GT(after.robots[0].k_x.t, 10.0);
}

/// The certificate of every tick, without leaving any out.
struct Everywhere {
  double k_x = std::numeric_limits<double>::infinity(), k_theta = k_x, wheel = 0.0;
};
std::vector<Everywhere> everywhere(const Experiment& e) {
  const auto reference = make_reference(e);
  core::Gains gains = make_gains(e);
  core::GainSchedule schedule(e.controller.gains);
  std::vector<Everywhere> worst(e.robots.size());
  std::vector<core::Twist> twists(e.robots.size());
  std::size_t next = 0;
  for (std::int64_t k = 0; k < e.ticks(); ++k) {
    const double t = static_cast<double>(k) / e.rate;
    for (; next < e.gain_changes.size() && t >= e.gain_changes[next].t; ++next)
      for (const core::GainName name : core::pair_names)
        if (e.gain_changes[next][name]) schedule.ramp(name, *e.gain_changes[next][name], e.gain_changes[next].ramp);
    if (k > 0) schedule.step(e.period());
    gains.k_xx = schedule.now().k_xx, gains.k_tt = schedule.now().k_tt, gains.k_yy = schedule.now().k_yy;
    for (std::size_t i = 0; i < twists.size(); ++i) twists[i] = reference->at(i, t).twist;
    core::use_policy(gains, twists);
    for (std::size_t i = 0; i < twists.size(); ++i) {
      const auto& drive = e.robots[i].drive;
      worst[i].k_x = std::min(worst[i].k_x, gains.k_x[i]);
      worst[i].k_theta = std::min(worst[i].k_theta, gains.k_theta[i]);
      worst[i].wheel =
          std::max(worst[i].wheel,
                   (std::abs(twists[i].v) + 0.5 * drive.track * std::abs(twists[i].omega)) / drive.max_wheel_speed());
    }
  }
  return worst;
}

TEST(Certificate, MissesNothingOfLapsAndTimesThatItLeavesOut) {
  const auto of = [](const char* text) {
    const auto e = parse_experiment(text, "e.toml");
    EXPECT_TRUE(e.has_value()) << (e ? std::string() : messages(e.error()));
    return e ? *e : steady();
  };
  const std::string robots = "[[robot]]\ntag = 1\n[[robot]]\ntag = 2\n[[robot]]\ntag = 3\n";
  const std::string changes =
      "[[gain_change]]\nt = 400\nramp = 5\nk_xx = 0.012\n[[gain_change]]\nt = 900\nramp = 100\nk_tt = 0.0\n";
  const std::string ellipse = "path = { shape = 'ellipse', width = 1.3, height = 0.9 }\n";
  const std::string spaced =
      "duration = 1500\n[reference]\nkind = 'platoon'\n[[reference.change]]\nt = 500\nduration = 30\nspacing = 0.14\n";
  const std::string shaped =
      "duration = 1500\n[reference]\nkind = 'formation'\nshape = 'v'\nspeed = 0.03\nspacing = 0.12\n{}{}"
      "[[reference.change]]\nt = 600\nduration = 40\nshape = 'v'\nspacing = 0.15\n{}";
  for (const std::string& text :
       {fmt::format("duration = 1500\n[reference]\nkind = 'platoon'\n{}{}{}", ellipse, robots, changes),
        fmt::format("{}{}", spaced, robots), fmt::format(fmt::runtime(shaped), ellipse, robots, changes)}) {
    const Experiment e = of(text.c_str());
    const Certificate quick = certify(e);
    const std::vector<Everywhere> all = everywhere(e);
    constexpr double of_a_tick = 1e-4;  // laps do not begin at ticks
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_NEAR(quick.robots[i].k_x.value, all[i].k_x, of_a_tick * e.controller.v_max) << text;
      EXPECT_NEAR(quick.robots[i].k_theta.value, all[i].k_theta, of_a_tick * e.controller.omega_max) << text;
      EXPECT_NEAR(quick.robots[i].wheel.value, all[i].wheel, of_a_tick) << text;
    }
  }
}

TEST(Certificate, SaysOfALapForEverWhatItSaysOfTwo) {
  for (const char* stops : {"lemniscate", "circle"}) {
    const auto of = [&](const char* duration) {
      return *parse_experiment(std::string("[reference]\npath = { shape = '") + stops +
                                   (stops[0] == 'l' ? "', width = 1.3, height = 0.9 }" : "', radius = 0.5 }"),
                               "e.toml", {std::string("duration=") + duration});
    };
    const Certificate brief = certify(of("300")), eternal = certify(of("86400"));
    EXPECT_EQ(brief.theorem.holds, eternal.theorem.holds);
    EXPECT_NEAR(brief.robots[0].k_theta.value, eternal.robots[0].k_theta.value, 1e-4);
  }
}

TEST(Certificate, ThatIsNoLongerWantedComesAtOnce) {
  std::stop_source unwanted;
  unwanted.request_stop();
  Experiment e = steady();
  EXPECT_EQ(certify(e, unwanted.get_token()).robots.at(0).v.t, 0.0) << "it went on after nobody wanted it";
  EXPECT_EQ(certify(e, unwanted.get_token()).robots.at(0).k_x.value, std::numeric_limits<double>::infinity());
}

TEST(Certificate, RefusesALoopThatSamplingMakesUnstable) {
  EXPECT_TRUE(certify(steady()).sound());
  for (const auto& [gain, value] : {std::pair{&ControllerSpec::c_theta, 500.0}, std::pair{&ControllerSpec::c_x, 2000.0},
                                    std::pair{&ControllerSpec::k, 20000.0}}) {
    Experiment e = steady();
    e.controller.*gain = value;
    const Certificate certificate = certify(e);
    EXPECT_TRUE(certificate.holds()) << "(18) says nothing of sampling";
    EXPECT_FALSE(certificate.sampled_loop_stable()) << value;
    EXPECT_FALSE(certificate.sound()) << value;
    EXPECT_NE(as_lines(certificate).find("sampled_loop: UNSTABLE at 25 Hz"), std::string::npos);
    EXPECT_NE(as_lines(certificate).find(" mm at 0 ms, "), std::string::npos) << "how far they swing";
  }
}

/// Two ramps of different length may take more on the way than at either end.
TEST(Certificate, LooksAtTrackingGainsOnTheirWay) {
  const auto of = [](const char* second) {
    return certify(*parse_experiment(
        std::string("duration = 30\n[controller]\npolicy = 'fixed'\nk_x = 0.026\nk_theta = 0.3\n"
                    "[[gain_change]]\nt = 10\nramp = 5\nk_x = [[1, 0.01], [2, 0.01], [3, 0.01], [4, 0.01]]\n"
                    "[[gain_change]]\nk_xx = 0.013\n") +
            second,
        "e.toml"));
  };
  EXPECT_TRUE(of("t = 10\nramp = 5").holds());
  const Certificate early = of("t = 10\nramp = 1");
  EXPECT_FALSE(early.holds());
  EXPECT_NEAR(early.robots[0].f.value, -(3 * 0.005 - 0.016 / 5), 1e-9)
      << "k_xx is there after 1 s, k_x a fifth of its way";
  EXPECT_NEAR(early.robots[0].f.t, 11.0, 0.05);
  EXPECT_NEAR(of("t = 10\nramp = 5").robots[0].k_x.value, 0.01, 1e-12);
}

TEST(Certificate, SaysThatKThetaJumpsOnlyWhereItIsTheRemainder) {
  constexpr const char* jumps = "k_theta of (36) jumps";
  EXPECT_NE(as_lines(certify(*parse_experiment("duration = 30", "e.toml"))).find(jumps), std::string::npos);
  const auto given =
      parse_experiment("duration = 30\n[controller]\npolicy = 'fixed'\nk_x = 0.02\nk_theta = 0.3", "e.toml");
  EXPECT_EQ(as_lines(certify(*given)).find(jumps), std::string::npos);
}

/// k_x that falls and k_x that rises can both make the loop weaker.
TEST(Certificate, DelayMarginIsTheSmallestThatTheTrackingGainsEverHave) {
  const std::string fixed = "duration = 30\n[controller]\npolicy = 'fixed'\nk_theta = 0.3\nk_x = ";
  const auto margin = [&](const std::string& text) {
    return certify(*parse_experiment(fixed + text, "e.toml")).delay.margin.delay;
  };
  const double slow = margin("0.005"), fast = margin("0.02");
  EXPECT_GT(std::abs(slow - fast), 1e-3);
  EXPECT_DOUBLE_EQ(margin("0.005\n[[gain_change]]\nt = 10\nk_x = 0.02"), std::min(slow, fast));
  EXPECT_DOUBLE_EQ(margin("0.02\n[[gain_change]]\nt = 10\nk_x = 0.005"), std::min(slow, fast));
}

TEST(Certificate, RefusesGainsThatLeaveTrackingNextToNothing) {
  Experiment e = steady();
  // v_max 0.1 - v_ref 0.05 - 3 k_xx leaves 0.2 um/s.
  core::table(e.controller.gains, core::GainName::k_xx).fill((0.05 - 2e-7) / 3.0);
  const Certificate certificate = certify(e);
  EXPECT_TRUE(certificate.holds());
  EXPECT_FALSE(certificate.keeps_tracking());
  EXPECT_FALSE(certificate.sound());
}

TEST(Certificate, SaysThatThePapersCouplingsDoNotImplyTheLimits) {
  Experiment e = steady();
  EXPECT_NE(as_lines(certify(e)).find("limits_14: do NOT follow"), std::string::npos);
  e.controller.coupling = core::Coupling::bounded;
  EXPECT_NE(as_lines(certify(e)).find("limits_14: follow from (18f, g)"), std::string::npos);
}

Experiment parking(const std::string& obstacles) {
  const auto e = parse_experiment(
      "[reference]\nkind = 'independent'\nspeed = 0.05\n[avoidance]\nkind = 'plan'\n[controller]\nk_y = 4\n"
      "[[robot]]\nname = 'anna'\ntrajectory = { path = { shape = 'line', from = [-0.5, 0.0], to = [0.5, 0.0] } }\n" +
          obstacles,
      "e.toml");
  if (!e) ADD_FAILURE() << e.error().front().message();
  return e ? *e : Experiment{};
}

/// A wall of round posts across the arena, with a gap between two of their edges [m].
std::string wall(double gap) {
  std::string text;
  for (const double side : {-1.0, 1.0})
    for (int k = 0; 0.05 + 0.5 * gap + 0.09 * k < 0.74; ++k)
      text +=
          "[[obstacle]]\nx = 0.0\ny = " + std::to_string(side * (0.05 + 0.5 * gap + 0.09 * k)) + "\nradius = 0.05\n";
  return text;
}

TEST(MissingWays, AreNamedBeforeARun) {
  EXPECT_TRUE(missing_ways(parking("")).empty());
  EXPECT_TRUE(missing_ways(parking(wall(0.10))).empty()) << "a gap that the shield lets it through";
  const std::vector<std::string> none = missing_ways(parking(wall(0.07)));
  ASSERT_EQ(none.size(), 1u);
  EXPECT_EQ(none[0].find("no way for robot 1 (anna) from (-0.5, 0) to (0.5, 0) m"), 0u) << none[0];
  EXPECT_EQ(missing_ways(parking("[[obstacle]]\nx = 0.52\ny = 0.0\nradius = 0.03\n")).size(), 1u) << "on its place";
  EXPECT_TRUE(missing_ways(paper_experiment()).empty()) << "places that drive on";
}

TEST(MissingWays, AreThoseOfEachRobotsOwnBody) {
  const std::string larger =
      "[[robot]]\nradius = 0.06\n"
      "trajectory = { path = { shape = 'line', from = [-0.5, 0.4], to = [-0.2, 0.4] } }\n";
  EXPECT_TRUE(missing_ways(parking(larger + wall(0.10))).empty()) << "only the smaller robot needs the gap";
  const std::string through =
      "[[robot]]\nradius = 0.06\n"
      "trajectory = { path = { shape = 'line', from = [-0.5, 0.4], to = [0.5, 0.4] } }\n";
  const std::vector<std::string> none = missing_ways(parking(through + wall(0.10)));
  ASSERT_EQ(none.size(), 1u);
  EXPECT_EQ(none[0].find("no way for robot 2 from"), 0u) << none[0];
}

TEST(MissingWays, IncludeNoPlaceToWhichARobotComesAsNearAsCountsAsArrived) {
  const auto beside_the_edge = [](const char* y) {
    return parking(std::string("[[robot]]\ntrajectory = { path = { shape = 'line', from = [-0.5, 0.4], to = [0.0, ") +
                   y + "] } }\n[shield]\ndistance = 0.085\n");
  };
  EXPECT_TRUE(missing_ways(beside_the_edge("0.708")).empty()) << "8.5 mm nearer to the edge than the shield allows";
  EXPECT_EQ(missing_ways(beside_the_edge("0.711")).size(), 1u) << "11.5 mm";
}

}  // namespace
}  // namespace skein::app
