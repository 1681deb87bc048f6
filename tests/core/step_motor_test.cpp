#include "core/kinematics/step_motor.h"

#include <algorithm>
#include <cmath>

#include "tests/property.h"

namespace skein::core {
namespace {

/// Steps of a motor that is told the same speed every 40 ms for `seconds`, against its own rate.
double share_lost(double speed, double seconds) {
  StepMotor motor(MotorModel::epuck1);
  const int ticks = static_cast<int>(std::lround(seconds / 0.04));
  for (int k = 0; k < ticks; ++k) {
    motor.command(speed);
    motor.advance(0.04);
  }
  return 1.0 - static_cast<double>(motor.counter()) / (seconds * actual_step_rate(MotorModel::epuck1, speed));
}

// Seen on the manufacturer's motor routines, told a speed 25 times a second.
TEST(StepMotor, AnEpuck1LosesStepsBelow601WhenItIsToldASpeedEveryTick) {
  for (const auto& [speed, lost] :
       {std::pair{50.0, 0.085}, {100.0, 0.064}, {200.0, 0.053}, {300.0, 0.041}, {400.0, 0.030}, {500.0, 0.019}}) {
    // Which phase the commands meet is fixed at some speeds: an average over neighbours of the same period will do.
    const double expected = 2.0 * 15.0 * (std::floor(10000.0 / speed) - 15.0) / std::floor(10000.0 / speed) / 400.0;
    EXPECT_NEAR(expected, lost, 0.02) << speed;
    EXPECT_NEAR(epuck1_steps_lost(speed, speed) * 25.0 / actual_step_rate(MotorModel::epuck1, speed), expected, 1e-6)
        << speed;
  }
  for (const double speed : {601.0, 700.0, 1000.0}) EXPECT_NEAR(share_lost(speed, 40.0), 0.0, 1e-3) << speed;
  double mean = 0.0;
  for (int speed = 180; speed < 220; ++speed) mean += share_lost(speed, 40.0) / 40.0;
  EXPECT_NEAR(mean, 0.053, 0.012);
}

TEST(StepMotor, AnUnchangedSpeedThatIsNotSentAgainCostsNothing) {
  for (const double speed : {-13.0, 50.0, 388.0, -600.0, 999.0}) {
    StepMotor motor(MotorModel::epuck1);
    motor.command(speed);
    for (int k = 0; k < 1000; ++k) motor.advance(0.04);
    EXPECT_NEAR(static_cast<double>(motor.counter()), 40.0 * actual_step_rate(MotorModel::epuck1, speed), 1.0);
  }
}

// 492 ms after 1 step/s, 250 after 2, 100 after 5, 42 after 12.
TEST(StepMotor, AnEpuck2ObeysWhenTheHalfStepUnderWayHasEnded) {
  for (const auto& [slow, most] : {std::pair{1.0, 0.5}, {2.0, 0.25}, {5.0, 0.1}, {12.0, 0.0417}}) {
    double longest = 0.0;
    for (int phase = 0; phase < 100; ++phase) {
      StepMotor motor(MotorModel::epuck2);
      motor.command(slow);
      motor.advance(0.01 + 3.0 + phase * 0.005);
      motor.command(500.0);
      const auto before = motor.counter();
      double waited = 0.0;
      for (; motor.counter() < before + 2; waited += 0.001) motor.advance(0.001);
      longest = std::max(longest, waited);
    }
    EXPECT_NEAR(longest, most, 0.05 * most + 0.005) << slow;
  }
}

TEST(StepMotor, AStopActsAtOnce) {
  for (const MotorModel model : {MotorModel::ideal, MotorModel::epuck1, MotorModel::epuck2}) {
    StepMotor motor(model);
    motor.command(700.0);
    motor.advance(1.0);
    motor.command(0.0);
    const auto stood = motor.counter();
    const double position = motor.position();
    motor.advance(10.0);
    EXPECT_EQ(motor.counter(), stood);
    EXPECT_EQ(motor.position(), position);
  }
}

// What the world sees between steps agrees with the counter at every step.
TEST(StepMotor, TheShaftIsNeverFartherFromItsCounterThanAStepAndTimeCanBeCutAnywhere) {
  test::holds("position, counter and cuts", [](const std::vector<std::uint16_t>& draws) {
    const auto model = *rc::gen::element(MotorModel::epuck1, MotorModel::epuck2);
    StepMotor whole(model), cut(model);
    for (const std::uint16_t draw : draws) {
      const double speed = draw % 2001 - 1000, seconds = 0.001 * (1 + draw % 97);
      whole.command(speed);
      cut.command(speed);
      whole.advance(seconds);
      const int parts = 1 + draw % 7;
      for (int k = 0; k < parts; ++k) cut.advance(seconds / parts);
      RC_ASSERT(std::abs(whole.position() - static_cast<double>(whole.counter())) <= 1.0 + 1e-6);
      RC_ASSERT(std::abs(whole.position() - cut.position()) < 0.02);
    }
  });
}

/// The tick's idea of an e-puck2's wheel that is told `speeds`, one each `period` of time, against a motor whose timer
/// counts since `phase` before. [steps]
double farthest_from_expected(const std::vector<double>& speeds, double period, double phase) {
  StepMotor motor(MotorModel::epuck2);
  motor.advance(phase);
  ExpectedWheel expected(MotorModel::epuck2);
  double rolls = 0.0, worst = 0.0, before = 0.0;
  for (const double speed : speeds) {
    const bool sent = speed != before;
    before = speed;
    rolls += period * expected.command(speed, sent, period, period);
    if (sent) motor.command(speed);
    motor.advance(period);
    worst = std::max(worst, std::abs(rolls - motor.position()));
  }
  return worst;
}

// 13 steps/s for one tick of 10 ms in 80 ms: its speeds say 3.25 steps, and it rolls half a step each time.
TEST(ExpectedWheel, KnowsHowFarAnEpuck2RollsThatStartsAndStopsInTurn) {
  std::vector<double> pulses;
  for (int k = 0; k < 200; ++k) pulses.push_back(k % 8 == 0 ? 13.0 : 0.0);
  for (const double period : {0.01, 0.02, 0.04})
    for (const double phase : {0.0, 0.002, 0.0071})
      EXPECT_LT(farthest_from_expected(pulses, period, phase), 0.6) << period << " s, " << phase << " s";
  StepMotor motor(MotorModel::epuck2);
  for (const double speed : pulses) motor.command(speed), motor.advance(0.01);
  EXPECT_NEAR(motor.position(), 12.5, 0.6);
}

TEST(ExpectedWheel, IsTheEpuck2sMotorIfTheirTimersAgree) {
  test::holds("any commands, any rate", [](const std::vector<std::int16_t>& draws) {
    const double period = 0.005 * *rc::gen::inRange(1, 9);
    std::vector<double> speeds;
    for (const std::int16_t draw : draws) speeds.push_back(draw % 4 == 0 ? 0.0 : draw % 1100);
    RC_ASSERT(farthest_from_expected(speeds, period, 0.0) < 1e-6);
  });
}

}  // namespace
}  // namespace skein::core
