// What is looked at before a start.
#include "app/session/readiness.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "app/experiment/at_start.h"
#include "app/experiment/experiment_file.h"
#include "app/tick/control_tick.h"
#include "tests/places.h"

namespace skein::app {
namespace {

class Readiness : public ::testing::Test {
 protected:
  Readiness() {
    for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
      robots.push_back({LinkState::simulated, {}});
      measurements.push_back({reference->at(i, 0.0).pose, 0.0});
    }
  }
  /// What a tick sees that sees the robots for the first time.
  const TickRecord& look() {
    ControlTick tick(experiment);
    TickInput input;
    input.measurements = measurements;
    record = tick.step(input);
    return record;
  }
  Check check(Check::What what) {
    const std::vector<Check> all = readiness(experiment, &certificate, &look(), robots);
    return *std::find_if(all.begin(), all.end(), [&](const Check& c) { return c.what == what; });
  }
  std::vector<Check> all() { return readiness(experiment, &certificate, &look(), robots); }

  Experiment experiment = paper_experiment();
  std::unique_ptr<const core::Reference> reference = make_reference(experiment);
  Certificate certificate = certify(experiment);
  TickRecord record;
  std::vector<RobotStatus> robots;
  std::vector<core::Measurement> measurements;
};

TEST_F(Readiness, ThePapersExperimentMayStartAtOnce) {
  EXPECT_TRUE(all_hold(all()));
  EXPECT_TRUE(may_start(all()));
}

TEST(ReadyToStart, EveryExperimentThatComesWithSkeinAndSimulatesItsRobots) {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(test::in_source("resources/experiments"))) {
    if (file.path().extension() != ".toml") continue;
    const auto experiment = load_experiment(file.path().string());
    ASSERT_TRUE(experiment) << file.path();
    if (std::any_of(experiment->robots.begin(), experiment->robots.end(),
                    [](const RobotSpec& r) { return r.has_link(); }) ||
        experiment->cameras() > 1)
      continue;
    const std::unique_ptr<const core::Reference> reference = make_reference(*experiment);
    std::vector<core::Measurement> measurements;
    for (std::size_t i = 0; i < experiment->robots.size(); ++i)
      measurements.push_back({experiment->robots[i].start.value_or(reference->at(i, 0.0).pose), 0.0});
    ControlTick tick(*experiment);
    TickInput input;
    input.measurements = measurements;
    const TickRecord& record = tick.step(input);
    const Certificate certificate = certify(*experiment);
    const std::vector<RobotStatus> robots(experiment->robots.size(), {LinkState::simulated, {}});
    for (const Check& check : readiness(*experiment, &certificate, &record, robots))
      EXPECT_EQ(check.state, Check::State::holds) << file.path() << ": " << check.reason;
    ++count;
  }
  EXPECT_GE(count, 15);
}

TEST_F(Readiness, NothingIsKnownYet) {
  const std::vector<Check> checks = readiness(experiment, nullptr, nullptr, {});
  EXPECT_FALSE(may_start(checks));
  for (const Check& check : checks) EXPECT_NE(check.state, Check::State::fails) << check.reason;
}

TEST_F(Readiness, ARobotThatIsNotSeenIsNamedWithItsTag) {
  experiment.robots[2].tag = 17;
  measurements[2] = {};
  const Check tags = check(Check::What::tags);
  EXPECT_EQ(tags.state, Check::State::fails);
  EXPECT_NE(tags.reason.find("robot 3"), std::string::npos) << tags.reason;
  EXPECT_NE(tags.reason.find("17"), std::string::npos) << tags.reason;
  EXPECT_FALSE(may_start(all()));
}

TEST_F(Readiness, RobotsThatAreNotSeenAreNotSaidToStandInTheirPlaces) {
  for (core::Measurement& measurement : measurements) measurement = {};
  const Check places = check(Check::What::places);
  EXPECT_EQ(places.state, Check::State::fails) << places.reason;
  EXPECT_NE(places.reason.find("robots 1, 2, 3, 4"), std::string::npos) << places.reason;
}

TEST_F(Readiness, ALinkThatIsDownSaysWhy) {
  robots[1] = {LinkState::failed, "host is down"};
  const Check links = check(Check::What::links);
  EXPECT_EQ(links.state, Check::State::fails);
  EXPECT_NE(links.reason.find("robot 2"), std::string::npos) << links.reason;
  EXPECT_NE(links.reason.find("host is down"), std::string::npos) << links.reason;
  EXPECT_FALSE(may_start(all()));
}

TEST_F(Readiness, ALowBatteryIsSaidAndMayBeOverruled) {
  robots[2].battery = 3.31;
  EXPECT_NE(check(Check::What::batteries).reason.find("3.31 V"), std::string::npos);
  robots[2].battery_low = true;
  EXPECT_EQ(check(Check::What::batteries).state, Check::State::fails);
  EXPECT_FALSE(all_hold(all()));
  EXPECT_TRUE(may_start(all()));
}

