#include "app/experiment/rehearsal.h"

#include <gtest/gtest.h>

#include "app/experiment/experiment_file.h"
#include "app/experiment/hardware.h"

namespace skein::app {
namespace {

constexpr const char* lab = R"(name = "lab"   # on the table at the window
[[robot]]
tag = 3
link = "rfcomm:10:00:E8:AA:BB:CC/1"
adapter = "hci1"
model = "epuck1"
wheel_diameter = 0.0421

[[robot]]
tag = 5
link = "tcp:10.0.0.7:1000"

[[robot]]
tag = 6
link = "udp:10.0.0.8:6000"
radius = 0.038

[[robot]]
tag = 7
link = "sim"

[camera]
source = "aravis:Basler-1"
calibration = "overhead.toml"
exposure = 0.005
trigger = "software"
latency = 0.021

[[camera.also]]
source = "v4l2:/dev/video1"
calibration = "other.toml"
latency = -0.01
)";

TEST(Rehearsal, HasNoHardwareAndIsOtherwiseTheSame) {
  const auto real = parse_experiment(lab, "/lab/lab.toml");
  ASSERT_TRUE(real.has_value()) << messages(real.error());
  ASSERT_TRUE(has_hardware(*real));
  const auto rehearsed = rehearsal(*real);
  ASSERT_TRUE(rehearsed.has_value()) << messages(rehearsed.error());
  EXPECT_FALSE(has_hardware(*rehearsed));
  EXPECT_EQ(rehearsed->name, "lab (rehearsal)");
  EXPECT_EQ(rehearsed->directory, real->directory);
  ASSERT_EQ(rehearsed->robots.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(rehearsed->robots[i].link, RobotSpec::Link::loopback) << i;
    EXPECT_EQ(rehearsed->robots[i].type, real->robots[i].type) << i;
    EXPECT_EQ(rehearsed->robots[i].tag, real->robots[i].tag) << i;
    EXPECT_EQ(rehearsed->robots[i].radius, real->robots[i].radius) << i;
    EXPECT_EQ(rehearsed->robots[i].drive.wheel_diameter, real->robots[i].drive.wheel_diameter) << i;
  }
  EXPECT_EQ(rehearsed->robots[3].link, RobotSpec::Link::sim) << "was no hardware";
  EXPECT_EQ(rehearsed->camera.kind(), CameraKind::synthetic);
  EXPECT_EQ(rehearsed->camera.calibration, "overhead.toml");
  EXPECT_EQ(rehearsed->camera.latency, 0.021);
  EXPECT_EQ(rehearsed->camera.stamps_late, 0.021) << "its pictures are as late as the file says of the real ones";
  ASSERT_EQ(rehearsed->cameras(), 2U);
  EXPECT_EQ(rehearsed->camera_at(1).kind(), CameraKind::synthetic);
  EXPECT_EQ(rehearsed->camera_at(1).latency, 0.0);
  EXPECT_NE(rehearsed->source.find("on the table at the window"), std::string::npos) << "comments stay";
}

TEST(Rehearsal, IsWhatItsTextSays) {
  const auto real = parse_experiment(lab, "/lab/lab.toml");
  ASSERT_TRUE(real.has_value());
  const auto rehearsed = rehearsal(*real);
  ASSERT_TRUE(rehearsed.has_value());
  const auto again = parse_experiment(rehearsed->source, "/lab/again.toml");
  ASSERT_TRUE(again.has_value()) << messages(again.error());
  EXPECT_FALSE(has_hardware(*again));
  EXPECT_EQ(again->name, rehearsed->name);
}

TEST(Rehearsal, OfAnExperimentWithoutHardwareIsTheExperiment) {
  const Experiment paper = paper_experiment();
  EXPECT_FALSE(has_hardware(paper));
  const auto rehearsed = rehearsal(paper);
  ASSERT_TRUE(rehearsed.has_value());
  EXPECT_EQ(rehearsed->source, paper.source);
  EXPECT_EQ(rehearsed->name, paper.name);
}

}  // namespace
}  // namespace skein::app
