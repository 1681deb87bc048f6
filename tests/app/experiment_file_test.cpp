// Experiment files: what is read, what is refused, and what is said about it.
#include "app/experiment_file.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/property.h"

namespace skein::app {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
using Sets = std::vector<std::string>;

const std::string experiments = SKEIN_SOURCE_DIR "/resources/experiments/";

std::vector<std::string> messages(const std::string& text, const Sets& sets = {}) {
  std::vector<std::string> result;
  if (const auto e = parse_experiment(text, "e.toml", sets); !e)
    for (const Problem& problem : e.error()) result.push_back(problem.message());
  return result;
}

Experiment good(const std::string& text, const Sets& sets = {}) {
  const auto e = parse_experiment(text, "e.toml", sets);
  if (e) return *e;
  ADD_FAILURE() << text << "\n" << e.error().front().message();
  return paper_experiment();
}

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
  EXPECT_NEAR(make_reference(paper).path().length(), 4.196, 1e-3);
  EXPECT_EQ(make_limits(paper, 0).v_max, 0.1);
}

TEST(ExperimentFile, EveryShippedExperimentLoads) {
  for (const char* name : {"platoon", "platoon-loopback", "uncoupled"}) {
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
  EXPECT_EQ(e.estimation.actuation_delay, 0.06);
  EXPECT_EQ(e.simulation.slip, 0.02);
  EXPECT_EQ(e.gain_changes.at(0).t, 5.0);  // in the order of time
  EXPECT_EQ(e.gain_changes[0].k_xx, core::PairTable(2, 0.02));
  EXPECT_FALSE(e.gain_changes[0].k_yy);
  EXPECT_EQ(e.gain_changes[1].k_yy, core::PairTable(2, 0.0));
  EXPECT_EQ(e.perturbations.at(0).dy, -0.1);
  EXPECT_EQ(e.perturbations[1].dtheta, 1.5);
  EXPECT_EQ(e.expect.formation_first, false);
  EXPECT_EQ(e.expect.collisions, 2);
}

struct Refused {
  const char* text;
  const char* message;  ///< begins so
};
void PrintTo(const Refused& refused, std::ostream* out) {
  *out << refused.text;
}

class RefusedText : public testing::TestWithParam<Refused> {};

TEST_P(RefusedText, WithItsPlaceAndWhatIsAllowed) {
  EXPECT_THAT(messages(GetParam().text), Contains(StartsWith(GetParam().message))) << GetParam().text;
}

INSTANTIATE_TEST_SUITE_P(
    OneKey, RefusedText,
    testing::Values(
        Refused{"\n  name = 3", "e.toml:2:10: name: found 3, allowed: a text in quotes"},
        Refused{"name = ''", "e.toml:1:8: name: found \"\", allowed: 1 to 100 characters in one line"},
        Refused{"name = 'a\\nb'\nname2 = 1",
                "e.toml:2:1: name2: unknown key; did you mean name? allowed: name, duration, rate, seed, arena"},
        Refused{"duration = -1", "e.toml:1:12: duration: found -1, allowed: a number above 0 and up to 86400 s"},
        Refused{"duration = inf", "e.toml:1:12: duration: found inf, allowed: a number above 0"},
        Refused{"duration = nan", "e.toml:1:12: duration: found nan, allowed: a number above 0"},
        Refused{"duration = 1e-3", "e.toml:1:12: duration: found 0.001 s at 25 Hz, which is 0 ticks, allowed: 1 to"},
        Refused{"rate = 'fast'", "e.toml:1:8: rate: found \"fast\", allowed: a number from 1 to 1000 Hz"},
        Refused{"seed = 1.5", "e.toml:1:8: seed: found 1.5, allowed: a whole number from 0 to"},
        Refused{"seed = 1979-05-27", "e.toml:1:8: seed: found a date or a time, allowed:"},
        Refused{"arena = 3", "e.toml:1:9: arena: found 3, allowed: a table [arena]"},
        Refused{"[arena]\nwidth = [1]", "e.toml:2:9: arena.width: found an array, allowed: a number from 0.1 to 100 m"},
        Refused{"[arena]\ndepth = 1", "e.toml:2:1: arena.depth: unknown key, allowed in arena: width, height"},
        Refused{"[reference]\nkind = 'swarm'", "e.toml:2:8: reference.kind: found \"swarm\", allowed: \"platoon\""},
        Refused{"[reference]\nkind = 1", "e.toml:2:8: reference.kind: found 1, allowed: \"platoon\""},
        Refused{"[reference.path]\nshape = 'circle'",
                "e.toml:1:1: reference.path.radius: missing, allowed: the circle's"},
        Refused{"[reference.path]\nshape = 'circle'\nradius = 0.3\nwidth = 1",
                "e.toml:4:1: reference.path.width: unknown key, allowed in reference.path: shape, radius"},
        Refused{"[controller]\ncoupling = 'strong'",
                "e.toml:2:12: controller.coupling: found \"strong\", allowed: \"paper\", \"bounded\""},
        Refused{"[controller]\nk_z = 1", "e.toml:2:1: controller.k_z: unknown key; did you mean k_y? allowed in"},
        Refused{"[controller]\nc_x = 0", "e.toml:2:7: controller.c_x: found 0, allowed: a number above 0 and up to"},
        Refused{"[avoidance]\nenabled = 1", "e.toml:2:11: avoidance.enabled: found 1, allowed: true or false"},
        Refused{"[avoidance]\np = 0", "e.toml:2:5: avoidance.p: found 0, allowed: a whole number from 1 to 50"},
        Refused{"[shield]\ndistance = 0.05",
                "e.toml:2:12: shield.distance: found 0.05, allowed: a number from 0.07 to"},
        Refused{"[shield]\ngamma = 26",
                "e.toml:2:9: shield.gamma: found 26, allowed: a number above 0 and up to 25 1/s"},
        Refused{"[[obstacle]]\nx = 0\ny = 5\nradius = 0.1",
                "e.toml:3:5: obstacle.1.y: found 5, allowed: a number from -0.75 to 0.75 m"},
        Refused{"[[obstacle]]\nx = 0\ny = 0", "e.toml:1:1: obstacle.1.radius: missing"},
        Refused{"obstacle = [1]", "e.toml:1:13: obstacle.1: found 1, allowed: tables [[obstacle]]"},
        Refused{"[robot]\ntag = 1", "e.toml:1:1: robot: found a table, allowed: tables [[robot]]"},
        Refused{"robot = []", "e.toml:1:9: robot: found 0 robots, allowed: 1 to 64"},
        Refused{"[[robot]]\ntag = 587", "e.toml:2:7: robot.1.tag: found 587, allowed: a whole number from 0 to 586"},
        Refused{"[[robot]]\nlink = 'usb'",
                "e.toml:2:8: robot.1.link: found \"usb\", allowed: \"sim\", \"loopback\", \"rfcomm"},
        Refused{"[[robot]]\nmodel = 'epuck3'",
                "e.toml:2:9: robot.1.model: found \"epuck3\", allowed: \"ideal\", \"epuck1\", \"epuck2\""},
        Refused{"[[robot]]\nadapter = 'usb'", "e.toml:2:11: robot.1.adapter: adapter \"usb\" is neither"},
        Refused{"[[robot]]\ntrack = 5.3", "e.toml:2:9: robot.1.track: found 5.3, allowed: a number from 0.01 to 0.5 m"},
        Refused{"[robot_defaults]\ntag = 3", "e.toml:2:1: robot_defaults.tag: unknown key"},
        Refused{"[camera]\nsource = 'webcam'",
                "e.toml:2:10: camera.source: found \"webcam\", allowed: \"none\", \"synth"},
        Refused{"[camera]\nsource = 'video:'", "e.toml:2:10: camera.source: found \"video:\", allowed:"},
        Refused{"[estimation]\nbridge = 0", "e.toml:2:10: estimation.bridge: found 0, allowed: a number above 0"},
        Refused{"[simulation]\ndropout = 2", "e.toml:2:11: simulation.dropout: found 2, allowed: a number from 0 to 1"},
        Refused{"[simulation]\nlatency = 3",
                "e.toml:2:11: simulation.latency: found 3, allowed: a number from 0 to 2.48 s"},
        Refused{"[[perturb]]\nrobot = 1\ndx = 0.1", "e.toml:1:1: perturb.1.t: missing, allowed: the time in s"},
        Refused{"[[perturb]]\nt = 1\ndx = 0.1",
                "e.toml:1:1: perturb.1.robot: missing, allowed: the robot to move, from 1"},
        Refused{"[[perturb]]\nt = 1\nrobot = 1",
                "e.toml:1:1: perturb.1.dx: missing, allowed: at least one of dx, dy, dth"},
        Refused{"[[perturb]]\nt = 1\nrobot = 5\ndx = 0.1",
                "e.toml:3:9: perturb.1.robot: found 5, allowed: a whole number from 1 to 4"},
        Refused{"[[perturb]]\nt = -1\nrobot = 1\ndx = 0.1",
                "e.toml:2:5: perturb.1.t: found -1, allowed: a number from 0 to 86400 s"},
        Refused{"[[gain_change]]\nt = 1",
                "e.toml:1:1: gain_change.1.k_xx: missing, allowed: at least one of k_xx, k_tt"},
        Refused{"[[gain_change]]\nk_xx = 0", "e.toml:1:1: gain_change.1.t: missing"},
        Refused{"[[gain_change]]\nt = 1\nramp = 0\nk_xx = 0",
                "e.toml:3:8: gain_change.1.ramp: found 0, allowed: a number abo"},
        Refused{"[expect]\nfinal_erorr = 1", "e.toml:2:1: expect.final_erorr: unknown key; did you mean final_error?"},
        Refused{"[expect]\nformation_first = 'yes'",
                "e.toml:2:19: expect.formation_first: found \"yes\", allowed: true or"},
        Refused{"a = 1\na = 2", "e.toml:2:"}, Refused{"duration = ", "e.toml:1:"}, Refused{"[arena\n", "e.toml:1:"}));

INSTANTIATE_TEST_SUITE_P(
    GainsOfPairs, RefusedText,
    testing::Values(
        Refused{
            "[controller.gains]\nk_xx = [[1, 2, 0.1], [1, 5, 0.1]]",
            "e.toml:2:22: controller.gains.k_xx.2: found [1, 5, 0.1], allowed: [i, j, value] with two different robots "
            "from 1 to 4 and a number from 0 to 100"},
        Refused{"[controller.gains]\nk_xx = [[1, 1, 0.1]]", "e.toml:2:9: controller.gains.k_xx.1: found [1, 1, 0.1]"},
        Refused{"[controller.gains]\nk_xx = [[1, 2, -0.1]]", "e.toml:2:9: controller.gains.k_xx.1: found [1, 2, -0.1]"},
        Refused{"[controller.gains]\nk_xx = [[1, 2]]", "e.toml:2:9: controller.gains.k_xx.1: found an array"},
        Refused{"[controller.gains]\nk_xx = [0.1]", "e.toml:2:9: controller.gains.k_xx.1: found 0.1"},
        Refused{"[controller.gains]\nk_xx = [[1, 2, 0.001], [2, 1, 0.001]]",
                "e.toml:2:24: controller.gains.k_xx.2: found the pair 2, 1 again"},
        Refused{"[controller.gains]\nk_xx = true",
                "e.toml:2:8: controller.gains.k_xx: found true, allowed: a number from"}));

INSTANTIATE_TEST_SUITE_P(
    KeysTogether, RefusedText,
    testing::Values(
        Refused{"[[robot]]\ntag = 4\n[[robot]]\ntag = 4",
                "e.toml:4:7: robot.2.tag: found 4, which robot 1 has already, allowed: a tag of its own"},
        Refused{"[[robot]]\ntag = 2\n[[robot]]", "e.toml:3:1: robot.2.tag: found 2, which robot 1 has already"},
        Refused{"[[robot]]\nlink = 'serial:/dev/a'\n[[robot]]\nlink = 'serial:/dev/a'\n[camera]\nsource='v4l2:x'\n"
                "calibration='c'",
                "e.toml:4:8: robot.2.link: found \"serial:/dev/a\", which robot 1 has already"},
        Refused{"[[robot]]\nlink = 'serial:/dev/a'", "e.toml: camera.source: found \"none\", allowed"},
        Refused{"[camera]\nsource = 'synthetic'\n[[robot]]\nlink = 'serial:/dev/a'",
                "e.toml:2:10: camera.source: found \"synthetic\", allowed: \"v4l2:DEVICE\", \"video:FILE\" or"},
        Refused{"[camera]\nsource = 'images:x'", "e.toml:1:1: camera.calibration: missing, allowed: the file that"},
        Refused{"[[robot]]\nlink = 'loopback'\nmodel = 'ideal'",
                "e.toml:3:9: robot.1.model: found \"ideal\", allowed: \"ep"},
        Refused{"[robot_defaults]\nmodel = 'ideal'\nlink = 'loopback'",
                "e.toml:2:9: robot_defaults.model: found \"ideal\""},
        Refused{"duration = 86400\nrate = 1000",
                "e.toml:1:12: duration: found 86400 s at 1000 Hz, which is 8.64e+07 ticks"},
        Refused{"[reference.path]\nradius = 0.5",
                "e.toml:2:10: reference.path.radius: found 0.5, allowed: up to 0.45 m, half of the shorter side"},
        Refused{"[reference.path]\nwidth = 1.95",
                "e.toml:1:1: reference.path: found a path of 1.95 m x 0.9 m, allowed: up to 1.93 m x 1.43 m"},
        Refused{
            "[avoidance]\nalpha = 0.12\nbeta = 0.12",
            "e.toml:2:9: avoidance.alpha: found a detection region of 0.12 m x 0.12 m (alpha, beta), allowed: below"},
        Refused{"[shield]\ndistance = 0.116", "e.toml:2:12: shield.distance: found 0.116, allowed: below 0.115 m"},
        Refused{"[reference]\nspacing = 0.06",
                "e.toml:2:11: reference.spacing: found 0.06, with which robots of 0.07 m width come within"},
        Refused{"[reference]\nspeed = 0.08", "e.toml:2:9: reference.speed: (18f) fails for robot 1 by 0.004 m/s"},
        Refused{"[reference]\nspeed = 0.2",
                "e.toml:2:9: reference.speed: found 0.2, for which (18f) fails whatever the"},
        Refused{"[controller.gains]\nk_xx = 0.02",
                "e.toml:2:8: controller.gains.k_xx: (18f) fails for robot 1 by 0.01 m/s: v_max 0.1 - reference 0.05 - "
                "couplings 0.06 leaves k_x = -0.01, which must be above 0; allowed: k_xx below 0.0166667 for all pairs "
                "(a sum "
                "below 0.05 over robot 1's pairs), or reference.speed below 0.04"},
        Refused{"[controller.gains]\nk_yy = 0.3",
                "e.toml:2:8: controller.gains.k_yy: (18g) fails for robot 1 by 0.2452 rad/s: omega_max 1.7 - reference "
                "0.970168 - couplings 0.975 leaves k_theta = -0.2452, which must be above 0; allowed: k_yy below "
                "0.218277 for"},
        Refused{"[controller.gains]\nk_xx = [[3, 4, 0.06]]",
                "e.toml:2:8: controller.gains.k_xx: (18f) fails for robot 3 by 0.01 m/s"},
        Refused{"[[gain_change]]\nt = 20\nk_yy = 0\n[[gain_change]]\nt = 10\nk_xx = 0.03",
                "e.toml:6:8: gain_change.2.k_xx: (18f) fails for robot 1 by 0.04 m/s"},
        Refused{"[simulation]\nlatency = 0.3", "e.toml: estimation.bridge: found 0.2"}));

TEST(ExperimentFile, AKeyThatIsNotThereIsNamedWithoutAPlace) {
  EXPECT_THAT(
      messages("[simulation]\nlatency = 0.3"),
      ElementsAre("e.toml: estimation.bridge: found 0.2, allowed: above simulation.latency, 0.3 s, or every pose is "
                  "too old when it comes and every robot lost"));
}

TEST(ExperimentFile, SaysEverythingAtOnceInTheOrderOfTheFile) {
  const std::vector<std::string> said =
      messages("[shield]\ngamma = 0\n[arena]\nheight = 0\nwide = 1\n[expect]\ncollisions = -1", {"rate=0"});
  ASSERT_EQ(said.size(), 5u);
  EXPECT_THAT(said[0], HasSubstr("e.toml:2:9: shield.gamma"));
  EXPECT_THAT(said[1], HasSubstr("e.toml:4:10: arena.height"));
  EXPECT_THAT(said[2], HasSubstr("e.toml:5:1: arena.wide"));
  EXPECT_THAT(said[3], HasSubstr("e.toml:7:14: expect.collisions"));
  EXPECT_THAT(said[4], HasSubstr("--set rate=0: rate: found 0, allowed: a number from 1 to 1000 Hz"));
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

TEST(ExperimentFile, ASingleRobotNeedsNoCouplings) {
  EXPECT_EQ(good("[[robot]]").robots.size(), 1u);
}

TEST(ExperimentFile, AFileThatCannotBeReadIsAProblem) {
  EXPECT_EQ(load_experiment("/nowhere/e.toml").error().at(0).message(),
            "/nowhere/e.toml: cannot be read: No such file or directory");
  EXPECT_EQ(load_experiment(experiments).error().at(0).message(), experiments + ": cannot be read: it is a directory");
}

TEST(Set, ChangesAnyKey) {
  const std::string text = "[[robot]]\ntag = 1\n[[robot]]\ntag = 2\n[[perturb]]\nt = 1\nrobot = 1\ndx = 0.1";
  const Experiment e =
      good(text, {"duration=5", "controller.v_max=0.09", "robot.2.tag=7", "perturb.1.dx=0.2", "camera.source=synthetic",
                  "name=\"two words\"", "controller.gains.k_xx=[[1,2,0.01]]", "perturb.2={t=2, robot=2, dy=0.1}",
                  "reference.path={shape=\"circle\", radius=0.5}"});
  EXPECT_EQ(e.duration, 5.0);
  EXPECT_EQ(e.controller.v_max, 0.09);
  EXPECT_EQ(e.robots[1].tag, 7);
  EXPECT_EQ(e.perturbations.at(0).dx, 0.2);
  EXPECT_EQ(e.perturbations.at(1).robot, 1u);
  EXPECT_EQ(e.camera.source, "synthetic");
  EXPECT_EQ(e.name, "two words");
  EXPECT_EQ(e.controller.gains.k_xx(0, 1), 0.01);
  EXPECT_EQ(e.reference.path.shape, PathSpec::Shape::circle);
  EXPECT_EQ(good("", {"name=a b"}).name, "a b");
  EXPECT_EQ(good("", {"duration=1", "duration=2"}).duration, 2.0);
}

TEST(Set, CountsTheFourRobotsThatAFileWithoutAnyHas) {
  const Experiment e = good("", {"robot.2.tag=20"});
  ASSERT_EQ(e.robots.size(), 4u);
  EXPECT_EQ(e.robots[1].tag, 20);
  EXPECT_EQ(e.robots[3].tag, 4);
}

TEST(Set, IsRefusedByItsOwnText) {
  EXPECT_THAT(messages("", {"foo"}), ElementsAre("--set foo: found no =, allowed: key=value"));
  EXPECT_THAT(messages("", {"rate=fast"}),
              ElementsAre("--set rate=fast: rate: found \"fast\", allowed: a number from 1 to 1000 Hz"));
  EXPECT_THAT(messages("", {"controler.v_max=1"}),
              ElementsAre(HasSubstr("--set controler.v_max=1: controler: unknown key; did you mean controller?")));
  EXPECT_THAT(
      messages("", {"robot.6.tag=1"}),
      ElementsAre("--set robot.6.tag=1: robot: found 6, allowed: a number from 1 to 5 and a key behind it, as in "
                  "robot.1.key=value"));
  EXPECT_THAT(messages("", {"robot.x=1"}),
              ElementsAre(HasSubstr("--set robot.x=1: robot: found x, allowed: a number")));
  EXPECT_THAT(messages("", {"=1"}), ElementsAre(HasSubstr("--set =1: ")));
  EXPECT_THAT(messages("", {"a b=1"}), ElementsAre(HasSubstr("--set a b=1: ")));
  EXPECT_THAT(messages("", {"rate.x=1"}), ElementsAre(HasSubstr("--set rate.x=1: rate: found a table, allowed:")));
}

TEST(Source, GivesTheSameExperimentAgain) {
  const Sets sets{"seed=9", "controller.gains.k_yy=[[1, 2, 0.1], [3, 4, 0.05000000000000001]]", "robot.3.tag=30"};
  const auto changed = load_experiment(experiments + "platoon.toml", sets);
  ASSERT_TRUE(changed);
  const auto again = parse_experiment(changed->source, "source");
  ASSERT_TRUE(again) << again.error().front().message() << changed->source;
  EXPECT_EQ(again->source, changed->source);
  EXPECT_EQ(again->seed, 9u);
  EXPECT_EQ(again->controller.gains, changed->controller.gains);
  EXPECT_EQ(again->robots[2].tag, 30);
  EXPECT_EQ(again->perturbations[2].dy, changed->perturbations[2].dy);
  EXPECT_EQ(good("rate = 50").source, "rate = 50\n");
}

TEST(Source, KeepsEveryBitOfANumberThatWasSet) {
  test::holds("the source says the same double", [](std::uint64_t bits) {
    const double speed = 0.01 + 0.04 * static_cast<double>(bits) / 18446744073709551616.0;
    char text[64];
    std::snprintf(text, sizeof text, "reference.speed=%.17g", speed);
    const auto e = parse_experiment("", "", {text});
    RC_ASSERT(e.has_value());
    RC_ASSERT(parse_experiment(e->source, "")->reference.speed == speed);
  });
}

std::string file_text(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Whatever becomes of a file in an editor, on a bad disk or in a merge: an experiment or problems, never a crash.
TEST(ExperimentFile, SurvivesMutations) {
  const std::string original = file_text(experiments + "platoon.toml");
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

TEST(Set, SurvivesAnything) {
  const std::vector<std::string> keys{"robot",      "1",     "x",    "",   "perturb",
                                      "controller", "gains", "k_xx", "\"", "99999999999"};
  test::holds("parse_experiment returns", [&] {
    std::string set = *rc::gen::elementOf(keys);
    for (int k = *rc::gen::inRange(0, 4); k > 0; --k) set += "." + *rc::gen::elementOf(keys);
    const auto e = parse_experiment("", "e.toml", {set + "=" + *rc::gen::arbitrary<std::string>()});
    RC_ASSERT(e.has_value() || !e.error().empty());
  });
}

}  // namespace
}  // namespace skein::app