TEST_F(Readiness, GainsThatBreak18AndAReferenceThatIsTooFastStopTheStart) {
  certificate.robots[3].k_x.value = -0.01;
  EXPECT_EQ(check(Check::What::gains).state, Check::State::fails);
  EXPECT_EQ(check(Check::What::reference).state, Check::State::holds);
  certificate.robots[0].wheel.value = 1.2;
  EXPECT_EQ(check(Check::What::reference).state, Check::State::fails);
  EXPECT_FALSE(may_start(all()));
}

TEST_F(Readiness, ARobotOutOfItsPlaceMayBeOverruled) {
  measurements[1].pose.x += 0.5 * experiment.staging.within;
  EXPECT_EQ(check(Check::What::places).state, Check::State::holds);
  measurements[1].pose.x += 0.2;
  const Check places = check(Check::What::places);
  EXPECT_EQ(places.state, Check::State::fails);
  EXPECT_NE(places.reason.find("robot 2"), std::string::npos) << places.reason;
  EXPECT_FALSE(all_hold(all()));
  EXPECT_TRUE(may_start(all()));
  measurements[1].pose = reference->at(1, 0.0).pose;
  measurements[0].pose.theta =
      core::wrap_angle(measurements[0].pose.theta + 2 * start_tolerance(experiment.staging).heading);
  EXPECT_EQ(check(Check::What::places).state, Check::State::fails) << "it looks the wrong way";
  EXPECT_EQ(check(Check::What::places).reason, "robot 1 not in place, up to 0 cm away, turned by up to 23 degrees");
}

TEST_F(Readiness, ARobotThatTheFilePlacesElsewhereIsInPlaceThereUnlessItDrivesToItsStart) {
  const core::Pose elsewhere{0.3, -0.2, 2.0};
  experiment.robots[1].start = elsewhere;
  measurements[1].pose = elsewhere;
  EXPECT_EQ(check(Check::What::places).state, Check::State::fails) << "staging drives it to its place first";
  experiment.staging.automatic = false;
  EXPECT_EQ(check(Check::What::places).state, Check::State::holds);
  EXPECT_TRUE(all_hold(all()));
  measurements[1].pose.x += 0.2;
  EXPECT_EQ(check(Check::What::places).state, Check::State::fails) << "and then it was moved";
}

TEST_F(Readiness, WhatIsKnownOfATagThatIsNotAcceptedIsTheReason) {
  experiment.camera.source = "synthetic";
  measurements[1] = {};
  measurements[2] = {};
  const CameraStatus camera{.why_lost = {{}, {}, {.sentence = "tag 3 is there, but its edge is 40 mm"}, {}}};
  const auto tags = [&](const CameraStatus& known) {
    return readiness(experiment, &certificate, &look(), robots, known)[static_cast<std::size_t>(Check::What::tags)];
  };
  EXPECT_EQ(tags(camera).reason, "robot 3: tag 3 is there, but its edge is 40 mm; robot 2: tag 2 is being looked for");
  EXPECT_EQ(tags(camera).state, Check::State::fails) << "one reason is known";
  const CameraStatus both{.why_lost = {{},
                                       {.sentence = "tag 2 is there, but its edge is 40 mm"},
                                       {.sentence = "tag 3 is there, but its edge is 40 mm"},
                                       {}}};
  EXPECT_EQ(tags(both).reason, "robot 2: tag 2 is there, but its edge is 40 mm; robot 3: likewise") << "once for all";
}

/// Nobody may say of a picture that a tag is not in it before it was searched.
TEST_F(Readiness, ATagThatNobodyHasLookedForYetIsBeingLookedForWhereACameraCanFindIt) {
  measurements[1] = {};
  measurements[2] = {};
  look();
  const auto tags = [&](const CameraStatus& known) {
    return readiness(experiment, &certificate, &record, robots, known)[static_cast<std::size_t>(Check::What::tags)];
  };
  experiment.camera.source = "synthetic";
  EXPECT_EQ(tags({}).reason, "robots 2, 3: tags 2, 3 are being looked for");
  EXPECT_EQ(tags({}).state, Check::State::waits);
  const CameraStatus looked{
      .why_lost = {{}, {.sentence = "no tag 2 is in the picture"}, {.sentence = "no tag 3 is in the picture"}, {}}};
  EXPECT_EQ(tags(looked).reason, "robot 2: no tag 2 is in the picture; robot 3: likewise") << "the control";
  EXPECT_EQ(tags(looked).state, Check::State::fails);
  EXPECT_EQ(tags({.down = "it is frozen"}).reason, "robots 2, 3: the camera delivers no picture that can be used");
  EXPECT_EQ(tags({.down = "it is frozen"}).state, Check::State::fails);
  experiment.camera.also.resize(1);
  EXPECT_EQ(tags({.down = "they are frozen"}).reason, "robots 2, 3: no camera delivers a picture that can be used");
  EXPECT_EQ(tags({.down = "camera 2 is frozen", .partly = true}).reason, "robots 2, 3: tags 2, 3 are being looked for");
  experiment.camera.also.clear();
  experiment.camera.source = "none";
  EXPECT_EQ(tags({}).reason, "robots 2, 3: the simulation gives no pose of tags 2, 3") << "nobody will look";
  EXPECT_EQ(tags({}).state, Check::State::fails);
}

