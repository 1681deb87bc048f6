// The experiment that a run embeds, where --set or files beside it changed it.
#include "app/experiment/toml_rewrite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "tests/places.h"

namespace skein::app {
namespace {

std::string rewritten(const std::string& text, const std::string& as) {
  const toml::table document = toml::parse(as);
  std::string result = with_document(text, document);
  EXPECT_EQ(toml::parse(result), document) << result;
  return result;
}

TEST(TomlRewrite, CommentsOrderAndNumbersStay) {
  const std::string text =
      "# Two robots\n"
      "name = \"a\"   # a name\n"
      "rate = 25\n"
      "\n"
      "[shield]  # the last word\n"
      "gamma = 0.50\n"
      "distance = 8e-2\n"
      "[arena]\n"
      "width = 0.030\n";
  EXPECT_EQ(rewritten(text, "name = 'a'\nrate = 25\nshield = {gamma = 0.03, distance = 0.08}\narena = {width = 0.03}"),
            "# Two robots\n"
            "name = \"a\"   # a name\n"
            "rate = 25\n"
            "\n"
            "[shield]  # the last word\n"
            "gamma = 0.03\n"
            "distance = 8e-2\n"
            "[arena]\n"
            "width = 0.030\n");
}

TEST(TomlRewrite, NewKeysStandBehindThoseOfTheirTableAndNewTablesAtTheEnd) {
  EXPECT_EQ(
      rewritten("a = 1 # one\n[b]\nc = 2\n\n[d]\n", "a = 1\nz = 'q\"'\n[b]\nc = 2\ne = 1.0\n[d]\n[f]\ng = [1, 2.5]"),
      "a = 1 # one\nz = \"q\\\"\"\n[b]\nc = 2\ne = 1.0\n\n[d]\n\n[f]\ng = [1, 2.5]\n");
  EXPECT_EQ(rewritten("[[robot]]\ntag = 1 # first\n", "[[robot]]\ntag = 7\n[[robot]]\ntag = 2\n"),
            "[[robot]]\ntag = 7 # first\n\n[[robot]]\ntag = 2\n");
}

TEST(TomlRewrite, KeysThatAreGoneTakeTheirLinesAlong) {
  EXPECT_EQ(rewritten("robots_file = \"r.toml\"  # theirs\nrate = 25 # Hz\n", "rate = 25"), "rate = 25 # Hz\n");
}

TEST(TomlRewrite, TablesThatAreGoneLeaveTheCommentsAroundThem) {
  const std::string text =
      "# Kicks\n"
      "rate = 25  # Hz\n"
      "\n"
      "# the first\n"
      "[[perturb]]\n"
      "t = 1.0\n"
      "\n"
      "[[perturb]]\n"
      "t = 2.0  # the second\n"
      "\n"
      "# what must hold\n"
      "[expect]\n"
      "collisions = 0\n";
  const std::string rest = "[expect]\ncollisions = 0\n";
  EXPECT_EQ(rewritten(text, "rate = 25\nperturb = []\n" + rest),
            "# Kicks\nrate = 25  # Hz\nperturb = []\n\n# the first\n\n\n# what must hold\n" + rest);
  EXPECT_EQ(rewritten(text, "rate = 25\nperturb = [{t = 1.0}]\n" + rest),
            "# Kicks\nrate = 25  # Hz\n\n# the first\n[[perturb]]\nt = 1.0\n\n\n# what must hold\n" + rest);
  EXPECT_EQ(rewritten(text, "rate = 25\n" + rest),
            "# Kicks\nrate = 25  # Hz\n\n# the first\n\n\n# what must hold\n" + rest);
  EXPECT_EQ(rewritten("[a]\nb = 1 # one\n[a.c]\nd = 2\n# e\n", "a = { b = 1 }"), "[a]\nb = 1 # one\n# e\n");
}

TEST(TomlRewrite, ATableInOneLineKeepsItsOrderAndANewOneStaysWithItsRobot) {
  EXPECT_EQ(rewritten("path = { width = 1.30, height = 0.90 } # m\nat = [0.10, # x\n  0.20]\n",
                      "path = { width = 1.31, height = 0.9 }\nat = [0.1, 0.3]"),
            "path = { width = 1.31, height = 0.90 } # m\nat = [0.10, # x\n  0.3]\n");
  EXPECT_EQ(rewritten("[[robot]]\ntag = 1 # first\n[[robot]]\ntag = 2\n",
                      "[[robot]]\ntag = 1\n[robot.truth]\ntrack = 0.05\n[[robot]]\ntag = 2"),
            "[[robot]]\ntag = 1 # first\ntruth = { track = 0.05 }\n[[robot]]\ntag = 2\n");
}

TEST(TomlRewrite, WhatItCannotFollowIsWrittenAnew) {
  rewritten("a.b.c = 1\n", "[a]\nd = 2\n[a.b]\nc = 2");
  rewritten("[a.b]\nc = 1\n", "[a]\nd = 2\n[a.b]\nc = 1");
  rewritten("x = [{a = 1}, {a = 2}] # inline\n", "[[x]]\na = 1\n[[x]]\na = 3\n[[x]]\na = 4");
  rewritten("x = { a = 1, b = { c = 2 } }\n", "[x]\na = 1\n[x.b]\nc = 3");
  rewritten("no toml [", "a = 1");
  rewritten("[[a]]\n[a.b]\nc = 1\n[[a]]\n", "[[a]]\n[a.b]\nc = 2\n[[a]]\nd = 1\n[a.b]\nc = 3");
}

TEST(TomlRewrite, ASetChangesOneLineOfTheExperimentThatARunEmbeds) {
  const std::string before = paper_experiment().source;
  const auto with = [&](const std::vector<std::string>& sets) {
    return parse_experiment(before, "platoon.toml", sets).value().source;
  };
  const auto lines_changed = [&](const std::string& after) {
    std::istringstream a(before), b(after);
    int changed = 0;
    for (std::string x, y; std::getline(a, x) && std::getline(b, y);) changed += x != y ? 1 : 0;
    return changed;
  };
  const std::string gain = with({"controller.gains.k_xx=0.003"});
  EXPECT_NE(gain.find("k_xx = 0.003"), std::string::npos);
  EXPECT_EQ(gain.find("0.0030000"), std::string::npos);
  EXPECT_EQ(lines_changed(gain), 1);
  EXPECT_EQ(std::count(gain.begin(), gain.end(), '#'), std::count(before.begin(), before.end(), '#'));
}

/// Any key and any file of the repository: the embedded text gives the same experiment as the file with its --set.
TEST(TomlRewrite, EveryExperimentOfTheRepositoryWithSets) {
  for (const auto& file : std::filesystem::directory_iterator(skein::test::in_source("resources/experiments"))) {
    if (file.path().extension() != ".toml") continue;
    const std::vector<std::string> sets{"duration=3.5",
                                        "seed=17",
                                        "controller.gains.k_xx=0.0003",
                                        "shield.gamma=0.7",
                                        "robot.1.tag=30",
                                        "expect.final_error=0.1",
                                        "simulation.slip=0.01",
                                        "name=a \"name\"",
                                        "arena.width=9",
                                        "perturb=[]",
                                        "robot.1.truth.wheel_ratio=1.01"};
    const auto set = load_experiment(file.path().string(), sets);
    ASSERT_TRUE(set) << set.error().front().message();
    const auto again = parse_experiment(set->source, "again");
    ASSERT_TRUE(again) << again.error().front().message();
    EXPECT_EQ(again->source, set->source);
    EXPECT_EQ(again->name, "a \"name\"");
    EXPECT_EQ(again->robots.at(0).tag, 30);
    EXPECT_EQ(again->controller.gains.k_xx.largest(), 0.0003);
    std::ifstream in(file.path());
    int comments = 0, kept = 0;
    for (std::string line; std::getline(in, line);)
      if (line.starts_with('#')) {
        ++comments;
        kept += set->source.find(line + "\n") != std::string::npos ? 1 : 0;
      }
    EXPECT_EQ(kept, comments) << file.path();
  }
}

}  // namespace
}  // namespace skein::app
