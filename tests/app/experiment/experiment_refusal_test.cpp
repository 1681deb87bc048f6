// Experiment files that are refused: each kind of mistake, its place, and what is said about it.
#include <gmock/gmock.h>

#include <filesystem>
#include <ostream>

#include <toml++/toml.h>

#include "tests/app/experiment_texts.h"

namespace skein::app {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

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
        Refused{"[camera]\ntrigger = 'Line\t0'",
                "e.toml:2:11: camera.trigger: found \"Line\\t0\", allowed: 0 to 100 characters in one line"},
        Refused{"name = 'a\\nb'\nname2 = 1",
                "e.toml:2:1: name2: unknown key; did you mean name? allowed: name, duration, rate, seed, robots_file, "
                "arena"},
        Refused{"duration = -1", "e.toml:1:12: duration: found -1, allowed: a number above 0 and up to 86400 s"},
        Refused{"duration = inf", "e.toml:1:12: duration: found inf, allowed: a number above 0"},
        Refused{"duration = nan", "e.toml:1:12: duration: found nan, allowed: a number above 0"},
        Refused{"duration = 1e-3", "e.toml:1:12: duration: found 0.001 s at 25 Hz, which is 0 ticks, allowed: 1 to"},
        Refused{"rate = 'fast'", "e.toml:1:8: rate: found \"fast\", allowed: a number from 1 to 1000 Hz"},
        Refused{"seed = 1.5", "e.toml:1:8: seed: found 1.5, allowed: a whole number from 0 to"},
        Refused{"seed = 1979-05-27", "e.toml:1:8: seed: found a date or a time, allowed:"},
        Refused{"arena = 3", "e.toml:1:9: arena: found 3, allowed: a table [arena]"},
        Refused{"[arena]\nwidth = [1]", "e.toml:2:9: arena.width: found [1], allowed: a number from 0.1 to 100 m"},
        Refused{"[arena]\ndepth = 1", "e.toml:2:1: arena.depth: unknown key, allowed in arena: width, height"},
        Refused{"[reference]\nkind = 'swarm'",
                "e.toml:2:8: reference.kind: found \"swarm\", allowed: \"platoon\", \"formation\", \"independent\""},
        Refused{"[reference]\nkind = 1", "e.toml:2:8: reference.kind: found 1, allowed: \"platoon\", \"formation\""},
        Refused{"[reference.path]\nshape = 'circle'",
                "e.toml:1:1: reference.path.radius: missing, allowed: the circle's"},
        Refused{"[reference.path]\nshape = 'circle'\nradius = 0.3\nwidth = 1",
                "e.toml:4:1: reference.path.width: unknown key, allowed in reference.path: shape, centre, radius"},
        Refused{"[controller]\ncoupling = 'strong'",
                "e.toml:2:12: controller.coupling: found \"strong\", allowed: \"paper\", \"bounded\""},
        Refused{"[controller]\nk_z = 1", "e.toml:2:1: controller.k_z: unknown key; did you mean k_y? allowed in"},
        Refused{"[controller]\nc_x = 0", "e.toml:2:7: controller.c_x: found 0, allowed: a number above 0 and up to"},
        Refused{"[avoidance]\nenabled = 1", "e.toml:2:11: avoidance.enabled: found 1, allowed: true or false"},
        Refused{"[avoidance]\nformation_waits = true",
                "e.toml:2:19: avoidance.formation_waits: found true, allowed: false, or true beside avoidance.kind = "
                "\"plan\""},
        Refused{"[avoidance]\nkind = 'plan'\nformation_waits = true\n[reference]\nspeed = 0.068",
                "e.toml:3:19: avoidance.formation_waits: found true, but its references and couplings leave it"},
        Refused{
            "[avoidance]\nkind = 'plan'\nformation_waits = true\n[[gain_change]]\nt = 9\nramp = 0.1\nk_xx = 0.009",
            "e.toml:6:8: gain_change.1.ramp: found 0.1 s, allowed beside avoidance.formation_waits: at least 0.16 s"},
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
        Refused{"[robot_defaults]\ntruth = {}", "e.toml:2:1: robot_defaults.truth: unknown key"},
        Refused{"[[robot]]\nwheel_ratio = 2",
                "e.toml:2:15: robot.1.wheel_ratio: found 2, allowed: a number from 0.8 to 1.25"},
        Refused{"[[robot]]\ntruth = {runaway = [1, 2]}",
                "e.toml:2:20: robot.1.truth.runaway: found [1, 2], allowed: [t] or [t, v, omega]: t a number from 0 to "
                "86400 s, v a number from -1 to 1 m/s"},
        Refused{"[[robot]]\ntruth = {wheel = 1}", "e.toml:2:10: robot.1.truth.wheel: unknown key"},
        Refused{"[camera]\nsource = 'v4l2:/dev/video0'\ncalibration = 'c.toml'\n[[robot]]\nlink = 'tcp:a'\ntruth = "
                "{track = 0.05}",
                "e.toml:6:9: robot.1.truth: found for a real robot"},
        Refused{"[robot_defaults]\ntag = 3", "e.toml:2:1: robot_defaults.tag: unknown key"},
        Refused{"[camera]\nsource = 'webcam'",
                "e.toml:2:10: camera.source: found \"webcam\", allowed: \"none\", \"synth"},
        Refused{"[camera]\nsource = 'video:'", "e.toml:2:10: camera.source: found \"video:\", allowed:"},
        Refused{"rate = 5\n[links]\ncommand_silence = 0.1",
                "e.toml:3:19: links.command_silence: found 0.1, allowed: a number above 0.2"},
        Refused{"[estimation]\nbridge = 0", "e.toml:2:10: estimation.bridge: found 0, allowed: a number above 0"},
        Refused{"[simulation]\ndropout = 2", "e.toml:2:11: simulation.dropout: found 2, allowed: a number from 0 to 1"},
        Refused{"[simulation]\nlatency = 3",
                "e.toml:2:11: simulation.latency: found 3, allowed: a number from 0 to 2.48 s"},
        Refused{"reference.kind = 'independent'\n[[robot]]\ntrajectory = { samples = [[1, 0, 0], [0.5, 0.1, 0]] }",
                "e.toml:3:26: robot.1.trajectory.samples: found t = 0.5 after 1, allowed: times that increase"},
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
        Refused{"[controller.gains]\nk_xx = [[1, 2]]", "e.toml:2:9: controller.gains.k_xx.1: found [1, 2]"},
        Refused{"[controller.gains]\nk_xx = [0.1]", "e.toml:2:9: controller.gains.k_xx.1: found 0.1"},
        Refused{"[controller.gains]\nk_xx = [[1, 2, 0.001], [2, 1, 0.001]]",
                "e.toml:2:24: controller.gains.k_xx.2: found the pair 2, 1 again"},
        Refused{"[controller.gains]\nk_xx = true",
                "e.toml:2:8: controller.gains.k_xx: found true, allowed: a number from"}));

