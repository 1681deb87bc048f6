// What the e-puck's motors make of a commanded speed, against the fact sheet's numbers and a search over all commands.
#include "core/kinematics/step_rate.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::actual_step_rate;
using core::MotorModel;
using core::nearest_command;

TEST(StepRate, OfTheFirstEpuckIsTheFactSheetsList) {
  // From the top: 10000 / 10, / 11, / 12, ...
  std::vector<double> rates;
  for (int command = 1000; command >= 600; --command) {
    const double rate = actual_step_rate(MotorModel::epuck1, command);
    if (rates.empty() || rate != rates.back()) rates.push_back(rate);
  }
  const std::vector<double> sheet{1000.0, 909.1, 833.3, 769.2, 714.3, 666.7, 625.0};
  ASSERT_GE(rates.size(), sheet.size());
  for (std::size_t k = 0; k < sheet.size(); ++k) EXPECT_NEAR(rates[k], sheet[k], 0.05);
  EXPECT_NEAR(actual_step_rate(MotorModel::epuck1, 700), 714.3, 0.05);
  EXPECT_EQ(actual_step_rate(MotorModel::epuck1, 910), 1000.0);
  EXPECT_EQ(actual_step_rate(MotorModel::epuck1, 1), 1.0);
  EXPECT_EQ(actual_step_rate(MotorModel::epuck1, 0), 0.0);
}

TEST(StepRate, OfTheSecondEpuckIsFiner) {
  EXPECT_NEAR(actual_step_rate(MotorModel::epuck2, 700), 50000.0 / 71.0, 1e-9);
  EXPECT_EQ(actual_step_rate(MotorModel::epuck2, 1000), 1000.0);
  EXPECT_EQ(actual_step_rate(MotorModel::epuck2, 910), 50000.0 / 54.0);
  // "about 2 % at worst"
  double worst = 0.0;
  for (int s = 1; s <= 1100; ++s) worst = std::max(worst, actual_step_rate(MotorModel::epuck2, s) / s - 1.0);
  EXPECT_GT(worst, 0.015);
  EXPECT_LT(worst, 0.0225);
}

TEST(StepRate, ClampsAndIsOdd) {
  for (const MotorModel motor : {MotorModel::ideal, MotorModel::epuck1, MotorModel::epuck2}) {
    const double limit = core::max_step_rate(motor);
    EXPECT_EQ(limit, motor == MotorModel::epuck2 ? 1100.0 : 1000.0);
    for (int s = 0; s <= 1500; ++s) {
      const double rate = actual_step_rate(motor, s);
      EXPECT_EQ(actual_step_rate(motor, -s), -rate);
      EXPECT_GE(rate, std::min<double>(s, limit)) << "a timer that rounds its period down never runs slow";
      if (s > limit) {
        EXPECT_EQ(rate, actual_step_rate(motor, limit));
      }
    }
  }
  EXPECT_EQ(actual_step_rate(MotorModel::ideal, 123.456), 123.456);
}

/// The smallest miss of any whole command that a robot is given, by trying them all.
double least_miss(MotorModel motor, double wanted) {
  double least = 1e9;
  const int limit = static_cast<int>(core::max_step_rate(motor));
  for (int s = -limit; s <= limit; ++s)
    if (s == 0 || std::abs(s) >= core::slowest_command)
      least = std::min(least, std::abs(actual_step_rate(motor, s) - wanted));
  return least;
}

class NearestCommand : public ::testing::TestWithParam<MotorModel> {};

void check(MotorModel motor, double wanted) {
  const double command = nearest_command(motor, wanted);
  ASSERT_EQ(command, std::round(command)) << wanted;
  ASSERT_LE(std::abs(command), core::max_step_rate(motor)) << wanted;
  const double clamped = std::clamp(wanted, -core::max_step_rate(motor), core::max_step_rate(motor));
  // 1e-9: where two commands miss alike but for rounding, either will do.
  ASSERT_LE(std::abs(actual_step_rate(motor, command) - clamped), least_miss(motor, clamped) + 1e-9) << wanted;
}

TEST_P(NearestCommand, IsTheBestOfAll) {
  // Every quarter of a step, and around every rate that a motor can run and every middle between two.
  const double limit = core::max_step_rate(GetParam());
  for (double wanted = -limit - 20.0; wanted <= limit + 20.0; wanted += 0.25) check(GetParam(), wanted);
  for (int s = 1; s <= static_cast<int>(limit); ++s) {
    const double rate = actual_step_rate(GetParam(), s), next = actual_step_rate(GetParam(), s + 1);
    for (const double wanted : {rate, rate - 1e-6, rate + 1e-6, 0.5 * (rate + next) - 1e-6, 0.5 * (rate + next) + 1e-6})
      check(GetParam(), wanted);
  }
}

TEST_P(NearestCommand, IsTheBestOfAllForAnyWish) {
  holds("nearest_command against a search over every whole command", [] {
    Draw draw(any_seed());
    check(GetParam(), draw.sign() * (draw.chance(0.5) ? draw.decades(-3.0, 3.05) : draw.between(0.0, 1150.0)));
    RC_ASSERT(!::testing::Test::HasFatalFailure());
  });
}

TEST_P(NearestCommand, RunsARateThatTheMotorHas) {
  for (int s = 13; s <= 1000; ++s) {
    const double rate = actual_step_rate(GetParam(), s);
    if (rate > core::max_step_rate(GetParam())) continue;
    EXPECT_EQ(actual_step_rate(GetParam(), nearest_command(GetParam(), rate)), rate) << s;
  }
}

INSTANTIATE_TEST_SUITE_P(Motors, NearestCommand, ::testing::Values(MotorModel::epuck1, MotorModel::epuck2),
                         [](const auto& motor) { return motor.param == MotorModel::epuck1 ? "epuck1" : "epuck2"; });

TEST(NearestCommand, OfAnIdealMotorIsTheWishItself) {
  EXPECT_EQ(nearest_command(MotorModel::ideal, 123.456), 123.456);
  EXPECT_EQ(nearest_command(MotorModel::ideal, 5000.0), 1000.0);
  EXPECT_EQ(nearest_command(MotorModel::ideal, -5000.0), -1000.0);
}

}  // namespace
}  // namespace skein::test
