#include "vision/bench/bench_cold.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace skein::vision {
namespace {

using detail::BenchScene;
using detail::ColdScores;

ColdScores measured(const char* name, int frames) {
  const auto scenes = detail::cold_scenes();
  const auto scene = std::find_if(scenes.begin(), scenes.end(), [&](const BenchScene& s) { return s.name == name; });
  if (scene == scenes.end()) {
    ADD_FAILURE() << "no scene " << name;
    return {};
  }
  return detail::measure_cold(*scene, frames);
}

TEST(ColdBench, EveryMethodIsTimedColdAndWarmOnTheSameFrames) {
  constexpr std::size_t frames = 6;
  const ColdScores scores = measured("n=4", static_cast<int>(frames));
  for (const auto* pass : {&scores.cold, &scores.warm}) {
    EXPECT_EQ(pass->at("Skein").ms.size(), frames);
    EXPECT_EQ(pass->at("AprilTag").ms.size(), 2U) << "every fifth frame";
    EXPECT_EQ(pass->at("AprilTag tuned").ms.size(), 2U);
    EXPECT_EQ(pass->at("Skein").recall(), 100.0);
    EXPECT_EQ(pass->at("Skein").wrong_poses, 0);
  }
  EXPECT_EQ(scores.cold.at("Skein").xy2, scores.warm.at("Skein").xy2) << "the same frames, the same poses";
}

TEST(ColdBench, AFrameOfAnMjpegCameraIsTimedWithItsDecoding) {
  const ColdScores scores = measured("MJPEG", 1);
  EXPECT_GT(scores.jpeg_bytes, 5e4);
  EXPECT_GT(scores.cold.at("decoding").percentile(0.5), 0.0);
  EXPECT_GT(scores.cold.at("Skein").percentile(0.5), scores.cold.at("decoding").percentile(0.0));
  EXPECT_EQ(scores.cold.at("Skein").recall(), 100.0);
}

}  // namespace
}  // namespace skein::vision