INSTANTIATE_TEST_SUITE_P(
    KeysTogether, RefusedText,
    testing::Values(
        Refused{
            "[[robot]]\nstart = [0, 0, 0]\n[[robot]]\nstart = [0.05, 0, 0]",
            "e.toml:4:9: robot.2.start: found (0.05, 0) m, 0.05 m from where robot 1 begins, allowed: at least 0.07"},
        Refused{"[[robot]]\n[[robot]]\nstart = [0.65, 0.05, 0]",
                "e.toml:3:9: robot.2.start: found (0.65, 0.05) m, 0.02992 m from where robot 1 begins"},
        Refused{"[[robot]]\nstart = [0.2, 0, 0]\n[[obstacle]]\nx = 0.2\ny = 0.1\nradius = 0.1",
                "e.toml:2:9: robot.1.start: found (0.2, 0) m, 0.1 m from the centre of obstacle 1, allowed: at least"},
        Refused{"[[obstacle]]\nx = 0.65\ny = 0.07\nradius = 0.05",
                "e.toml:1:1: obstacle.1: found (0.65, 0.07) m, 0.04992 m from where robot 1 begins, allowed: at least"},
        Refused{
            "[[robot]]\nstart = [0.9, 0, 90]",
            "e.toml:2:9: robot.1.start: found [0.9, 0, 90], allowed: [x, y, theta] inside the arena: x from -1 to 1 "
            "m, y from -0.75 to 0.75 m, theta from -6.3 to 6.3 rad"},
        Refused{"[[robot]]\nstart = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21]",
                "e.toml:2:9: robot.1.start: found an array of 21, allowed: [x, y, theta]"},
        Refused{"[[robot]]\nstart = [0.99, 0, 0]",
                "e.toml:2:9: robot.1.start: found (0.99, 0) m, allowed: at least its radius, 0.035 m, from the arena"},
        Refused{"[[robot]]\ntag = 4\n[[robot]]\ntag = 4",
                "e.toml:4:7: robot.2.tag: found 4, which robot 1 already has, allowed: a different tag for each robot"},
        Refused{"[camera]\nsource = 'v4l2:/dev/video0'\ncalibration = 'a.toml'\n[[camera.also]]\n"
                "source = 'v4l2:/dev/video0'\ncalibration = 'b.toml'",
                "e.toml:5:10: camera.also.1.source: found \"v4l2:/dev/video0\", which camera 1 already has, allowed: a "
                "different source for each camera"},
        Refused{"[camera]\nsource = 'v4l2:/dev/video0'\ncalibration = 'a.toml'\n[[camera.also]]\n"
                "source = 'v4l2:/dev/video1'\ncalibration = 'a.toml'",
                "e.toml:6:15: camera.also.1.calibration: found \"a.toml\", which camera 1 already has, allowed: a "
                "calibration for each camera"},
        Refused{"[[robot]]\ntag = 2\n[[robot]]", "e.toml:3:1: robot.2.tag: found 2, which robot 1 already has"},
        Refused{"[[robot]]\nlink = 'serial:/dev/a'\n[[robot]]\nlink = 'serial:/dev/a'\n[camera]\nsource='v4l2:x'\n"
                "calibration='c'",
                "e.toml:4:8: robot.2.link: found \"serial:/dev/a\", which robot 1 already has"},
        // The same robot in other words.
        Refused{"[[robot]]\nlink = \"tcp:1.2.3.4\"\n[[robot]]\nlink = \"tcp:1.2.3.4:01000\"",
                "e.toml:4:8: robot.2.link: found \"tcp:1.2.3.4:01000\", which robot 1 already has"},
        Refused{"[[robot]]\nlink = \"udp:Robot.local:2626\"\n[[robot]]\nlink = \"udp:robot.LOCAL\"",
                "e.toml:4:8: robot.2.link: found \"udp:robot.LOCAL\", which robot 1 already has"},
        Refused{"[[robot]]\nlink = \"rfcomm:10:00:E8:AA:BB:CC/1\"\n[[robot]]\nlink = \"rfcomm:10:00:e8:aa:bb:cc\"",
                "e.toml:4:8: robot.2.link: found \"rfcomm:10:00:e8:aa:bb:cc\", which robot 1 already has"},
        Refused{"[[robot]]\nlink = \"serial:/dev/../dev/a\"\n[[robot]]\nlink = \"serial:/dev/a\"",
                "e.toml:4:8: robot.2.link: found \"serial:/dev/a\", which robot 1 already has"},
        Refused{"[[robot]]\nlink = 'serial:/dev/a'", "e.toml: camera.source: found \"none\", allowed"},
        Refused{"[camera]\nsource = 'synthetic'\n[[robot]]\nlink = 'serial:/dev/a'",
                "e.toml:2:10: camera.source: found \"synthetic\", allowed: images:DIR, video:FILE, v4l2:DEVICE, "
                "aravis:CAMERA, since"},
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
        Refused{"[reference.path]\nshape = 'spline'",
                "e.toml:1:1: reference.path.points: missing, allowed: at least 3 points"},
        Refused{"[reference.path]\nshape = 'spline'\npoints = [[0, 0], [1, 0]]",
                "e.toml:3:10: reference.path.points: found [[0, 0], [1, 0]], allowed: 3 to 1000 points [x, y] in m"},
        Refused{"[reference.path]\nshape = 'spline'\npoints = [[0, 0], [0.3, 0], [0.3, 0], [0, 0.3]]",
                "e.toml:3:10: reference.path.points: found (0.3, 0) twice in a row"},
        Refused{"[reference.path]\nshape = 'polyline'\npoints = [[-0.4, -0.4], [0.4, -0.4], [0.4, 0.4], [-0.4, 0.4]]\n"
                "radius = 0.5",
                "e.toml:4:10: reference.path.radius: found 0.5, allowed: up to 0.4 m"},
        Refused{"[reference.path]\nshape = 'polyline'\npoints = [[-0.8, 0], [0.8, 0], [0, 0]]",
                "e.toml:1:1: reference.path.radius: found 0.119, but the line turns back on itself"},
        Refused{"[reference.path]\nshape = 'polyline'\npoints = [[-0.9, -0.9], [0.4, -0.4], [0.4, 0.4], [-0.4, 0.4]]",
                "e.toml:1:1: reference.path: found a place ("},
        Refused{"[reference]\nkind = 'formation'\nshape = 'v'",
                "e.toml:1:1: reference.path.shape: found straights and arcs, allowed for a formation: \"circle\""},
        Refused{"[reference]\nkind = 'formation'\npath = { shape = 'circle', radius = 0.4 }",
                "e.toml:1:1: reference.shape: missing, allowed: the formation's shape, or offsets"},
        Refused{"[reference]\nkind = 'formation'\noffsets = [[0, 0]]\npath = { shape = 'circle', radius = 0.4 }",
                "e.toml:3:11: reference.offsets: found [[0, 0]], allowed: 4 points [x, y] in m"},
        Refused{
            "[reference]\nkind = 'formation'\nshape = 'line'\nspacing = 0.05\nspeed = 0.02\n"
            "path = { shape = 'circle', radius = 0.4 }",
            "e.toml:3:9: reference.shape: found places, or a change of them, with which robots of 0.07 m width come "
            "within 0.05 m"},
        Refused{"[reference]\nkind = 'formation'\nshape = 'line'\nspacing = 0.15\nspeed = 0.03\n"
                "path = { shape = 'circle', radius = 0.4 }\n"
                "change = [{ t = 1, duration = 5, shape = 'v' }, { t = 4, duration = 1, shape = 'v' }]",
                "e.toml:7:55: reference.change.2.t: found 4, allowed: 6 and later, when the previous change is over"},
        Refused{"[[reference.change]]\nt = 5\nduration = 8", "e.toml:1:1: reference.change.1.spacing: missing"},
        Refused{"[reference]\nchange = [{ t = 5, duration = 8, spacing = 0.07 }]",
                "e.toml:2:10: reference.change: found 0.07, with which robots of 0.07 m width come within"},
        Refused{"[reference]\nspacing = 0.2\nchange = [{ t = 1, duration = 2, spacing = 0.15 }]",
                "e.toml:3:10: reference.change: found changes of spacing in which robots drive up to 0.190625 m/s"},
        Refused{"[reference]\nkind = 'formation'\nshape = 'line'\nspacing = 0.183\nspeed = 0.028\nstart = 0.975\n"
                "path = { shape = 'circle', radius = 0.273 }\nchange = [{ t = 4, duration = 8, shape = 'column' }]",
                "e.toml:8:10: reference.change: found changes of shape in which robots drive up to"},
        Refused{"[reference]\nspeed = 0.08", "e.toml:2:9: reference.speed: (18f) fails for robot 1 by 0.004 m/s"},
        Refused{"[reference]\nspeed = 0.2", "e.toml:2:9: reference.speed: found 0.2, for which (18f) fails with any"},
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
  EXPECT_THAT(messages("[simulation]\nlatency = 0.3"),
              ElementsAre("e.toml: estimation.bridge: found 0.2, allowed: above simulation.latency, 0.3 s; otherwise "
                          "every pose is too old when it arrives and every robot is lost"));
}

/// Each part would cost the parser stack, and in the end the program.
TEST(ExperimentFile, AKeyOfVeryManyPartsIsRefused) {
  std::string key = "a";
  for (int k = 0; k < 100000; ++k) key += ".a";
  EXPECT_THAT(messages("rate = 25\n[" + key + "]\n"),
              ElementsAre(StartsWith("e.toml:2:2003: found a key of more than 1000 parts, allowed: ")));
  EXPECT_THAT(messages(key + " = 1\n"), ElementsAre(HasSubstr("found a key of more than 1000 parts")));
  EXPECT_THAT(messages("", {key + "=1"}), ElementsAre(HasSubstr("found a key of more than 1000 parts")));
  std::string numbers = "0.5";
  for (int k = 0; k < 2000; ++k) numbers += ", 0.5";
  EXPECT_THAT(messages("rate = [" + numbers + "]\n"), ElementsAre(HasSubstr("rate: found an array of 2001, ")));
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

// One mistake, one message: what is wrong leads to nothing else that is said.
TEST(ExperimentFile, AMistakeIsSaidOnce) {
  const struct {
    const char* text;
    const char* only;
  } cases[] = {
      {"[arena]\nwidth = 'a'\n[[obstacle]]\nx = 1.2\ny = 0\nradius = 0.1", "e.toml:2:9: arena.width: found"},
      {"[arena]\nwidht = 6\n[[robot]]\nstart = [2.5, 0, 0]", "e.toml:2:1: arena.widht: unknown key"},
      {"rate = '50 Hz'\n[shield]\ngamma = 40", "e.toml:1:8: rate: found"},
      {"rate = 2000\n[links]\ncommand_silence = 0.02", "e.toml:1:8: rate: found"},
      {"[reference]\nkind = 'formatoin'\nshape = 'v'\nspacing = 0.2", "e.toml:2:8: reference.kind: found"},
      {"[reference.path]\nshape = 'elipse'\nwidth = 1.9\npoints = [[0, 0]]", "e.toml:2:9: reference.path.shape: found"},
      {"[reference]\nspeed = 'slow'\n[controller.gains]\nk_xx = 0.02", "e.toml:2:9: reference.speed: found"},
      {"[controller]\nv_max = '1 m/s'\n[reference]\nspeed = 0.2", "e.toml:2:9: controller.v_max: found"},
      {"[controller]\npolicy = 'fix'\nk_x = 0.02\nk_theta = 0.2", "e.toml:2:10: controller.policy: found"},
      {"[controller]\ncommand = 3\ndeadline = 0.01\nlog = ['a']\n[controller.parameters]\na = 1",
       "e.toml:2:11: controller.command: found 3"},
      {"[controller]\nkind = 'leader'\n[controller.parameters]\nalpha_l = 1", "e.toml:2:8: controller.kind: found"},
      {"[[operator]]\nt = 1\ndoes = 3", "e.toml:3:8: operator.1.does: found 3"},
      {"robot = 6\n[[perturb]]\nt = 1\nrobot = 5\ndx = 0.1", "e.toml:1:9: robot: found 6"},
      {"robot = 6\n[controller.gains]\nk_xx = [[1, 5, 0.001]]", "e.toml:1:9: robot: found 6"},
      {"[shield]\ndistance = 'far'\n[reference]\nspacing = 0.11", "e.toml:2:12: shield.distance: found"},
      {"[avoidance]\nkind = 'plans'\nformation_waits = true", "e.toml:2:8: avoidance.kind: found"},
      {"[simulation]\nlatency = 0.3\n[estimation]\nbridge = '0.4'", "e.toml:4:10: estimation.bridge: found"},
      {"[camera]\nsource = 3\ntrigger = 'Line0'", "e.toml:2:10: camera.source: found 3"},
      {"[camera]\nsource = 'webcam'\ntrigger = 'Line0'", "e.toml:2:10: camera.source: found \"webcam\""},
      {"[camera]\nsource = 'v4l2:a'\ncalibration = 'a'\n[[camera.also]]\nsource = 3\ncalibration = 'b'",
       "e.toml:5:10: camera.also.1.source: found 3"},
      {"[[robot]]\nlink = 'serial'\n[camera]\nsource = 'none'", "e.toml:2:8: robot.1.link: found \"serial\""},
      {"robots_file = 'no-such.toml'\n[[robot]]\nname = 'anna'", "e.toml:1:15: robots_file: "},
      {"[[gain_change]]\nt = 1\nk_xx = 'a'", "e.toml:3:8: gain_change.1.k_xx: found"},
      {"[reference]\nkind = 'independent'\n[[robot]]\ntrajectory = { csv = 'no-such.csv' }", "no-such.csv: "},
  };
  for (const auto& [text, only] : cases) EXPECT_THAT(messages(text), ElementsAre(StartsWith(only))) << text;
}

/// Every leaf of a document, as a key of --set.
void add_keys(const toml::node& node, const std::string& name, std::vector<std::string>& keys) {
  if (const toml::table* const table = node.as_table()) {
    for (const auto& [key, value] : *table)
      add_keys(value, (name.empty() ? "" : name + ".") + std::string(key.str()), keys);
  } else if (const toml::array* const array = node.as_array(); array != nullptr && node.is_array_of_tables()) {
    for (std::size_t k = 0; k < array->size(); ++k) add_keys((*array)[k], name + "." + std::to_string(k + 1), keys);
  } else {
    keys.push_back(name);
  }
}

TEST(ExperimentFile, AValueOfAWrongKindIsSaidOnceWhateverKeyOfWhateverExperiment) {
  int keys_tried = 0;
  for (const auto& entry : std::filesystem::directory_iterator(experiments)) {
    if (entry.path().extension() != ".toml") continue;
    std::vector<std::string> keys;
    add_keys(toml::parse_file(entry.path().string()), "", keys);
    for (const std::string& key : keys) {
      if (key.starts_with("controller.parameters") || key == "name") continue;  // any name is one
      const auto refused = load_experiment(entry.path(), {key + "=1979-05-27"});
      ASSERT_FALSE(refused) << entry.path() << " " << key;
      EXPECT_EQ(refused.error().size(), 1u) << entry.path() << "\n" << messages(refused.error());
      ++keys_tried;
    }
  }
  EXPECT_GT(keys_tried, 300);
}

}  // namespace
}  // namespace skein::app
