// Independent trajectories in experiment files: what is read, what is refused, and that such an experiment runs.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "tests/app/experiment_texts.h"
#include "tests/app/fixture.h"

namespace skein::app {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// Two robots that swap places along one line; `more` goes into [reference], `first` into the first trajectory.
std::string swap(const std::string& more, const std::string& first = "") {
  return "duration = 40\n[reference]\nkind = 'independent'\n" + more +
         "\n[[robot]]\ntrajectory = { path = { shape = 'line', from = [-0.5, 0], to = [0.5, 0] } " + first +
         "}\n[[robot]]\n[robot.trajectory]\nspeed = 0.06\npath = { shape = 'line', from = [0.5, 0.02], to = [-0.5, "
         "0.02] }\n";
}

TEST(Trajectories, AreReadWithTheDefaultsOfTheReference) {
  const Experiment e = good(swap("speed = 0.04\nmay_meet = true", ", t = 1.5, turn_rate = -0.3"));
  ASSERT_EQ(e.robots.size(), 2u);
  const auto reference = make_reference(e);
  EXPECT_EQ(reference->at(0, 0.0).pose, (core::Pose{-0.5, 0.0, 0.0}));
  EXPECT_EQ(reference->at(0, 1.5).twist, core::Twist{});
  EXPECT_NEAR(reference->at(0, 14.0).twist.v, 0.04, 1e-15);
  EXPECT_NEAR(reference->at(1, 10.0).twist.v, 0.06, 1e-15);
  EXPECT_NEAR(reference->at(1, 40.0).pose.x, -0.5, 1e-12);
  EXPECT_EQ(reference->at(0, 40.0).twist.omega, -0.3);
  EXPECT_EQ(
      good("[reference]\nkind='independent'\n[[robot]]\ntrajectory={path={shape='circle',radius=0.2,centre=[0.5,0.1]}}")
          .robots[0]
          .trajectory->path.centre,
      (core::Point{0.5, 0.1}));
}

TEST(Trajectories, KeepTheirTimeWhenItIsGiven) {
  const Experiment e = good(swap("may_meet = true", ", duration = 20"));
  const auto reference = make_reference(e);
  EXPECT_LT(reference->at(0, 19.9).pose.x, 0.5);
  EXPECT_EQ(reference->at(0, 20.0).pose.x, 0.5);
}

TEST(Trajectories, ThatMeetAreRefusedUnlessTheFileSaysSo) {
  EXPECT_THAT(messages(swap("")),
              Contains(StartsWith("e.toml:8:1: robot.2.trajectory: found a reference that comes within 0.02")));
  EXPECT_THAT(messages(swap("may_meet = true\n[shield]\nenabled = false")),
              Contains(StartsWith("e.toml:4:12: reference.may_meet: found true, allowed: with the shield enabled")));
  // Also then they must be able to stand where they begin and where they rest.
  EXPECT_THAT(
      messages("[reference]\nkind = 'independent'\nmay_meet = true\n[[robot]]\ntrajectory = { path = { shape = "
               "'line', from = [-0.5, 0], to = [0.5, 0] } }\n[[robot]]\ntrajectory = { path = { shape = 'line', "
               "from = [-0.5, 0.3], to = [0.5, 0.05] } }"),
      Contains(StartsWith("e.toml:7:14: robot.2.trajectory: found a reference that comes within 0.05 m of robot "
                          "1's at t = ")));
}

/// The field has a detection region, planned routes have none.
TEST(Trajectories, OfPlannedRoutesMayRestAsNearAsTheShieldAllows) {
  const auto beside = [](const std::string& more) {
    return "[reference]\nkind = 'independent'\nmay_meet = true\n" + more +
           "[[robot]]\ntrajectory = { path = { shape = 'line', from = [-0.5, 0], to = [0.5, 0] } }\n"
           "[[robot]]\ntrajectory = { path = { shape = 'line', from = [-0.5, 0.3], to = [0.5, 0.08] } }\n";
  };
  EXPECT_THAT(messages(beside("")), Contains(HasSubstr("avoidance.alpha: found a detection region of 0.1 m x 0.1 m")));
  EXPECT_THAT(messages(beside("[avoidance]\nkind = 'plan'\n")), IsEmpty());
}

/// Two robots that cross the floor side by side and change sides; `first` is the first one's path.
std::string cross(const std::string& more, const std::string& first) {
  return "duration = 40\n[reference]\nkind = 'independent'\nmay_meet = true\n" + more +
         "\n[[robot]]\ntrajectory = { path = { " + first +
         " } }\n[[robot]]\ntrajectory = { speed = 0.06, path = { shape = 'line', from = [-0.5, 0.3], to = [0.5, -0.3] "
         "} }\n";
}
const char* const line = "shape = 'line', from = [-0.5, -0.3], to = [0.5, 0.3]";

TEST(Trajectories, OfInterchangeablePlacesAreTheShortest) {
  const Experiment e = good(cross("interchangeable = true", line));
  EXPECT_EQ(e.robots[0].trajectory->path.points, (std::vector<core::Point>{{-0.5, -0.3}, {0.5, -0.3}}));
  EXPECT_EQ(e.robots[1].trajectory->path.points, (std::vector<core::Point>{{-0.5, 0.3}, {0.5, 0.3}}));
  EXPECT_EQ(e.robots[1].trajectory->speed, 0.06) << "only the end is exchanged";
  EXPECT_EQ(good(cross("", line)).robots[0].trajectory->path.points.back(), (core::Point{0.5, 0.3}));
}

/// Robots whose places are interchangeable; each with what it is, where its line begins, and where it ends.
struct Interchangeable {
  const char* what;
  core::Point from, to;
};
std::string interchangeable(const std::string& more, const std::vector<Interchangeable>& robots) {
  std::string text =
      "[reference]\nkind = 'independent'\nmay_meet = true\ninterchangeable = true\n[avoidance]\nkind = 'plan'\n" + more;
  for (const auto& [what, from, to] : robots)
    text +=
        fmt::format("[[robot]]\n{}\ntrajectory = {{ path = {{ shape = 'line', from = [{}, {}], to = [{}, {}] }} }}\n",
                    what, from.x, from.y, to.x, to.y);
  return text;
}

core::Point end_of(const Experiment& e, std::size_t i) {
  return e.robots[i].trajectory->path.points.back();
}

/// The nearest place of the large robot is that beside another one, where only a small robot has room.
TEST(Trajectories, OfInterchangeablePlacesLeaveRoomForRobotsOfEverySize) {
  const Experiment e = good(interchangeable("", {{"model = 'khepera4'", {-0.5, 0.0}, {0.5, 0.4}},
                                                 {"", {-0.5, -0.3}, {0.3, 0.0}},
                                                 {"", {-0.5, 0.3}, {0.3, -0.09}}}));
  EXPECT_EQ(end_of(e, 0), (core::Point{0.5, 0.4}));
  EXPECT_EQ(end_of(e, 1), (core::Point{0.3, -0.09}));
  EXPECT_EQ(end_of(e, 2), (core::Point{0.3, 0.0}));
}

/// Nor is a body over the edge, where the small robot's was not.
TEST(Trajectories, OfInterchangeablePlacesLeaveRoomAtTheEdge) {
  const Experiment e =
      good(interchangeable("", {{"model = 'khepera4'", {0.8, 0.0}, {0.0, 0.6}}, {"", {0.0, 0.0}, {0.96, 0.0}}}));
  EXPECT_EQ(end_of(e, 0), (core::Point{0.0, 0.6}));
  EXPECT_EQ(end_of(e, 1), (core::Point{0.96, 0.0}));
}

/// Both robots are at a place already. No line leads from a point to itself: each keeps the heading of its own.
TEST(Trajectories, OfRobotsThatStandOnEachOthersPlacesLetThemStay) {
  const Experiment e = good(interchangeable("", {{"", {-0.4, 0.0}, {0.4, 0.0}}, {"", {0.4, 0.0}, {-0.4, 0.0}}}));
  const auto reference = make_reference(e);
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    const double x = i == 0 ? -0.4 : 0.4;
    EXPECT_EQ(end_of(e, i), (core::Point{x, 0.0}));
    EXPECT_NEAR(reference->at(i, 0.0).pose.x, x, 1.1e-4);
    EXPECT_NEAR(std::abs(reference->at(i, e.duration).pose.theta), i == 0 ? 0.0 : std::numbers::pi, 1e-9);
  }
}

