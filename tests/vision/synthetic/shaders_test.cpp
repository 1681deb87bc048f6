#include "vision/synthetic/shaders.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/vision/support.h"

namespace skein::vision::detail {
namespace {

/// Asks the shader of every sample: it has no even().
template <typename Shader>
auto sampled(const Shader& shader) {
  return [shader](float x, float y) { return shader(x, y); };
}

template <int samples, typename Shader>
void expect_the_same_pixels(const core::Pose& at, double reach, double height, const Shader& shader) {
  static const Calibration calibration = overhead_calibration(2.0, 1.5);
  static Painter painter(calibration, {});
  static Canvas saving{calibration.width, calibration.height, {}};
  saving.grey.resize(static_cast<std::size_t>(saving.width) * static_cast<std::size_t>(saving.height), 131.7F);
  static Canvas plain = saving;
  const Box box = painter.box_around(at.x, at.y, reach, height);
  // Both begin with the same pixels, whatever an earlier case has left.
  for (int v = box.top; v < box.bottom; ++v)
    std::copy(saving.row(v) + box.left, saving.row(v) + box.right, plain.row(v) + box.left);
  painter.paint<samples>(saving, box, height, shader);
  painter.paint<samples>(plain, box, height, sampled(shader));
  for (int v = box.top; v < box.bottom; ++v)
    RC_ASSERT(std::equal(saving.row(v) + box.left, saving.row(v) + box.right, plain.row(v) + box.left));
}

core::Pose pose_on_the_floor() {
  return {*rc::gen::inRange(-1000, 1000) / 1e3, *rc::gen::inRange(-750, 750) / 1e3,
          *rc::gen::inRange(-3141, 3141) / 1e3};
}

RC_GTEST_PROP(Shaders, ATagsEvenPixelsAreAsIfSampled, ()) {
  const core::Pose pose = pose_on_the_floor();
  const double module = *rc::gen::inRange(1500, 20000) / 1e6, height = *rc::gen::inRange(0, 200) / 1e3;
  static const std::vector<TagPattern> patterns = tag_patterns();
  const TagPattern& pattern = patterns[*rc::gen::inRange<std::size_t>(0, patterns.size())];
  expect_the_same_pixels<16>(pose, 10.0 * module, height, TagShader(pose, module, &pattern, 43.3F));
}

RC_GTEST_PROP(Shaders, ADiscsEvenPixelsAreAsIfSampled, ()) {
  const core::Pose pose = pose_on_the_floor();
  const double radius = *rc::gen::inRange(1, 100) / 1e3, soft = *rc::gen::inRange(0, 40) / 1e3;
  expect_the_same_pixels<4>(pose, 1.2 * radius, 0.0, DiscShader(pose.x, pose.y, radius, soft, {95.1F, 0.5F}));
}

RC_GTEST_PROP(Shaders, AStripsEvenPixelsAreAsIfSampled, ()) {
  const core::Pose pose = pose_on_the_floor();
  const double length = *rc::gen::inRange(1, 100) / 1e3, width = *rc::gen::inRange(1, 50) / 1e3;
  expect_the_same_pixels<16>(pose, length + width, 0.0,
                             StripShader(pose.x, pose.y, pose.theta, length, width, {95.1F, 0.6F}));
}

RC_GTEST_PROP(Blur, OfAnyBoxIsTheWeightedSumOfEachPixelsSurroundings, ()) {
  const int width = *rc::gen::inRange(1, 40), height = *rc::gen::inRange(1, 30);
  Canvas canvas{width, height, {}};
  for (int i = 0; i < width * height; ++i) canvas.grey.push_back(static_cast<float>(*rc::gen::inRange(0, 25500)) / 100);
  const double sigma = *rc::gen::inRange(0, 30) / 10.0;
  const Box box{*rc::gen::inRange(0, width), *rc::gen::inRange(0, height), width, height};
  Blur blur(sigma);
  std::vector<std::uint8_t> blurred(canvas.grey.size());
  blur.apply(canvas, box, blurred.data());

  std::vector<double> weights;
  double all = 0.0;
  for (int k = -blur.reach(); k <= blur.reach(); ++k) {
    weights.push_back(k == 0 ? 1.0 : std::exp(-0.5 * k * k / (sigma * sigma)));
    all += weights.back();
  }
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double there = blurred[static_cast<std::size_t>(canvas.row(v) + u - canvas.grey.data())];
      if (u < box.left || v < box.top) {
        RC_ASSERT(there == 0.0);
        continue;
      }
      double sum = 0.0;
      for (int i = 0; i <= 2 * blur.reach(); ++i) {
        const float* row = canvas.row(std::clamp(v + i - blur.reach(), 0, height - 1));
        for (int k = 0; k <= 2 * blur.reach(); ++k)
          sum += weights[static_cast<std::size_t>(i)] * weights[static_cast<std::size_t>(k)] / (all * all) *
                 static_cast<double>(row[std::clamp(u + k - blur.reach(), 0, width - 1)]);
      }
      RC_ASSERT(std::abs(there - std::clamp(sum, 0.0, 255.0)) < 0.501);
    }
  }
}

}  // namespace
}  // namespace skein::vision::detail