TEST(FittingTagSize, IsThatOfAllTagsThatAreThereWhereNoRobotIsSeen) {
  using core::NotSeen;
  const auto tag = [](NotSeen why, double size = none) { return UnseenTag{.why = why, .size = size}; };
  const UnseenTag small = tag(NotSeen::wrong_size, 0.0402), nowhere = tag(NotSeen::not_found);
  const std::vector<UnseenTag> agree{small, tag(NotSeen::wrong_size, 0.0396), nowhere, nowhere};
  EXPECT_EQ(fitting_tag_size(4, agree), 0.04);
  EXPECT_EQ(fitting_tag_size(5, agree), std::nullopt) << "a robot is seen, and would not be with another size";
  const std::vector<UnseenTag> differ{small, tag(NotSeen::wrong_size, 0.03)};
  EXPECT_EQ(fitting_tag_size(2, differ), std::nullopt);
  const std::vector<UnseenTag> fits_already{small, tag(NotSeen::covered, 0.06)};
  EXPECT_EQ(fitting_tag_size(2, fits_already), std::nullopt);
  const std::vector<UnseenTag> other_reason{tag(NotSeen::covered, 0.06), nowhere};
  EXPECT_EQ(fitting_tag_size(2, other_reason), std::nullopt);
  EXPECT_EQ(fitting_tag_size(0, {}), std::nullopt);
}

TEST_F(Readiness, AutomaticsOfACameraMayBeOverruled) {
  CameraStatus camera{.automatics = {"exposure", "focus"}};
  const auto settings = [&] {
    return readiness(experiment, &certificate, &look(), robots,
                     camera)[static_cast<std::size_t>(Check::What::settings)];
  };
  EXPECT_EQ(settings().state, Check::State::holds) << "of a simulation";
  experiment.camera.source = "v4l2:/dev/video0";
  EXPECT_EQ(settings().state, Check::State::fails);
  EXPECT_FALSE(settings().hard);
  EXPECT_THAT(settings().reason, testing::StartsWith("automatic exposure, focus are on"));
  camera.automatics.clear();
  EXPECT_EQ(settings().state, Check::State::holds);
  camera.down = "unplugged";
  EXPECT_EQ(settings().state, Check::State::waits);
}

TEST_F(Readiness, ACameraThatDeliversNothingIsNotToBeCalibrated) {
  experiment.camera.source = "synthetic";
  const Check camera = readiness(experiment, &certificate, &look(), robots, {.down = "it is frozen"}).front();
  EXPECT_EQ(camera.state, Check::State::fails);
  EXPECT_EQ(camera.reason, "it is frozen; the start waits for it");
  EXPECT_FALSE(camera.button);
  const CameraStatus bumped{.marks = {.moved = events::CameraMoved{.by = 0.041, .marks = 6}}};
  EXPECT_TRUE(readiness(experiment, &certificate, &look(), robots, bumped).front().button) << "the control";
}

/// The operator decides whether to wait for it; nobody drives whom no other camera sees.
TEST_F(Readiness, OneOfSeveralCamerasThatIsLostDoesNotKeepRobotsFromDrivingThatAnotherOneSees) {
  experiment.camera.source = "synthetic";
  experiment.camera.also.resize(1);
  measurements.resize(experiment.cameras() * experiment.robots.size());
  CameraStatus cameras{.down = "camera 2: unplugged", .partly = true};
  std::vector<Check> checks = readiness(experiment, &certificate, &look(), robots, cameras);
  EXPECT_EQ(checks.front().state, Check::State::fails);
  EXPECT_EQ(checks.front().reason, "camera 2: unplugged; robots that no other camera sees stand");
  EXPECT_TRUE(may_start(checks));
  const core::Measurement seen = std::exchange(measurements[1], {});
  EXPECT_FALSE(may_start(readiness(experiment, &certificate, &look(), robots, cameras))) << "nobody sees robot 2";
  measurements[1] = seen;
  cameras.marks.moved = events::CameraMoved{.by = 0.041, .marks = 6};
  EXPECT_FALSE(may_start(readiness(experiment, &certificate, &look(), robots, cameras))) << "the other one was moved";
  cameras = {.down = "camera 1: unplugged; camera 2: unplugged"};
  EXPECT_FALSE(may_start(readiness(experiment, &certificate, &look(), robots, cameras))) << "none is left";
}

TEST_F(Readiness, ARealCameraNeedsItsCalibration) {
  experiment.camera.source = "v4l2:/dev/video0";
  EXPECT_EQ(check(Check::What::camera).state, Check::State::fails);
  EXPECT_FALSE(may_start(all()));
  experiment.camera.calibration = "no-such-file.toml";
  EXPECT_EQ(check(Check::What::camera).state, Check::State::fails);
  EXPECT_THAT(check(Check::What::camera).reason, testing::HasSubstr("there is no no-such-file.toml"));
  experiment.directory = test::in_source("resources/experiments");
  experiment.camera.calibration = "platoon.toml";  // that it is one is found when it is opened
  EXPECT_EQ(check(Check::What::camera).state, Check::State::holds);
}

}  // namespace
}  // namespace skein::app