/// A wall from edge to edge: each robot's place is behind it, and the other one's is not.
TEST(Trajectories, OfInterchangeablePlacesLeadRoundObstacles) {
  std::string wall;
  for (int k = -7; k <= 7; ++k) wall += fmt::format("[[obstacle]]\nx = 0\ny = {}\nradius = 0.06\n", 0.1 * k);
  const std::vector<Interchangeable> robots{{"", {-0.15, 0.6}, {0.15, 0.6}}, {"", {0.15, -0.6}, {-0.15, -0.6}}};
  const Experiment e = good(interchangeable(wall, robots));
  EXPECT_EQ(end_of(e, 0), (core::Point{-0.15, -0.6}));
  EXPECT_EQ(end_of(e, 1), (core::Point{0.15, 0.6}));
  EXPECT_EQ(end_of(good(interchangeable("", robots)), 0), (core::Point{0.15, 0.6})) << "the shortest where no wall is";
}

/// The shorter of two ways is too short for a trajectory that begins farther along it.
TEST(Trajectories, OfInterchangeablePlacesCanBeDriven) {
  const std::string text = interchangeable("", {{"", {-0.5, 0.0}, {0.5, 0.0}}, {"", {0.5, 0.2}, {-0.4, 0.0}}});
  EXPECT_EQ(end_of(good(text), 0), (core::Point{-0.4, 0.0}));
  std::string later = text;
  later.replace(later.find("trajectory = {"), 14, "trajectory = { start = 0.2,");
  EXPECT_EQ(end_of(good(later), 0), (core::Point{0.5, 0.0}));
}

