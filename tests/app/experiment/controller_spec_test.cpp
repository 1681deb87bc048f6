#include "app/experiment/controller_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/experiment/experiment_file.h"

namespace skein::app {
namespace {

using testing::HasSubstr;

LawSpec law_of(std::vector<std::string> sets) {
  const auto experiment = parse_experiment("", "e.toml", sets);
  EXPECT_TRUE(experiment) << experiment.error().front().message();
  return experiment->controller.law;
}
std::string refusal(std::vector<std::string> sets) {
  const auto experiment = parse_experiment("", "e.toml", sets);
  return experiment ? "" : experiment.error().front().text;
}

TEST(ControllerSpec, IsThePapersLawUnlessTheFileSaysOtherwise) {
  const LawSpec law = law_of({});
  EXPECT_EQ(law, LawSpec{});
  EXPECT_FALSE(law.own());
  EXPECT_TRUE(log_names(law).empty());
}

TEST(ControllerSpec, TakesTheParametersThatTheKindDeclares) {
  const LawSpec law = law_of({"controller.kind=leader_follower", "controller.parameters.ahead=0.05"});
  EXPECT_EQ(law.parameters, (std::vector<double>{0.8, 0.8, 0.05}));
  EXPECT_THAT(log_names(law), testing::ElementsAre("l", "phi"));
  EXPECT_THAT(refusal({"controller.kind=leader_follower", "controller.parameters.ahead=1"}),
              HasSubstr("controller.parameters.ahead: found 1"));
  EXPECT_THAT(refusal({"controller.kind=leader_follower", "controller.parameters.c_x=1"}), HasSubstr("c_x"));
  EXPECT_THAT(refusal({"controller.parameters.c_x=1"}), HasSubstr("c_x"));
}

TEST(ControllerSpec, TakesAnyNumbersForAControllerOfOnesOwn) {
  const LawSpec law = law_of({"controller.command=python3 my.py", "controller.parameters.gain=3",
                              "controller.log=[\"a\"]", "controller.failure=built_in", "controller.deadline=0.002"});
  EXPECT_TRUE(law.own());
  EXPECT_EQ(law.command, "python3 my.py");
  EXPECT_THAT(law.own_parameters, testing::ElementsAre(std::pair<std::string, double>{"gain", 3.0}));
  EXPECT_EQ(law.failure, LawSpec::Failure::built_in);
  EXPECT_EQ(law.deadline, 0.002);
  EXPECT_THAT(log_names(law), testing::ElementsAre("a"));
}

TEST(ControllerSpec, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal({"controller.command=a", "controller.library=b.so"}),
              HasSubstr("controller.library: found \"b.so\", allowed: one of controller.command"));
  EXPECT_THAT(refusal({"controller.failure=hold"}),
              HasSubstr("allowed: with controller.command or controller.library"));
  EXPECT_THAT(refusal({"controller.log=[\"a\"]"}), HasSubstr("controller.log"));
  EXPECT_THAT(refusal({"controller.command=a", "controller.log=[\"a b\"]"}), HasSubstr("controller.log"));
  EXPECT_THAT(refusal({"controller.command=a", "controller.log=[\"a\", \"a\"]"}), HasSubstr("controller.log"));
  EXPECT_THAT(refusal({"controller.command=a", "controller.parameters.x=\"much\""}),
              HasSubstr("controller.parameters.x: found \"much\", allowed: up to 64 finite numbers"));
  EXPECT_THAT(refusal({"controller.command=a", "controller.deadline=0.03"}), HasSubstr("0.02 s"));
  EXPECT_THAT(refusal({"controller.kind=best"}), HasSubstr("\"virtual_structure\""));
}

}  // namespace
}  // namespace skein::app
