// Experiment files: what is read, and that nothing makes the reader fall over.
#include "app/experiment/experiment_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "app/experiment/certificate.h"
#include "app/record/csv_writer.h"
#include "tests/app/experiment_texts.h"
#include "tests/files.h"
#include "tests/places.h"
#include "tests/property.h"

namespace skein::app {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
TEST(ExperimentFile, AnEmptyFileIsThePaperWithoutPerturbations) {
  const Experiment e = good("");
  EXPECT_EQ(e.ticks(), 2100);
  EXPECT_EQ(e.period(), 0.04);
  ASSERT_EQ(e.robots.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(e.robots[i].tag, static_cast<int>(i) + 1);
    EXPECT_EQ(e.robots[i].motor, core::MotorModel::ideal);
    EXPECT_EQ(e.robots[i].drive.max_step_rate, 1000.0);
  }
  EXPECT_EQ(e.controller.gains.k_xx, core::PairTable(4, 0.008));
  EXPECT_EQ(e.controller.gains.k_tt, core::PairTable(4, 0.025));
  EXPECT_EQ(e.controller.gains.k_yy, core::PairTable(4, 0.08));
  EXPECT_TRUE(e.perturbations.empty());
  EXPECT_FALSE(e.expect.final_error);
}

TEST(ExperimentFile, ThePaperIsBuiltInAndSaysTheDefaults) {
  const Experiment paper = paper_experiment(), defaults = good("");
  EXPECT_EQ(paper.name, defaults.name);
  EXPECT_EQ(paper.reference.start, defaults.reference.start);
  EXPECT_EQ(paper.controller.k, defaults.controller.k);
  EXPECT_EQ(paper.controller.gains, defaults.controller.gains);
  EXPECT_EQ(paper.avoidance.K_o, defaults.avoidance.K_o);
  EXPECT_EQ(paper.shield.distance, defaults.shield.distance);
  ASSERT_EQ(paper.perturbations.size(), 3u);
  EXPECT_EQ(paper.perturbations[0].robot, 1u);
  EXPECT_EQ(paper.perturbations[1].robot, 2u);
  EXPECT_EQ(paper.perturbations[2].robot, 0u);
  EXPECT_EQ(paper.expect.collisions, 0);

  const core::Gains gains = make_gains(paper), printed = core::paper_gains(4);
  EXPECT_EQ(gains.k_x, printed.k_x);
  EXPECT_EQ(gains.k_theta, printed.k_theta);
  EXPECT_EQ(gains.c_tt, printed.c_tt);
  EXPECT_NEAR(make_path(paper.reference.path)->length(), 4.196, 1e-3);
  EXPECT_EQ(make_limits(paper, 0).v_max, 0.1);
}

TEST(ExperimentFile, EveryShippedExperimentLoads) {
  for (const char* name : {"platoon", "platoon-loopback", "uncoupled", "lemniscate", "diamond-to-line", "corner-blends",
                           "unequal-speeds", "parking"}) {
    const auto e = load_experiment(experiments + name + ".toml");
    ASSERT_TRUE(e) << e.error().front().message();
    EXPECT_EQ(e->name, name);
    EXPECT_EQ(e->directory + "/", experiments);
  }
  const auto loopback = load_experiment(experiments + "platoon-loopback.toml");
  EXPECT_EQ(loopback->robots[3].link, RobotSpec::Link::loopback);
  EXPECT_EQ(loopback->robots[3].motor, core::MotorModel::epuck2);
  EXPECT_EQ(loopback->robots[3].drive.max_step_rate, 1100.0);
  EXPECT_EQ(loopback->camera.source, "synthetic");
  EXPECT_EQ(load_experiment(experiments + "uncoupled.toml")->controller.gains.k_yy.largest(), 0.0);
}

TEST(ExperimentFile, ReadsEveryKey) {
  const Experiment e = good(R"(
    name = "all"
    duration = 10
    rate = 50
    seed = 7
    arena = { width = 3, height = 2.5 }
    reference = { kind = "platoon", speed = 0.04, spacing = 0.2, start = -1, path = { shape = "circle", radius = 0.6 } }
    obstacle = [{ x = 0.1, y = -0.2, radius = 0.05 }]
    avoidance = { enabled = false, alpha = 0.08, beta = 0.09, p = 3, K_a = 0.2, K_o = 0.03 }
    shield = { enabled = false, distance = 0.08, gamma = 3 }
    camera = { source = "v4l2:/dev/video1", calibration = "cal.toml" }
    links = { reply_timeout = 0.5, command_silence = 0.3 }
    estimation = { bridge = 0.5, actuation_delay = 0.06 }
    simulation = { pose_noise = 0.001, heading_noise = 0.01, latency = 0.08, dropout = 0.1, slip = 0.02 }
    expect = { final_error = 0.01, min_distance = 0.07, formation_first = false, collisions = 2 }
    [robot_defaults]
    link = "sim"
    model = "epuck1"
    track = 0.054
    [[robot]]
    tag = 12
    wheel_diameter = 0.0405
    [[robot]]
    link = "rfcomm:10:00:e8:aa:bb:cc/2"
    adapter = "hci1"
    model = "epuck2"
    [controller]
    saturation = "algebraic"
    coupling = "bounded"
    v_max = 0.11
    omega_max = 1.8
    c_x = 19
    c_xx = 1
    l_xx = 90
    c_theta = 2
    c_tt = 0.05
    l_tt = 80
    c_yy = 1.4
    k_y = 10
    k = 150
    [controller.gains]
    k_xx = [[2, 1, 0.01]]
    [[gain_change]]
    t = 6
    k_yy = 0.0
    [[gain_change]]
    t = 5
    ramp = 2
    k_xx = [[1, 2, 0.02]]
    [[perturb]]
    t = 4
    robot = 1
    dtheta = 1.5
    [[perturb]]
    t = 3
    robot = 1
    dx = 0.1
    dy = -0.1
  )");
  EXPECT_EQ(e.ticks(), 500);
  EXPECT_EQ(e.seed, 7u);
  EXPECT_EQ(e.arena_height, 2.5);
  EXPECT_EQ(e.reference.path.shape, PathSpec::Shape::circle);
  EXPECT_EQ(e.reference.path.radius, 0.6);
  EXPECT_EQ(e.controller.saturation, core::Saturation::algebraic);
  EXPECT_EQ(e.controller.coupling, core::Coupling::bounded);
  const core::Gains gains = make_gains(e);
  EXPECT_EQ(gains.v_max[1], 0.11);
  EXPECT_EQ(gains.l_tt(0, 1), 80.0);
  EXPECT_EQ(gains.k_xx(0, 1), 0.01);
  EXPECT_EQ(gains.k_yy(0, 1), 0.08);
  EXPECT_EQ(e.robots[0].tag, 12);
  EXPECT_EQ(e.robots[0].motor, core::MotorModel::epuck1);
  EXPECT_EQ(e.robots[0].drive.track, 0.054);
  EXPECT_EQ(e.robots[0].drive.wheel_diameter, 0.0405);
  EXPECT_EQ(e.robots[1].tag, 2);
  EXPECT_EQ(e.robots[1].link, RobotSpec::Link::device);
  EXPECT_EQ(e.robots[1].address, "rfcomm:10:00:e8:aa:bb:cc/2");
  EXPECT_EQ(e.robots[1].adapter, "hci1");
  EXPECT_EQ(e.robots[1].motor, core::MotorModel::epuck2);
  EXPECT_EQ(e.avoidance.p, 3);
  EXPECT_EQ(e.obstacles.at(0).radius, 0.05);
  EXPECT_EQ(e.camera.calibration, "cal.toml");
  EXPECT_EQ(e.links.reply_timeout, 0.5);
  EXPECT_EQ(e.command_silence(), 0.3);
  EXPECT_EQ(e.estimation.actuation_delay, 0.06);
  EXPECT_EQ(e.simulation.slip, 0.02);
  EXPECT_EQ(e.gain_changes.at(0).t, 5.0);  // in the order of time
  EXPECT_EQ(e.gain_changes[0][core::GainName::k_xx], core::PairTable(2, 0.02));
  EXPECT_FALSE(e.gain_changes[0][core::GainName::k_yy]);
  EXPECT_EQ(e.gain_changes[1][core::GainName::k_yy], core::PairTable(2, 0.0));
  EXPECT_EQ(e.perturbations.at(0).dy, -0.1);
  EXPECT_EQ(e.perturbations[1].dtheta, 1.5);
  EXPECT_EQ(e.expect.formation_first, false);
  EXPECT_EQ(e.expect.collisions, 2);
}

TEST(ExperimentFile, ANameIsAsLongAsItsCharactersNotItsBytes) {
  const auto named = [](int characters) {
    std::string name;
    for (int k = 0; k < characters; ++k) name += "\xf0\x9f\xa4\x96";
    return parse_experiment("name = \"" + name + "\"\n", "e.toml");
  };
  EXPECT_TRUE(named(100)) << "400 bytes";
  ASSERT_FALSE(named(101));
  EXPECT_THAT(named(101).error().front().message(), HasSubstr("allowed: 1 to 100 characters in one line"));
}

TEST(ExperimentFile, SixtyFourRobotsAreAllowedAndNoMore) {
  const auto robots = [](int n) {
    std::string text =
        "arena = { width = 50, height = 50 }\nreference.path = { width = 20, height = 20 }\n"
        "controller.gains = { k_xx = 0, k_tt = 0, k_yy = 0 }\n";
    for (int i = 0; i < n; ++i) text += "[[robot]]\n";
    return text;
  };
  EXPECT_EQ(good(robots(64)).robots.size(), 64u);
  EXPECT_THAT(messages(robots(65)), ElementsAre(HasSubstr("robot: found 65 robots, allowed: 1 to 64")));
}

/// The paper's couplings of every pair would take all of v_max from eight robots on.
TEST(ExperimentFile, AGroupOfAnySizeNeedsNoGains) {
  for (const std::size_t n : {2u, 6u, 7u, 20u, 64u}) {
    std::string text = "arena = { width = 50, height = 50 }\nreference.path = { width = 20, height = 20 }\n";
    for (std::size_t i = 0; i < n; ++i) text += "[[robot]]\n";
    const Experiment e = good(text);
    EXPECT_TRUE(certify(e).sound()) << n << " robots";
    const double partners = static_cast<double>(std::clamp<std::size_t>(n - 1, 1, 5));
    EXPECT_NEAR(e.controller.gains.k_xx.row_sum(0), 0.008 * partners, 1e-12) << n << " robots";
    EXPECT_NEAR(e.controller.gains.k_tt.row_sum(0), 0.025 * partners, 1e-12) << n << " robots";
    EXPECT_NEAR(e.controller.gains.k_yy.row_sum(0), 0.08 * partners, 1e-12) << n << " robots";
  }
}

TEST(ExperimentFile, ASingleRobotNeedsNoCouplings) {
  EXPECT_EQ(good("[[robot]]").robots.size(), 1u);
}

TEST(ExperimentFile, AFileThatCannotBeReadIsAProblem) {
  EXPECT_EQ(load_experiment("/nowhere/e.toml").error().at(0).message(),
            "/nowhere/e.toml: cannot be read: No such file or directory");
  EXPECT_EQ(load_experiment(experiments).error().at(0).message(),
            experiments + ": cannot be read: it is a folder, allowed: a file");
}

/// The keys that a table has, out of what is said of one that it has not.
std::vector<std::string> known_keys(const std::string& table) {
  const std::string said = messages(table + "\nno_such_key = 1").back(), list = "allowed";
  std::istringstream words(said.substr(said.find(": ", said.rfind(list)) + 2));
  std::vector<std::string> keys;
  for (std::string key; words >> key;) keys.push_back(key.substr(0, key.find(',')));
  return keys;
}

TEST(Documentation, NamesEveryKey) {
  const std::string text = test::read_file(test::in_source("docs/experiment-file.md"));
  std::size_t keys = 0;
  for (const char* table :
       {"",
        "[arena]",
        "[reference]",
        "[reference]\nkind='formation'\nshape='v'",
        "[reference]\nkind='formation'\nshape='v'\n[[reference.change]]\nt=1\nduration=1\nshape='v'",
        "[reference.path]",
        "[reference.path]\nshape='spline'\npoints=[[0,0],[1,0],[0,1]]",
        "[controller]",
        "[controller.gains]",
        "[[gain_change]]\nt=1\nk_xx=0",
        "[avoidance]",
        "[shield]",
        "[[obstacle]]\nx=0\ny=0\nradius=1",
        "[robot_defaults]",
        "[[robot]]",
        "[camera]",
        "[links]",
        "[estimation]",
        "[failure]",
        "[simulation]",
        "[[perturb]]\nt=0\nrobot=1\ndx=0",
        "[[operator]]\nt=0\ndoes='hold r1'",
        "[expect]"})
    for (const std::string& key : known_keys(table)) {
      ++keys;
      EXPECT_TRUE(text.find('`' + key + '`') != std::string::npos || text.find('[' + key + ']') != std::string::npos ||
                  text.find('.' + key + ']') != std::string::npos)
          << table << ": " << key;
    }
  EXPECT_GT(keys, 70u);
}

TEST(Documentation, NamesEveryColumn) {
  const std::string text = test::read_file(test::in_source("docs/csv.md"));
  std::ostringstream csv;
  CsvWriter writer(csv, paper_experiment());
  std::istringstream columns(csv.str().substr(csv.str().rfind("\nt,") + 1));
  for (std::string column; std::getline(columns, column, ',');) {
    if (column.ends_with('\n')) column.pop_back();
    if (column.starts_with("delta_")) column = "delta_1_2";
    const std::size_t robot = column.starts_with('r') ? column.find('_') + 1 : 0;
    EXPECT_NE(text.find('`' + column.substr(robot) + '`'), std::string::npos) << column;
  }
}

// Whatever becomes of a file in an editor, on a bad disk or in a merge: an experiment or problems, never a crash.
TEST(ExperimentFile, SurvivesMutations) {
  const std::string original = test::read_file(experiments + "platoon.toml");
  ASSERT_FALSE(original.empty());
  const std::vector<std::string> pieces{"[",     "]",          "[[robot]]", "=", "\"",     "-1",   "nan",
                                        "1e999", "[[",         "{",         "}", "robot",  "'''",  "\n",
                                        "#",     "[[1,2]]",    "\xff",      ",", "1e-320", "true", "0x7fffffffffffffff",
                                        ".",     "2020-01-01", "[robot.x]", "64"};
  test::holds("parse_experiment returns", [&] {
    std::string text = original;
    const int changes = *rc::gen::inRange(1, 8);
    for (int k = 0; k < changes; ++k) {
      const std::size_t at = *rc::gen::inRange<std::size_t>(0, text.size() + 1);
      const std::size_t length = *rc::gen::inRange<std::size_t>(0, 40);
      switch (*rc::gen::inRange(0, 3)) {
        case 0:
          text.erase(at, length);
          break;
        case 1:
          text.insert(at, *rc::gen::elementOf(pieces));
          break;
        default:
          text.insert(at, text.substr(*rc::gen::inRange<std::size_t>(0, text.size() + 1), length));
      }
    }
    const auto e = parse_experiment(text, "e.toml");
    if (e) {
      RC_ASSERT(e->robots.size() >= 1u);
      RC_ASSERT(e->ticks() >= 1);
      make_gains(*e);
    } else {
      RC_ASSERT(!e.error().empty());
      for (const Problem& problem : e.error()) RC_ASSERT(!problem.message().empty());
    }
  });
}

TEST(ExperimentText, AHeadingMayBeRoundedAndBeUpToAFullTurn) {
  for (const auto& [written, heading] :
       {std::pair{"3.1416", -core::pi}, {"-3.1416", core::pi}, {"4.7124", -core::pi / 2}, {"0.25", 0.25}}) {
    const auto e = parse_experiment(fmt::format("[[robot]]\nstart = [0.2, 0, {}]\n", written), "e.toml");
    ASSERT_TRUE(e) << e.error().front().message();
    EXPECT_NEAR(e->robots[0].start->theta, heading, 2e-5) << written;
    EXPECT_LE(std::abs(e->robots[0].start->theta), core::pi);
  }
}

}  // namespace
}  // namespace skein::app