TEST(Trajectories, AreInterchangeableOnlyIfAllAreWholeLines) {
  EXPECT_THAT(messages(cross("interchangeable = true", "shape = 'circle', radius = 0.2")),
              Contains("e.toml:5:19: reference.interchangeable: found true, allowed: if every robot's trajectory is a "
                       "whole line; robot 1's is not"));
}

struct Wrong {
  const char* first;  ///< in the first trajectory
  const char* message;
};
class WrongTrajectory : public testing::TestWithParam<Wrong> {};

TEST_P(WrongTrajectory, IsRefused) {
  EXPECT_THAT(messages(swap("may_meet = true", GetParam().first)), Contains(StartsWith(GetParam().message)));
}
INSTANTIATE_TEST_SUITE_P(
    Trajectories, WrongTrajectory,
    testing::Values(
        Wrong{", duration = 3", "e.toml:6:88: robot.1.trajectory.duration: found 3, allowed: at least 7.74597 s"},
        Wrong{", duration = 30, speed = 0.1",
              "e.toml:6:88: robot.1.trajectory.duration: found 30, allowed: only one of"},
        Wrong{", distance = 1.2", "e.toml:6:88: robot.1.trajectory.distance: found 1.2, allowed: up to 1 m"},
        Wrong{", start = 1.0", "e.toml:6:85: robot.1.trajectory.start: found 1, allowed: from 0 to below 1 m"},
        Wrong{", speed = 0", "e.toml:6:85: robot.1.trajectory.speed: found 0, with which the robot never arrives"},
        Wrong{", speed = 0.2", "e.toml:6:85: robot.1.trajectory.speed: found a reference of up to 0.2 m/s, for which"},
        Wrong{", turn_rate = 2",
              "e.toml:6:89: robot.1.trajectory.turn_rate: found 2, for which (18g) fails with any couplings; "
              "allowed: below 1.7"},
        Wrong{", sped = 2", "e.toml:6:77: robot.1.trajectory.sped: unknown key; did you mean speed?"}));

TEST(Trajectories, BelongToIndependentReferencesAlone) {
  EXPECT_THAT(messages("[[robot]]\ntrajectory = { path = { shape = 'circle', radius = 0.3 } }"),
              Contains(StartsWith("e.toml:2:14: robot.1.trajectory: found with a common reference")));
  EXPECT_THAT(messages("[reference]\nkind = 'independent'"),
              Contains(StartsWith("e.toml: robot.1.trajectory: missing, allowed: a trajectory for every robot")));
  EXPECT_THAT(messages("[reference.path]\nshape = 'line'\nfrom = [0, 0]\nto = [1, 0]"),
              Contains(StartsWith("e.toml:2:9: reference.path.shape: found an open path, allowed: a closed one")));
  EXPECT_THAT(
      messages("[reference]\nkind='independent'\n[[robot]]\ntrajectory={turn_rate=1,path={shape='circle',radius=0.3}}"),
      Contains(StartsWith("e.toml:4:23: robot.1.trajectory.turn_rate: found with a closed path, which")));
}

TEST(Trajectories, AreDrivenFromRestToRest) {
  // Past each other, 0.15 m apart; what meets is left to the shield's own tests.
  const Experiment e = good(
      "duration = 30\n[reference]\nkind = 'independent'\nspeed = 0.06\n[[robot]]\ntrajectory = { path = { shape = "
      "'line', "
      "from = [-0.5, -0.1], to = [0.5, -0.1] } }\n[[robot]]\ntrajectory = { path = { shape = 'polyline', points = "
      "[[0.5, 0.1], "
      "[-0.4, 0.1], [-0.4, 0.4]] } }\n[[robot]]\ntrajectory = { path = { shape = 'circle', radius = 0.15, centre = [0, "
      "0.5] }, distance = 0.6, t = 3 }");
  const auto rows = test::simulate(e);
  const auto reference = make_reference(e);
  for (std::size_t i = 0; i < 3; ++i) {
    const RobotRecord& last = rows.back().robots[i];
    EXPECT_LT(core::distance(last.truth, reference->at(i, 1e3).pose), 1e-3);
    EXPECT_EQ(last.nominal.twist, core::Twist{});
    for (const TickRecord& row : rows) EXPECT_LT(core::distance(row.robots[i].truth, row.robots[i].nominal.pose), 5e-3);
  }
}

}  // namespace
}  // namespace skein::app
