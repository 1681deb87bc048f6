// --set: any key of a file, changed from the command line; and the source that says so afterwards.
#include <gmock/gmock.h>

#include <cstdio>

#include "app/experiment/experiment_sets.h"
#include "app/experiment/toml_places.h"
#include "tests/app/experiment_texts.h"
#include "tests/property.h"

namespace skein::app {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

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

/// Whether the values between two texts make the one the other.
void expect_sets(const std::string& before, const std::string& after, const Sets& expected) {
  const Experiment from = good(before), to = good(after);
  const std::vector<std::string> sets = sets_between(from.source, to.source);
  EXPECT_EQ(sets, expected);
  const auto again = parse_experiment(before, "again.toml", sets);
  ASSERT_TRUE(again) << again.error().front().message();
  EXPECT_EQ(parsed_toml(again->source).value(), parsed_toml(to.source).value()) << again->source;
}

TEST(SetsBetween, SayWhatWasChanged) {
  const std::string text = "seed = 1\n[controller.gains]\nk_xx = 0.01\n[[perturb]]\nt = 1\nrobot = 1\ndx = 0.1\n";
  const auto with = [&](const Sets& sets) { return good(text, sets).source; };
  expect_sets(text, text, {});
  for (const Sets& sets : std::vector<Sets>{
           {"controller.gains.k_xx=0.008", "seed=3"},
           {"perturb.1.dx=0.2"},
           {"perturb.2={ dy = 0.1, robot = 2, t = 2.0 }"},
           {"gain_change.1={ k_xx = 0.0, ramp = 1.0, t = 4.0 }", "gain_change.2={ k_xx = 0.005, ramp = 2.0, t = 9.0 }"},
           {"controller.gains.k_yy=[[1, 2, 0.01]]", "name=\"a \\\"b\\\"\""},
           {"operator.1={ does = \"uncouple r1 r2\", t = 1.5 }"},
           {"robot=[{ tag = 3 }, { tag = 4 }]"},
           {"reference.path.radius=0.5", "reference.path.shape=\"circle\""}})
    expect_sets(text, with(sets), sets);
  // What is gone is set as a whole.
  const std::string without = text.substr(0, text.find("[[perturb]]"));
  EXPECT_EQ(sets_between(text, without), Sets{"perturb=[]"});
  EXPECT_TRUE(good(text, {"perturb=[]"}).perturbations.empty());
  expect_sets(text + "dy = 0.2\n", text, {"perturb=[{ dx = 0.1, robot = 1, t = 1 }]"});
}

TEST(SetsBetween, AddTheOperatorsActionsOneByOne) {
  const std::string text = "[[operator]]\nt = 1\ndoes = \"uncouple r1 r2\"\n";
  const std::string set = set_of({2.52, events::Kick{1, 0.1, -0.2}}, 2);
  const Experiment e = good(text, {set});
  ASSERT_EQ(e.actions.size(), 2u);
  EXPECT_EQ(e.actions[1].t, 2.52);
  EXPECT_EQ(describe(e.actions[1].event), describe(events::Kick{1, 0.1, -0.2}));
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
