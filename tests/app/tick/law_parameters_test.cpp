#include "app/tick/law_parameters.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/controllers/controller_kind.h"

namespace skein::app {
namespace {

commands::SetParameter set(std::string_view name, double value, double from = 0.0) {
  return {ParameterName(name), from, value};
}

LawSpec leader_follower() {
  LawSpec law;
  law.kind = core::ControllerKind::leader_follower;
  law.parameters = {0.8, 0.8, 0.03};
  return law;
}

TEST(LawParameters, AreSetInOrderAndSaid) {
  LawParameters parameters(leader_follower());
  EventList events(10);
  const auto of_kind = parameters.of_kind();
  parameters.set(set("ahead", 0.05), events);
  parameters.set(set("ahead", 0.05), events);
  EXPECT_EQ(describe(events), "parameter ahead 0.03 -> 0.05") << "once: the second changes nothing";
  EXPECT_EQ(of_kind[2], 0.05);
  EXPECT_EQ(of_kind[0], 0.8);
}

TEST(LawParameters, OfABuiltInLawKeepToItsDeclaration) {
  LawParameters parameters(leader_follower());
  EventList events(10);
  parameters.set(set("beta", 1.0), events);
  parameters.set(set("ahead", 0.6), events);
  parameters.set(set("ahead", std::numeric_limits<double>::quiet_NaN()), events);
  EXPECT_TRUE(events.empty()) << describe(events);
  EXPECT_EQ(parameters.of_kind()[2], 0.03);
}

TEST(LawParameters, ThatWereChangedBeforeTheStartAreSaidAtTheStartOnce) {
  LawParameters parameters(leader_follower());
  EventList ready(10), start(10);
  parameters.set(set("ahead", 0.05), ready);
  parameters.set(set("alpha_l", 2.0), ready);
  parameters.set(set("alpha_l", 0.8), ready);    // taken back
  parameters.set(set("alpha_phi", 1.5), start);  // in the tick of the start
  parameters.note_changes_before_start(start);
  EXPECT_EQ(describe(start), "parameter alpha_phi 0.8 -> 1.5; parameter ahead 0.03 -> 0.05");
}

TEST(LawParameters, OfAControllerOfOnesOwnNeedNotBeInTheFile) {
  LawSpec law = leader_follower();
  law.command = "mine";
  law.own_parameters = {{"k", 3.0}};
  LawParameters parameters(law);
  EventList events(10 + most_parameters);
  parameters.set(set("k", 4.0), events);
  parameters.set(set("turn", 9.0, 8.0), events);
  parameters.set(set("turn", 10.0, 8.0), events);
  EXPECT_EQ(describe(events), "parameter k 3 -> 4; parameter turn 8 -> 9; parameter turn 9 -> 10");
  EXPECT_EQ(parameters.of_kind()[0], 0.8) << "the law that stands in keeps its own";
  events.clear();
  for (std::size_t k = 0; k < 2 * most_parameters; ++k) parameters.set(set("p" + std::to_string(k), 1.0), events);
  EXPECT_EQ(events.size(), most_parameters - 2) << "no more than fit into the memory that is shared";
}

}  // namespace
}  // namespace skein::app
