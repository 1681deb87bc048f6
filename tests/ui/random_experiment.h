#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "core/simulation/random.h"
#include "tests/files.h"
#include "tests/places.h"

namespace skein::ui::test {

/// One of several, each as likely as the others.
template <typename Container>
const auto& any_of_these(const Container& these, core::Random& random) {
  const auto count = static_cast<double>(std::size(these));
  return *std::next(std::begin(these), static_cast<std::ptrdiff_t>(random.uniform() * count));
}

/// An experiment of the shipped ones, with a few of its keys changed at random: seconds long, without any hardware.
inline app::Experiment random_experiment(core::Random& random) {
  static const std::vector<std::string> shipped = {
      "antipodal-swap-10", "antipodal-swap-4", "corner-blends",   "crossing", "crowd",
      "diamond-to-line",   "kidnap",           "lemniscate",      "mixed",    "obstacles",
      "open-loop",         "parking",          "platoon",         "platoon",  "uncoupled",
      "unequal-speeds",    "two-cameras",      "platoon-loopback"};
  static const std::vector<std::string> changes = {"rate=10",
                                                   "rate=50",
                                                   "failure.link_lost=others_go_on",
                                                   "failure.link_lost=all_stop",
                                                   "failure.runaway=ignored",
                                                   "controller.kind=virtual_structure",
                                                   "controller.kind=leader_follower",
                                                   "controller.kind=independent",
                                                   "controller.coupling=bounded",
                                                   "controller.saturation=algebraic",
                                                   "controller.policy=fixed",
                                                   "controller.gains.k_xx=0",
                                                   "controller.gains.k_yy=0.001",
                                                   "avoidance.enabled=false",
                                                   "avoidance.kind=plan",
                                                   "avoidance.formation_waits=true",
                                                   "avoidance.horizon=2",
                                                   "avoidance.improve=false",
                                                   "shield.enabled=false",
                                                   "shield.gamma=0.5",
                                                   "staging.automatic=false",
                                                   "staging.back=true",
                                                   "reference.interchangeable=true",
                                                   "reference.may_meet=true",
                                                   "robot_defaults.model=epuck2",
                                                   "robot_defaults.model=khepera4",
                                                   "robot_defaults.actuation_delay=0.05"};
  const std::string name = any_of_these(shipped, random);
  const std::string file = skein::test::in_source("resources/experiments/" + name + ".toml");
  const std::string text = skein::test::read_file(file);
  std::vector<std::string> wanted{fmt::format("duration={:.1f}", 2.0 + 10.0 * random.uniform()),
                                  fmt::format("seed={}", static_cast<int>(1000.0 * random.uniform()))};
  for (int k = static_cast<int>(5.0 * random.uniform()); k > 0; --k) wanted.push_back(any_of_these(changes, random));
  std::vector<std::string> sets;
  for (const std::string& set : wanted) {  // those that do not fit are left out
    sets.push_back(set);
    if (!app::parse_experiment(text, file, sets)) sets.pop_back();
  }
  auto experiment = app::parse_experiment(text, file, sets);
  EXPECT_TRUE(experiment) << file;
  if (!experiment) return app::paper_experiment();
  experiment->directory = skein::test::in_source("resources/experiments");
  return *std::move(experiment);
}

}  // namespace skein::ui::test
