// Cameras with one fault each, and one with none. What the fault is named is what a reader must do something about.
#include "vision/diagnosis/camera_examination.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "core/simulation/random.h"
#include "tests/vision/support.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::vision {
namespace {

using State = CameraFinding::State;

/// A camera over three robots, two of which drive.
struct ExaminationLab {
  SceneOptions scene;
  CameraFacts facts{.stamps = TimeStamps::exposure_start};
  double rate = 25.0;
  double seconds = 2.0;
  Calibration calibration = overhead_calibration(2.0, 1.5);
  std::function<double(int frame, double stamp)> stamp = [](int, double s) { return s; };
  std::function<bool(int frame)> comes = [](int) { return true; };
  double latency = 0.012;
  bool arrives_by_stamp = false;  // the stamps are right: the frames themselves are irregular
  CameraMeasurements measured;

  std::vector<CameraFinding> examine() {
    SyntheticCamera camera(calibration, scene, 3);
    CameraExamination examination(facts);
    Frame frame;
    const int frames = static_cast<int>(std::lround(seconds * rate));
    for (int k = 0; k < frames; ++k) {
      if (!comes(k)) continue;
      const double t = 100.0 + k / rate;
      const double driven = 0.1 * (t - 100.0);
      camera.render(
          std::vector<SyntheticTag>{
              {1, {0.1 + driven, 0.1, 0.0}}, {2, {-0.3, -0.3 + driven, 1.57}}, {3, {0.0, 0.25, 0.3}}},
          t, frame);
      frame.captured_at = stamp(k, t);
      frame.arrived_at = (arrives_by_stamp ? frame.captured_at : t) + latency;
      examination.add(frame);
    }
    measured = examination.measure();
    return examination.judge(measured);
  }
};

/// What is not well, and how it was said.
std::vector<std::string> faults(const std::vector<CameraFinding>& findings) {
  std::vector<std::string> names;
  for (const CameraFinding& finding : findings) {
    if (finding.state == State::well) {
      EXPECT_EQ(finding.remedy, "") << finding.what;
      continue;
    }
    EXPECT_NE(finding.remedy, "") << finding.what;
    names.push_back((finding.state == State::ill ? "ILL " : "note ") + finding.what);
  }
  return names;
}

using Names = std::vector<std::string>;

TEST(CameraExamination, AGoodCameraHasNoFault) {
  ExaminationLab lab;
  EXPECT_EQ(faults(lab.examine()), Names{});
  EXPECT_NEAR(lab.measured.rate, 25.0, 1e-6);
  EXPECT_LT(lab.measured.stamp_jitter, 1e-9);
  EXPECT_NEAR(lab.measured.latency, 0.012, 1e-9);
  EXPECT_NEAR(lab.measured.noise, lab.scene.noise_sigma, 0.4);
  EXPECT_EQ(lab.measured.tags, 3);
  EXPECT_NEAR(lab.measured.tag_edge, 25.0, 4.0);
  EXPECT_LT(lab.measured.flicker, 0.01);
}

TEST(CameraExamination, ALowRateIsNamed) {
  ExaminationLab lab;
  lab.rate = 10.0;
  EXPECT_EQ(faults(lab.examine()), Names{"ILL frame rate"});
  EXPECT_NEAR(lab.measured.rate, 10.0, 1e-6);
  lab.facts.needed_rate = 10.0;
  EXPECT_EQ(faults(lab.examine()), Names{}) << "it is enough where no more is wanted";
}

TEST(CameraExamination, MissingFramesAreNamed) {
  ExaminationLab lab;
  lab.rate = 30.0;
  lab.comes = [](int k) { return k % 20 != 7; };
  EXPECT_EQ(faults(lab.examine()), Names{"ILL gaps"});
  EXPECT_EQ(lab.measured.missing, 3);
  EXPECT_NEAR(lab.measured.rate, 30.0, 1e-6) << "that of the camera";
  EXPECT_LT(lab.measured.stamp_jitter, 1e-9) << "gaps are no jitter";
}

TEST(CameraExamination, IrregularStampsAreNamed) {
  ExaminationLab lab;
  core::Random random(5, 0);
  lab.stamp = [&](int, double s) { return s + 0.003 * random.gaussian(); };
  EXPECT_EQ(faults(lab.examine()), Names{"ILL regularity"});
  EXPECT_NEAR(lab.measured.stamp_jitter, 0.003 * std::sqrt(2.0), 0.001);
  lab.arrives_by_stamp = true;
  EXPECT_EQ(faults(lab.examine()), Names{"note regularity"}) << "true stamps of irregular frames";
  lab.arrives_by_stamp = false;
  lab.stamp = [](int k, double s) { return k % 10 == 0 ? s - 0.05 : s; };
  EXPECT_EQ(faults(lab.examine()).at(0), "ILL gaps") << "a stamp that jumps back leaves a gap before the next";
  EXPECT_GT(lab.measured.backwards, 3);
}

TEST(CameraExamination, StampsOfTheEndAndOfTheArrivalAreNamed) {
  ExaminationLab lab;
  lab.seconds = 0.5;
  lab.facts.stamps = TimeStamps::frame_end;
  EXPECT_EQ(faults(lab.examine()), Names{"note stamps"});
  lab.facts.stamps = TimeStamps::arrival;
  EXPECT_EQ(faults(lab.examine()), Names{"note stamps"});
}

TEST(CameraExamination, LateFramesAndFramesFromTheFutureAreNamed) {
  ExaminationLab lab;
  lab.seconds = 0.5;
  lab.latency = 0.2;
  EXPECT_EQ(faults(lab.examine()), Names{"note latency"});
  lab.latency = -0.01;
  EXPECT_EQ(faults(lab.examine()), Names{"ILL latency"});
}

TEST(CameraExamination, FlickerIsNamed) {
  for (const double flicker : {0.06, 0.3}) {
    ExaminationLab lab;
    lab.scene.flicker = flicker;
    lab.scene.flicker_hz = 103.0;
    lab.calibration.row_time = 25e-6;
    const double of_a_millisecond = 0.98;  // exposed for that long, a sine of 10 ms keeps so much
    EXPECT_EQ(faults(lab.examine()), Names{flicker < 0.1 ? "note flicker" : "ILL flicker"});
    EXPECT_NEAR(lab.measured.flicker, of_a_millisecond * flicker, 0.1 * flicker);
  }
}

TEST(CameraExamination, LightThatChangesSlowlyIsNamedAsSuch) {
  ExaminationLab lab;
  SyntheticCamera bright(lab.calibration, {.brightness = 1.0}, 3), dim(lab.calibration, {.brightness = 0.85}, 3);
  CameraExamination examination(lab.facts);
  Frame frame;
  for (int k = 0; k < 75; ++k) {
    (k < 50 ? bright : dim).render(std::vector<SyntheticTag>{{1, {0.2, 0.1, 0.0}}}, 100.0 + 0.04 * k, frame);
    examination.add(frame);
  }
  EXPECT_EQ(faults(examination.judge(examination.measure())), Names{"note brightness"});
}

TEST(CameraExamination, BlurIsNamed) {
  ExaminationLab lab;
  lab.scene.blur_px = 2.5;
  lab.calibration = overhead_calibration(1.0, 0.75);  // near enough that tags can be read in spite of it
  lab.seconds = 1.0;
  EXPECT_EQ(faults(lab.examine()), Names{"ILL sharpness"});
  const double blurred = lab.measured.edge_width;
  lab.scene.noise_sigma = 9.0;
  EXPECT_EQ(faults(lab.examine()), (Names{"note noise", "ILL sharpness"})) << "noise has slopes, too, and is no edge";
  lab.scene.noise_sigma = 4.0;
  lab.scene.blur_px = 0.7;
  EXPECT_EQ(faults(lab.examine()), Names{}) << "control";
  EXPECT_LT(lab.measured.edge_width, 0.6 * blurred);
}

TEST(CameraExamination, BlurIsNamedWhereNoTagCanBeRead) {
  ExaminationLab lab;
  lab.scene.blur_px = 4.0;
  lab.seconds = 0.2;
  EXPECT_EQ(faults(lab.examine()), (Names{"ILL sharpness", "ILL tags"}));
}

TEST(CameraExamination, LowContrastIsNamed) {
  for (const double contrast : {0.12, 0.04}) {
    ExaminationLab lab;
    lab.scene.contrast = contrast;
    lab.calibration = overhead_calibration(1.0, 0.75);
    lab.scene.noise_sigma = 1.0;
    lab.seconds = 0.5;
    EXPECT_EQ(faults(lab.examine()), Names{contrast > 0.1 ? "note contrast" : "ILL contrast"}) << lab.measured.contrast;
    EXPECT_NEAR(lab.measured.contrast, contrast * 195.0, 0.35 * contrast * 195.0);
  }
}

TEST(CameraExamination, NoiseIsNamed) {
  ExaminationLab lab;
  lab.scene.noise_sigma = 12.0;
  lab.seconds = 0.5;
  EXPECT_EQ(faults(lab.examine()), Names{"note noise"});
  EXPECT_NEAR(lab.measured.noise, 12.0, 1.0);
}

TEST(CameraExamination, DarkAndBrightPicturesAreNamed) {
  ExaminationLab lab;
  lab.seconds = 0.5;
  lab.scene.brightness = 0.1;
  lab.scene.noise_sigma = 0.5;
  EXPECT_EQ(faults(lab.examine()).at(0), "ILL exposure");
  lab.scene.brightness = 3.0;
  EXPECT_EQ(faults(lab.examine()).at(0), "ILL exposure");
}

/// They came: neither cable nor other programs are to blame.
TEST(CameraExamination, FramesOfOtherSizesAreNamed) {
  const auto examined = [](const std::vector<std::pair<int, int>>& sizes) {
    CameraExamination examination({.stamps = TimeStamps::nominal});
    for (const auto& [width, height] : sizes) examination.add(test::uniform_frame(width, height, 128));
    return examination.judge(examination.measure()).front();
  };
  const CameraFinding tiny = examined({{3, 3}}), mixed = examined({{640, 480}, {640, 480}, {320, 240}});
  EXPECT_EQ(tiny.what, "size");
  EXPECT_EQ(tiny.state, State::ill);
  EXPECT_EQ(tiny.found, "the frames have fewer than 4 pixels from edge to edge");
  EXPECT_EQ(mixed.what, "size");
  EXPECT_EQ(mixed.state, State::ill);
  EXPECT_EQ(mixed.found, "1 of 3 frames have another size than the first one's 640x480 px");
  EXPECT_EQ(examined({{640, 480}, {640, 480}}).what, "stamps") << "the control";
}

TEST(CameraExamination, WhatCannotBeSeenIsSaid) {
  CameraExamination nothing({});
  EXPECT_EQ(faults(nothing.judge(nothing.measure())), Names{"ILL frames"});

  CameraExamination blank({.stamps = TimeStamps::nominal});
  for (int k = 0; k < 5; ++k) {
    Frame frame = test::uniform_frame(640, 480, 150);
    frame.captured_at = k / 25.0;
    blank.add(frame);
  }
  EXPECT_EQ(faults(blank.judge(blank.measure())), (Names{"note stamps", "note sharpness", "note tags"}));

  CameraExamination black({});
  for (int k = 0; k < 50; ++k) {
    Frame frame = test::uniform_frame(640, 480, k % 7 == 0 ? 1 : 0);
    frame.captured_at = k / 25.0;
    black.add(frame);
  }
  EXPECT_EQ(faults(black.judge(black.measure())), (Names{"ILL exposure", "note sharpness", "note tags"}))
      << "and no flicker";

  // Of a film of one frame it said to look at the cable, and of two that their rate is that of a whole film.
  for (const TimeStamps stamps : {TimeStamps::film, TimeStamps::nominal})
    for (const int frames : {1, 2, 4}) {
      ExaminationLab few;
      few.facts.stamps = stamps;
      few.seconds = frames / few.rate;
      const auto findings = few.examine();
      const bool pictures = stamps == TimeStamps::nominal;
      if (pictures && frames > 1) continue;  // as many as are judged
      EXPECT_EQ(faults(findings), pictures ? (Names{"note frames", "note stamps"}) : Names{"note frames"}) << frames;
      for (const CameraFinding& finding : findings)
        EXPECT_TRUE(finding.what != "frame rate" && finding.what != "gaps" && finding.what != "flicker") << frames;
    }

  ExaminationLab lab;
  lab.seconds = 0.2;
  lab.calibration = overhead_calibration(4.0, 3.0);
  EXPECT_EQ(faults(lab.examine()).back(), "note size of tags");
}

}  // namespace
}  // namespace skein::vision
