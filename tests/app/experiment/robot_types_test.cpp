// Robots of several types in one experiment: what the file says, what it must not, and what follows from it.
#include <gmock/gmock.h>

#include "app/experiment/certificate.h"
#include "app/experiment/experiment_file.h"
#include "tests/app/experiment_texts.h"

namespace skein::app {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string group = R"(
  [reference]
  spacing = 0.26
  [[robot]]
  model = "khepera4"
  v_max = 0.15
  omega_max = 2.0
  K_o = 0.03
  [[robot]]
  model = "open"
  radius = 0.05
  track = 0.08
  c_x = 12.0
  c_theta = 0.8
  alpha = 0.12
  p = 4
  [[robot]]
)";

TEST(RobotTypes, AFileTakesMeasuresFromTheTypeAndItsOwnFromTheRobot) {
  const Experiment e = good(group);
  const RobotSpec &khepera = e.robots[0], &open = e.robots[1], &ideal = e.robots[2];
  EXPECT_EQ(khepera.type->name, "khepera4");
  EXPECT_EQ(khepera.radius, 0.0704);
  EXPECT_EQ(khepera.drive.track, 0.1054);
  EXPECT_EQ(khepera.motor, core::MotorModel::servo);
  EXPECT_EQ(khepera.watchdog, std::nullopt);
  EXPECT_EQ(open.radius, 0.05);
  EXPECT_EQ(open.drive.track, 0.08);
  EXPECT_EQ(open.drive.wheel_diameter, 0.065);
  EXPECT_EQ(open.watchdog, 0.2);
  EXPECT_EQ(ideal.radius, core::standard_radius);
  EXPECT_EQ(ideal.motor, core::MotorModel::ideal);

  const core::Gains gains = make_gains(e);
  EXPECT_THAT(gains.v_max, ElementsAre(0.15, 0.1, 0.1));
  EXPECT_THAT(gains.omega_max, ElementsAre(2.0, 1.7, 1.7));
  EXPECT_THAT(gains.c_x, ElementsAre(20.0, 12.0, 20.0));
  EXPECT_THAT(gains.c_theta, ElementsAre(1.0, 0.8, 1.0));
  EXPECT_EQ(make_limits(e, 0).v_max, 0.15);
  EXPECT_EQ(make_avoidance(e, 0).K_o, 0.03);
  EXPECT_EQ(make_avoidance(e, 1).alpha, 0.12);
  EXPECT_EQ(make_avoidance(e, 2).alpha, 0.10);
  EXPECT_EQ(make_avoidance(e, 0).p, 2);
  EXPECT_EQ(make_avoidance(e, 1).p, 4);
}

TEST(RobotTypes, TheCertificateIsEachRobotsOwn) {
  const Certificate c = certify(good(group));
  // (18f) with equality: v_max - v_ref - two couplings of 0.008.
  EXPECT_NEAR(c.robots[0].k_x.value, 0.15 - 0.05 - 0.016, 1e-6);
  EXPECT_NEAR(c.robots[1].k_x.value, 0.1 - 0.05 - 0.016, 1e-6);
  EXPECT_TRUE(c.holds());
  const std::string lines = as_lines(c);
  EXPECT_THAT(lines, HasSubstr("robot_1_smallest_k_x: 0.084 m/s (56 % of v_max)"));
  EXPECT_THAT(lines, HasSubstr("robot_2_smallest_k_x: 0.034 m/s (34 % of v_max)"));
}

TEST(RobotTypes, ALimitThatLeavesARobotNothingIsRefused) {
  EXPECT_THAT(messages(group + "  v_max = 0.06\n"),
              testing::Contains(HasSubstr("(18f) fails for robot 3 by 0.006 m/s: v_max 0.06 - reference 0.05")));
  EXPECT_THAT(messages(group + "  v_max = 0.04\n"),
              testing::Contains(HasSubstr("reference.speed: found 0.05, for which (18f) fails")));
}

TEST(RobotTypes, WhatIsNoneIsRefused) {
  EXPECT_THAT(
      messages("[robot_defaults]\nmodel = \"roomba\"\n"),
      ElementsAre(HasSubstr("robot_defaults.model: found \"roomba\", allowed: \"ideal\", \"epuck1\", \"epuck2\", "
                            "\"khepera4\", \"open\"")));
  EXPECT_THAT(messages("[robot_defaults]\nradius = 0\n"),
              ElementsAre(HasSubstr("robot_defaults.radius: found 0, allowed")));
}

TEST(RobotTypes, BodiesMustFitTheFormationAndTheArena) {
  EXPECT_THAT(messages("[robot_defaults]\nradius = 0.07\n"),
              ElementsAre(HasSubstr("reference.spacing: found 0.12, with "
                                    "which robots of 0.14 m width come")));
  EXPECT_THAT(messages("[reference]\nspacing = 0.2\n[robot_defaults]\nmodel = \"khepera4\"\n"),
              testing::Contains(HasSubstr("avoids itself for ever")));
  EXPECT_THAT(messages("[arena]\nheight = 1.0\n[reference]\nspacing = 0.4\n[robot_defaults]\nmodel = \"khepera4\"\n"),
              testing::Contains(HasSubstr("the arena less a robot's width of 0.1408 m")));
}

TEST(RobotTypes, TheLinkSaysWhatIsSpokenWhereTheModelDoesNot) {
  const std::string camera = "[camera]\nsource = \"v4l2:/dev/video0\"\ncalibration = \"cal.toml\"\n[[robot]]\n";
  const auto only = [&](const std::string& robot) { return good(camera + robot).robots[0]; };
  EXPECT_EQ(only("link = \"udp:192.168.1.20\"\n").type->name, "open");
  EXPECT_EQ(only("link = \"udp:192.168.1.20\"\n").address, "udp:192.168.1.20");
  EXPECT_EQ(only("link = \"serial:/dev/ttyUSB0\"\nmodel = \"open\"\n").address, "open+serial:/dev/ttyUSB0");
  EXPECT_EQ(only("link = \"khepera4+rfcomm:10:00:E8:AA:BB:CC/1\"\n").type->name, "khepera4");
  EXPECT_EQ(only("link = \"serial:/dev/ttyACM0\"\n").type->name, "epuck2");
  EXPECT_THAT(messages(camera + "link = \"udp:192.168.1.20\"\nmodel = \"epuck2\"\n"),
              testing::Contains(HasSubstr("robot.1.model: found a robot without the protocol \"open\"")));
  EXPECT_THAT(messages(camera + "link = \"open+serial:/dev/ttyUSB0\"\nmodel = \"khepera4\"\n"),
              testing::Contains(HasSubstr("robot.1.model: found a robot with the protocol \"khepera4\"")));
}

TEST(RobotTypes, ATickThatIsLongerThanAWatchdogIsRefused) {
  EXPECT_THAT(messages("rate = 5\n[robot_defaults]\nlink = \"loopback\"\nmodel = \"open\"\nradius = 0.03\n"),
              testing::Contains(HasSubstr("rate: found 5 Hz, at which robot 1 stops by itself between two ticks "
                                          "(watchdog 0.2 s); allowed: above 7.5 Hz")));
}

}  // namespace
}  // namespace skein::app
