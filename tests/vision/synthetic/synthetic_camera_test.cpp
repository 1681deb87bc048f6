#include "vision/synthetic/synthetic_camera.h"

#include <cmath>
#include <numeric>
#include <utility>

#include "tests/vision/support.h"

namespace skein::vision {
namespace {

const std::vector<SyntheticTag> three = {
    {1, {0.3, -0.2, 0.7}}, {2, {-0.6, 0.4, -2.0}}, {586, {0.98, -0.73, 3.0}, 0.05}};

double mean_grey(const Frame& frame, double u, double v, int reach) {
  double sum = 0.0;
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) sum += frame.row(static_cast<int>(v) + dv)[static_cast<int>(u) + du];
  }
  return sum / ((2 * reach + 1) * (2 * reach + 1));
}

TEST(SyntheticCamera, SameSeedAndCallsGiveTheSameBytes) {
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  SyntheticCamera first(calibration, {}, 5);
  SyntheticCamera second(calibration, {}, 5);
  SyntheticCamera other(calibration, {}, 6);
  Frame a;
  Frame b;
  Frame c;
  for (int i = 0; i < 3; ++i) {
    first.render(three, 0.04 * i, a);
    second.render(three, 0.04 * i, b);
    other.render(three, 0.04 * i, c);
    EXPECT_EQ(a.grey, b.grey);
    EXPECT_NE(a.grey, c.grey);
    EXPECT_EQ(a.index, i);
    EXPECT_EQ(a.source, std::to_string(i));
    EXPECT_EQ(a.captured_at, 0.04 * i);
    EXPECT_EQ(a.width, 1280);
    EXPECT_EQ(a.height, 960);
  }
}

TEST(SyntheticCamera, RobotsLeaveNoTraceBehind) {
  SyntheticCamera camera(overhead_calibration(2.0, 1.5), {.noise_sigma = 0.0}, 1);
  Frame empty;
  Frame frame;
  camera.render({}, 0.0, empty);
  camera.render(three, 0.0, frame);
  EXPECT_NE(frame.grey, empty.grey);
  camera.render({}, 0.0, frame);
  EXPECT_EQ(frame.grey, empty.grey);
}

TEST(SyntheticCamera, FramesReuseTheirMemory) {
  SyntheticCamera camera(overhead_calibration(2.0, 1.5));
  Frame frame;
  camera.render(three, 0.0, frame);
  const std::uint8_t* const before = frame.grey.data();
  camera.render(three, 0.04, frame);
  EXPECT_EQ(frame.grey.data(), before);
}

TEST(SyntheticCamera, NoiseHasTheSigmaAskedFor) {
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  SyntheticCamera clean(calibration, {.noise_sigma = 0.0}, 3);
  SyntheticCamera noisy(calibration, {.noise_sigma = 4.0}, 3);
  Frame a;
  Frame b;
  Frame c;
  clean.render({}, 0.0, a);
  noisy.render({}, 0.0, b);
  noisy.render({}, 0.0, c);
  double sum = 0.0;
  double squares = 0.0;
  double product = 0.0;
  for (std::size_t i = 0; i < a.grey.size(); ++i) {
    const double error = b.grey[i] - a.grey[i];
    sum += error;
    squares += error * error;
    product += error * (c.grey[i] - a.grey[i]);
  }
  const auto count = static_cast<double>(a.grey.size());
  EXPECT_NEAR(sum / count, 0.0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / count), 4.0, 0.05);
  EXPECT_NEAR(product / squares, 0.0, 0.01) << "from frame to frame it is another noise";
}

TEST(SyntheticCamera, LightPrintAndContrastAreAsAsked) {
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  const auto ink = [&](const SceneOptions& options, double x, double y) {
    SyntheticCamera camera(calibration, options, 1);
    Frame frame;
    camera.render(std::vector<SyntheticTag>{{0, {x, y, 0.0}}}, 0.0, frame);
    // The tag's border is black all around, an eighth of its edge wide; its paper another eighth.
    const auto at = *pixel_from_world(calibration, {x - 0.5 * 0.875 * default_tag_size, y, calibration.tag_height});
    const auto beside = *pixel_from_world(calibration, {x - 0.5 * 1.125 * default_tag_size, y, calibration.tag_height});
    return std::pair{mean_grey(frame, at.x(), at.y(), 0), mean_grey(frame, beside.x(), beside.y(), 0)};
  };
  const SceneOptions even{.noise_sigma = 0.0, .blur_px = 0.3, .light_gradient = 0.0};
  const auto [black, white] = ink(even, 0.0, 0.0);
  EXPECT_NEAR(black, 30.0, 3.0);
  EXPECT_NEAR(white, 225.0, 3.0);
  SceneOptions pale = even;
  pale.contrast = 0.5;
  EXPECT_NEAR(ink(pale, 0.0, 0.0).first, 127.5, 3.0);
  SceneOptions dim = even;
  dim.brightness = 0.4;
  EXPECT_NEAR(ink(dim, 0.0, 0.0).second, 90.0, 3.0);
  SceneOptions uneven = even;
  uneven.light_gradient = 0.5;
  EXPECT_GT(ink(uneven, -0.9, 0.65).second, ink(uneven, 0.9, -0.65).second + 60.0);
}

TEST(SyntheticCamera, DrawsWhatIsPartlyOrWhollyOutside) {
  SyntheticCamera camera(overhead_calibration(2.0, 1.5));
  Frame frame;
  const std::vector<SyntheticTag> tags = {
      {3, {1.08, 0.0, 0.1}}, {4, {-5.0, 0.0, 0.0}}, {5, {1e4, 1e4, 0.0}}, {-7, {0.0, 0.0, 0.0}}, {6, {0.0, 0.82, 0.4}}};
  camera.render(tags, 0.0, frame);
  EXPECT_EQ(frame.grey.size(), std::size_t{1280 * 960});
}

TEST(SyntheticCamera, WantsToKnowWhereItHangs) {
  Calibration calibration = overhead_calibration(2.0, 1.5);
  calibration.world_from_camera.reset();
  EXPECT_THROW(SyntheticCamera{calibration}, std::invalid_argument);
}

TEST(SyntheticCamera, LampsFlickerAndARollingShutterMakesBandsOfIt) {
  Calibration calibration = overhead_calibration(2.0, 1.5);
  calibration.row_time = 25e-6;
  SceneOptions options{.noise_sigma = 0.0};
  Frame steady, bands;
  SyntheticCamera(calibration, options, 1).render({}, 0.0, steady);
  options.flicker = 0.5;
  options.exposure = 0.0;
  SyntheticCamera(calibration, options, 1).render({}, 0.0, bands);
  const auto mean = [](const Frame& frame, int row) {
    return std::accumulate(frame.row(row), frame.row(row) + frame.width, 0.0) / frame.width;
  };
  // A period of 10 ms is 400 rows; the light is (1 + 0.5 sin) / 1.5.
  for (const auto& [row, light] : {std::pair{100, 1.0}, {200, 2.0 / 3.0}, {300, 1.0 / 3.0}, {500, 1.0}})
    EXPECT_NEAR(mean(bands, row) / mean(steady, row), light, 0.01) << row;
  // An exposure of a whole period sees none of it.
  options.exposure = 0.01;
  SyntheticCamera(calibration, options, 1).render({}, 0.0, bands);
  for (const int row : {100, 200, 300}) EXPECT_NEAR(mean(bands, row) / mean(steady, row), 2.0 / 3.0, 0.01) << row;
}

}  // namespace
}  // namespace skein::vision
