// Several cameras over one floor: what each measures of a robot becomes one pose.
#include "core/estimation/camera_fusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "lab.h"

namespace skein::test {
namespace {

using core::CameraFusion;
using core::Measurement;
using core::Pose;
using core::PoseFilter;

/// One robot under two cameras. What each would measure of it, and whether it sees it.
struct Floor {
  /// A frame of both; what became of the last news of each camera.
  std::vector<CameraFusion::Outcome> frame() {
    for (std::size_t c = 0; c < 2; ++c)
      if (sees[c]) measured[c] = {.pose = poses[c], .captured_at = now, .sigma_xy = 1e-4, .sigma_theta = 1e-3};
    std::vector<CameraFusion::Outcome> outcomes(2);
    for (const std::size_t c : fusion.news(0, measured)) outcomes[c] = fusion.take(0, c, measured[c], filter, now);
    now += dt;
    return outcomes;
  }
  Pose pose() const { return filter.predict(now); }

  CameraFusion fusion{1, 2, {}, 0.2};
  PoseFilter filter;
  std::vector<Measurement> measured{2};
  Pose poses[2] = {{0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}};
  bool sees[2] = {true, true};
  double now = 0.0;
};

TEST(CameraFusion, TakesTheNewsInTheOrderOfTheirCaptureAndNoneThatIsOld) {
  CameraFusion fusion(1, 3, {}, 0.2);
  constexpr double never = Measurement::never;
  const auto news = [&](const std::vector<double>& captured_at) {
    std::vector<Measurement> measurements(3);
    for (std::size_t c = 0; c < 3; ++c) measurements[c].captured_at = captured_at[c];
    const auto cameras = fusion.news(0, measurements);
    return std::vector<std::size_t>(cameras.begin(), cameras.end());
  };
  using Cameras = std::vector<std::size_t>;
  EXPECT_EQ(news({never, never, never}), Cameras{});
  EXPECT_EQ(news({1.02, 1.0, 1.01}), (Cameras{1, 2, 0}));
  EXPECT_EQ(news({1.0, 1.0, never}), (Cameras{0, 1}));
  EXPECT_EQ(news({1.0, 0.7, never}), Cameras{0}) << "farther behind than the bridge";
  PoseFilter filter;
  Measurement taken;
  taken.captured_at = 1.0;
  fusion.take(0, 0, taken, filter, 1.0);
  EXPECT_EQ(news({1.0, never, never}), Cameras{}) << "taken in already";
  fusion.forget();
  EXPECT_EQ(news({1.0, never, never}), Cameras{0});
}

TEST(CameraFusion, OfOneCameraTakesEverythingAsItIs) {
  CameraFusion fusion(1, 1, {}, 0.2);
  PoseFilter filter;
  for (int k = 0; k < 20; ++k) {
    const Measurement m{{0.1, 0.2, 0.01 * k}, dt * k, 0.0, 0.0, core::How::tracked};
    EXPECT_FALSE(fusion.take(0, 0, m, filter, dt * k).expected);
    EXPECT_EQ(filter.predict(dt * k), m.pose);
    EXPECT_EQ(fusion.believed(0).captured_at, m.captured_at);
  }
}

TEST(CameraFusion, BelievesAJumpThatBothCamerasSee) {
  Floor floor;
  for (int k = 0; k < 25; ++k) floor.frame();
  for (Pose& pose : floor.poses) pose.x += 0.3;
  int carried = 0;
  for (int k = 0; k < 10; ++k)
    for (const auto& outcome : floor.frame()) {
      carried += outcome.expected ? 1 : 0;
      EXPECT_FALSE(outcome.disagreement);
    }
  EXPECT_EQ(carried, 1);
  EXPECT_NEAR(floor.pose().x, 0.4, 1e-3);
}

TEST(CameraFusion, DoesNotBelieveAJumpThatOneOfTwoSeesAndSaysOnceThatTheyDisagree) {
  Floor floor;
  for (int k = 0; k < 25; ++k) floor.frame();
  floor.poses[1].x += 0.3;
  int disagreements = 0;
  for (int k = 0; k < 25; ++k) {
    const auto outcomes = floor.frame();
    for (const auto& outcome : outcomes) EXPECT_FALSE(outcome.expected);
    EXPECT_FALSE(outcomes[0].disagreement);
    if (!outcomes[1].disagreement) continue;
    ++disagreements;
    EXPECT_EQ(k, 4) << "a torn frame is none";
    EXPECT_EQ(outcomes[1].disagreement->other, 0U);
    EXPECT_NEAR(outcomes[1].disagreement->distance, 0.3, 1e-3);
  }
  EXPECT_EQ(disagreements, 1);
  EXPECT_NEAR(floor.pose().x, 0.1, 1e-3);
}

TEST(CameraFusion, FramesThatAreTornNowAndThenAreNoDisagreement) {
  Floor floor;
  for (int k = 0; k < 500; ++k) {
    floor.poses[1].x = k % 25 == 24 ? 0.4 : 0.1;
    for (const auto& outcome : floor.frame()) EXPECT_FALSE(outcome.disagreement) << k;
    EXPECT_NEAR(floor.pose().x, 0.1, 1e-3);
  }
}

TEST(CameraFusion, APoseDoesNotJumpWhereCalibrationsDifferButFadesToTheCameraThatIsLeft) {
  Floor floor;
  floor.sees[1] = false;
  floor.poses[1].x += 0.01;  // less than a jump
  for (int k = 0; k < 25; ++k) floor.frame();
  floor.sees[1] = true;
  for (int k = 0; k < 25; ++k) {
    floor.frame();
    EXPECT_NEAR(floor.pose().x, 0.1, 1e-4) << "the seam";
  }
  floor.sees[0] = false;
  double before = floor.pose().x;
  for (int k = 0; k < 150; ++k) {
    floor.frame();
    EXPECT_NEAR(floor.pose().x, before, 0.002);
    before = floor.pose().x;
  }
  EXPECT_NEAR(before, 0.11, 1e-3);
}

/// Who judges how a robot moves must not be told of what the cameras differ by.
TEST(CameraFusion, WhatItTakesInDoesNotJumpAtASeamThoughWhatCamerasMeasureDoes) {
  Floor floor;
  floor.poses[1].x += 0.015;
  floor.sees[1] = false;
  floor.frame();
  floor.sees[1] = true;
  for (int k = 0; k < 25; ++k) floor.frame();
  floor.sees[0] = false;
  const double measured = floor.fusion.believed(0).pose.x, taken = floor.fusion.fused(0).pose.x;
  for (int k = 0; k < 10; ++k) floor.frame();
  EXPECT_NEAR(floor.fusion.believed(0).pose.x, 0.115, 1e-9);
  EXPECT_NEAR(floor.fusion.fused(0).pose.x, taken, 0.006) << "the shift fades within a second";
  floor.frame();
  EXPECT_EQ(floor.fusion.fused(0).captured_at, floor.fusion.believed(0).captured_at);
  EXPECT_GT(std::abs(measured - 0.115) + std::abs(taken - 0.115), 0.01) << "the control: they differ";
  floor.fusion.forget();
  EXPECT_FALSE(floor.fusion.fused(0).ever_seen());
}

/// What is said of two cameras in `seconds`, the second of which sees the robot `apart` from where the first does.
struct Said {
  Said(Floor& floor, double seconds, const std::function<double(double)>& apart) {
    const Pose at = floor.poses[0];
    for (const double end = floor.now + seconds; floor.now < end;) {
      floor.poses[1] = {at.x, at.y + apart(floor.now), at.theta};
      for (const CameraFusion::Outcome& outcome : floor.frame()) {
        if (outcome.difference) differences.push_back(*outcome.difference);
        if (outcome.disagreement && !disagreed_at) disagreed_at = floor.now - dt;
      }
    }
  }
  std::vector<CameraFusion::Disagreement> differences;
  std::optional<double> disagreed_at;
};

TEST(CameraFusion, SaysOnceOfTwoCamerasThatGoOnToSeeARobotApart) {
  Floor floor;
  const Said said(floor, 3.0, [](double) { return 0.008; });
  ASSERT_EQ(said.differences.size(), 1U);
  EXPECT_NEAR(said.differences[0].distance, 0.008, 1e-6);
  EXPECT_FALSE(said.disagreed_at);
  floor.fusion.forget();
  floor.filter.forget();
  EXPECT_EQ(Said(floor, 0.4, [](double) { return 0.008; }).differences.size(), 0U) << "it has to last";
  EXPECT_EQ(Said(floor, 0.4, [](double) { return 0.008; }).differences.size(), 1U) << "a start begins anew";
}

TEST(CameraFusion, SaysNothingOfCalibrationsThatDifferALittleOrForAMoment) {
  Floor floor;
  EXPECT_TRUE(Said(floor, 3.0, [](double) { return 0.005; }).differences.empty());
  EXPECT_TRUE(Said(floor, 3.0, [](double t) { return std::fmod(t, 0.5) < 0.3 ? 0.008 : 0.004; }).differences.empty());
}

/// At 0.4 m/s and by cameras that are out of step by 5 ms, so that each but the newest frame is up to 14 mm behind.
TEST(CameraFusion, ARobotThatAHandMovesIsWhereBothCamerasSeeIt) {
  CameraFusion fusion{1, 2, {}, 0.2};
  PoseFilter filter;
  int differences = 0;
  for (int k = 0; k < 200; ++k) {
    const std::size_t camera = k % 2;
    const double t = dt * (k / 2) + 0.005 * static_cast<double>(camera);
    const Measurement m{{0.4 * t, 0.0, 0.0}, t, 1e-4, 1e-3};
    differences += fusion.take(0, camera, m, filter, t).difference ? 1 : 0;
  }
  EXPECT_EQ(differences, 0);
}

/// A camera that sags while both see the robot, at 5 mm/s.
TEST(CameraFusion, ADifferenceThatGrowsIsSaidAndThenContradicts) {
  Floor floor;
  const auto apart = [](double t) { return std::fmax(0.0, 0.005 * (t - 1.0)); };
  const Said said(floor, 12.0, apart);
  ASSERT_EQ(said.differences.size(), 1U);
  EXPECT_LT(said.differences[0].distance, 0.008);
  ASSERT_TRUE(said.disagreed_at);
  EXPECT_LT(apart(*said.disagreed_at), 0.025);
}

/// A start waits for it.
TEST(CameraFusion, SaysThatItIsOpenWhetherTwoCamerasGoOnToSeeARobotApart) {
  const auto open = [](const Floor& floor) { return floor.now - floor.fusion.comparison(0, 1).undecided_at < 0.1; };
  Floor floor;
  EXPECT_TRUE(Said(floor, 0.2, [](double) { return 0.008; }).differences.empty());
  EXPECT_TRUE(open(floor));
  EXPECT_EQ(Said(floor, 0.6, [](double) { return 0.008; }).differences.size(), 1U);
  EXPECT_FALSE(open(floor));
  EXPECT_GT(floor.fusion.comparison(0, 1).apart, 0.0);
  Floor agreeing;
  EXPECT_TRUE(Said(agreeing, 0.2, [](double) { return 0.0; }).differences.empty());
  EXPECT_FALSE(open(agreeing));
}

/// What the operator is to know before a start.
TEST(CameraFusion, SaysAsLongAsTwoCamerasSeeARobotApart) {
  Floor floor;
  EXPECT_FALSE(floor.fusion.comparison(0, 1).compared);
  floor.sees[1] = false;
  for (int k = 0; k < 25; ++k) floor.frame();
  EXPECT_FALSE(floor.fusion.comparison(0, 1).compared) << "one alone";
  floor.sees[1] = true;
  for (int k = 0; k < 25; ++k) floor.frame();
  EXPECT_TRUE(floor.fusion.comparison(0, 1).compared);
  EXPECT_EQ(floor.fusion.comparison(0, 1).apart, 0.0);
  floor.poses[1].x += 0.9;  // by another camera's calibration
  for (int k = 0; k < 20; ++k) floor.frame();
  EXPECT_NEAR(floor.fusion.comparison(0, 1).apart, 0.9, 1e-6);
  floor.sees[1] = false;
  for (int k = 0; k < 25; ++k) floor.frame();
  EXPECT_NEAR(floor.fusion.comparison(0, 1).apart, 0.9, 1e-6) << "a robot that is taken away proves nothing";
  floor.sees[1] = true;
  floor.poses[1] = floor.poses[0];
  for (int k = 0; k < 10; ++k) floor.frame();
  EXPECT_EQ(floor.fusion.comparison(0, 1).apart, 0.0);
  EXPECT_TRUE(floor.fusion.comparison(0, 1).compared);
  floor.fusion.forget();
  EXPECT_FALSE(floor.fusion.comparison(0, 1).compared);
}

}  // namespace
}  // namespace skein::test
