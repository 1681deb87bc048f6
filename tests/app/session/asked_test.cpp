// What an operator asks of a session is taken whole or refused: nothing is lost in between.
#include <gtest/gtest.h>

#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "tests/app/rows.h"
#include "tests/eventually.h"

namespace skein::app {
namespace {

using test::eventually;
using test::Rows;

constexpr std::size_t robots = 20, pairs = robots * (robots - 1) / 2;

Experiment twenty_robots() {
  std::string text =
      "duration = 4\n[controller.gains]\nk_xx = 0.001\nk_tt = 0.001\nk_yy = 0.002\n"
      "[reference]\nspacing = 0.14\n";
  for (std::size_t i = 0; i < robots; ++i) text += "[[robot]]\n";
  auto experiment = parse_experiment(text, "twenty.toml");
  EXPECT_TRUE(experiment) << (experiment ? "" : experiment.error().front().message());
  return experiment.value();
}

std::size_t coupled(const Session& session) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < robots; ++i)
    for (std::size_t j = i + 1; j < robots; ++j) count += session.coupled(i, j) ? 1 : 0;
  return count;
}

void uncouple_all(Session& session) {
  for (std::size_t i = 0; i < robots; ++i)
    for (std::size_t j = i + 1; j < robots; ++j) {
      const auto taken = session.couple(i, j, false);
      ASSERT_TRUE(taken) << taken.error();
    }
}

TEST(Asked, AllPairsOfTwentyRobotsAreUncoupledBeforeTheStart) {
  const Experiment e = twenty_robots();
  Rows rows;
  std::ostringstream csv;
  CsvWriter writer(csv, e, true);
  auto session = Session::open(e, Session::Clock::virtual_, {.sinks = {&rows, &writer}});
  ASSERT_TRUE(session) << session.error();
  uncouple_all(**session);
  for (const core::GainName gain : core::gain_names) EXPECT_TRUE((*session)->set_gain(gain, 0.0005));
  EXPECT_EQ((*session)->run(), Phase::finished);
  EXPECT_EQ(coupled(**session), 0u);
  EXPECT_GE(rows.count<events::Uncouple>(), static_cast<int>(pairs)) << "the record has them all";
  for (const TickRecord& row : rows.rows) ASSERT_EQ(row.events.dropped(), 0u);
  std::istringstream recorded(csv.str());
  const auto again = replay(recorded, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->different, 0) << again->first;
}

TEST(Asked, AllPairsOfTwentyRobotsAreUncoupledAndTheRunStartsOnTheWallClock) {
  auto session = Session::open(twenty_robots(), Session::Clock::wall);
  ASSERT_TRUE(session) << session.error();
  uncouple_all(**session);
  ASSERT_TRUE((*session)->start());
  TickRecord latest;
  EXPECT_TRUE(eventually([&] {
    (*session)->drain([&](const TickRecord& record) { latest = record; });
    return latest.phase == Phase::running && coupled(**session) == 0;
  })) << coupled(**session)
      << " pairs are still coupled";
  (*session)->close();
}

TEST(Asked, WhatDoesNotFitIsRefused) {
  auto session = Session::open(paper_experiment(), Session::Clock::virtual_);  // nobody takes anything until it runs
  ASSERT_TRUE(session) << session.error();
  int taken = 0;
  while (taken < 10000 && (*session)->set_gain(core::GainName::k_xx, 0.001)) ++taken;
  EXPECT_GE(taken, 100);
  ASSERT_LT(taken, 10000) << "the queue has no end";
  for (const Session::Answer& answer :
       {(*session)->start(), (*session)->stage(), (*session)->pause(), (*session)->resume(),
        (*session)->couple(0, 1, false), (*session)->set_gain(core::GainName::k_xx, 0, 1, 0.001),
        (*session)->hold_robot(0, true)}) {
    ASSERT_FALSE(answer);
    EXPECT_NE(answer.error().find("too many commands at once"), std::string::npos) << answer.error();
  }
}

TEST(Asked, APairIsOfTwoRobotsThatAreThere) {
  auto session = Session::open(paper_experiment(), Session::Clock::virtual_);
  ASSERT_TRUE(session) << session.error();
  EXPECT_TRUE((*session)->couple(3, 0, false));
  EXPECT_FALSE((*session)->couple(1, 1, false));
  const auto answer = (*session)->set_gain(core::GainName::k_xx, 0, 4, 0.001);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error(), "robots 1 and 5 are not a pair, allowed: two different robots from 1 to 4");
}

}  // namespace
}  // namespace skein::app
