#include "vision/synthetic/synthetic_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "vision/synthetic/floor.h"
#include "vision/synthetic/noise_bank.h"
#include "vision/synthetic/painter.h"
#include "vision/synthetic/shaders.h"
#include "vision/tags/tag_pattern.h"

namespace skein::vision {
namespace {

using detail::Box;
using detail::Canvas;
using detail::Painter;
using detail::Shade;

Painter::Light light_over(const Calibration& calibration, const SceneOptions& options) {
  // Brightest at the top left corner, where the window is; (1 - light_gradient) of it at the opposite one.
  const auto width = static_cast<float>(calibration.width);
  const auto height = static_cast<float>(calibration.height);
  const auto loss = static_cast<float>(options.light_gradient);
  const auto brightness = static_cast<float>(options.brightness);
  const float quarter_diagonal_squared = (width * width + height * height) / 4.0F;
  return {.at_centre = brightness * (1.0F - 0.4F * loss),
          .per_u = -brightness * 0.4F * loss / width,
          .per_v = -brightness * 0.4F * loss / height,
          .vignette = brightness * 0.2F * loss / quarter_diagonal_squared,
          .centre_u = width / 2.0F,
          .centre_v = height / 2.0F};
}

}  // namespace

struct SyntheticCamera::Parts {
  Calibration calibration;
  SceneOptions options;
  std::vector<detail::TagPattern> pattern_of;
  Painter painter;
  detail::Blur blur;
  detail::NoiseBank noise;
  Canvas floor;                       // sharp
  Canvas sharp;                       // the floor without the robots of the frame being drawn
  std::vector<std::uint8_t> blurred;  // the floor as the lens shows it, also without these robots
  std::vector<std::uint8_t> blurred_floor;
  std::vector<std::uint8_t> lit;  // by lamps that flicker
  std::vector<Box> touched;
  std::int64_t frames = 0;

  Parts(Calibration c, const SceneOptions& o, std::uint64_t seed)
      : calibration(std::move(c)),
        options(o),
        pattern_of(detail::tag_patterns()),
        painter(calibration, light_over(calibration, options)),
        blur(options.blur_px),
        noise(options.noise_sigma, seed) {
    floor.width = calibration.width;
    floor.height = calibration.height;
    const auto pixels = static_cast<std::size_t>(floor.width) * static_cast<std::size_t>(floor.height);
    floor.grey.resize(pixels);
    detail::paint_floor(painter, calibration, options.clutter, seed, floor);
    sharp = floor;
    blurred_floor.resize(pixels);
    blur_floor();
  }

  void blur_floor() {
    blur.apply(floor, {0, 0, floor.width, floor.height}, blurred_floor.data());
    blurred = blurred_floor;
  }

  void draw_robot(const SyntheticTag& tag);
  void draw_smeared(const SyntheticTag& tag);
  void draw_tag(const SyntheticTag& tag);
  void paint_disc(const core::Pose& at, double radius, double height, double soft, Shade shade);
  void touch(const Box& box);
  void flicker(double captured_at);
  void clean();
};

SyntheticCamera::SyntheticCamera(Calibration calibration, const SceneOptions& options, std::uint64_t seed) {
  if (!calibration.world_from_camera)
    throw std::invalid_argument("SyntheticCamera: the calibration has no world frame");
  parts_ = std::make_unique<Parts>(std::move(calibration), options, seed);
}

SyntheticCamera::~SyntheticCamera() = default;
SyntheticCamera::SyntheticCamera(SyntheticCamera&&) noexcept = default;
SyntheticCamera& SyntheticCamera::operator=(SyntheticCamera&&) noexcept = default;

void SyntheticCamera::hang(const CameraPose& pose) {
  parts_->calibration.world_from_camera = pose;
  parts_->painter = Painter(parts_->calibration, light_over(parts_->calibration, parts_->options));
}

void SyntheticCamera::focus(double blur_px) {
  parts_->clean();
  parts_->blur = detail::Blur(blur_px);
  parts_->blur_floor();
}

void SyntheticCamera::render(std::span<const SyntheticTag> tags, std::span<const SyntheticDisc> discs,
                             double captured_at, Frame& out) {
  Parts& parts = *parts_;
  out.resize(parts.calibration.width, parts.calibration.height);
  out.captured_at = captured_at;
  out.index = parts.frames++;
  out.source = std::to_string(out.index);
  for (const SyntheticTag& tag : tags) {
    if (tag.smear > 0.0) {
      parts.draw_smeared(tag);
    } else {
      parts.draw_robot(tag);
    }
  }
  for (const SyntheticDisc& disc : discs) {
    parts.paint_disc({disc.x, disc.y, 0.0}, disc.radius, disc.height, disc.soft,
                     {static_cast<float>(disc.grey), static_cast<float>(disc.cover)});
  }
  // Only now, so that a robot's edge is blurred into the robot beside it and not into the floor.
  for (const Box& box : parts.touched) parts.blur.apply(parts.sharp, box, parts.blurred.data());
  if (parts.options.flicker > 0.0) {
    parts.flicker(captured_at);
    parts.noise.add(parts.lit, out);
  } else {
    parts.noise.add(parts.blurred, out);
  }
  parts.clean();
}

/// Each row in the light of its own time; the brightest is the steady lamps'.
void SyntheticCamera::Parts::flicker(double captured_at) {
  lit.resize(blurred.size());
  const double turn = 2.0 * std::numbers::pi * options.flicker_hz;
  const double half = 0.5 * turn * options.exposure;
  const double depth = options.flicker * (half > 0.0 ? std::sin(half) / half : 1.0);
  for (int v = 0; v < floor.height; ++v) {
    const double middle = captured_at + calibration.row_time * v + 0.5 * options.exposure;
    const auto light = static_cast<float>((1.0 + depth * std::sin(turn * middle)) / (1.0 + options.flicker));
    std::array<std::uint8_t, 256> in_light;
    for (std::size_t grey = 0; grey < in_light.size(); ++grey)
      in_light[grey] = static_cast<std::uint8_t>(std::lround(light * static_cast<float>(grey)));
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(v) * floor.width;
    std::transform(blurred.begin() + row, blurred.begin() + row + floor.width, lit.begin() + row,
                   [&in_light](std::uint8_t grey) { return in_light[grey]; });
  }
}

void SyntheticCamera::Parts::draw_robot(const SyntheticTag& tag) {
  if (options.body_radius > 0.0 && !tag.bare) {
    const core::Pose& pose = tag.pose;
    const double radius = options.body_radius;
    // The light comes from the top left: the shadow lies a little to the right and below.
    const double aside = 0.25 * radius;
    paint_disc({pose.x + aside, pose.y - aside, 0.0}, 1.15 * radius, 0.0, 0.35 * radius, {40.0F, 0.5F});
    // The tag hides most of the body from straight above; its side shows towards the edges of the picture.
    paint_disc(pose, radius, 0.35 * calibration.tag_height, 0.0, {70.0F, 1.0F});
    paint_disc(pose, radius, 0.9 * calibration.tag_height, 0.0, {95.0F, 1.0F});
  }
  draw_tag(tag);
}

/// The mean of what the shutter sees while the robot drives ahead.
void SyntheticCamera::Parts::draw_smeared(const SyntheticTag& tag) {
  constexpr int moments = 8;
  const double reach = 0.5 * tag.smear + tag.size + 2.0 * options.body_radius;
  Box box = painter.box_around(tag.pose.x, tag.pose.y, reach, 0.0);
  const Box raised = painter.box_around(tag.pose.x, tag.pose.y, reach, calibration.tag_height);
  box = box.with(raised);
  if (box.empty()) return;
  const auto each = [&](auto&& pixel) {
    std::size_t k = 0;
    for (int v = box.top; v < box.bottom; ++v)
      for (int u = box.left; u < box.right; ++u) pixel(sharp.row(v)[u], k++);
  };
  std::vector<float> before;
  each([&](float& grey, std::size_t) { before.push_back(grey); });
  std::vector<float> sum(before.size(), 0.0F);
  for (int i = 0; i < moments; ++i) {
    each([&](float& grey, std::size_t k) { grey = before[k]; });
    SyntheticTag moment = tag;
    const double ahead = ((i + 0.5) / moments - 0.5) * tag.smear;
    moment.pose.x += ahead * std::cos(tag.pose.theta);
    moment.pose.y += ahead * std::sin(tag.pose.theta);
    draw_robot(moment);
    each([&](float& grey, std::size_t k) { sum[k] += grey; });
  }
  each([&](float& grey, std::size_t k) { grey = sum[k] / moments; });
}

void SyntheticCamera::Parts::paint_disc(const core::Pose& at, double radius, double height, double soft, Shade shade) {
  const Box box = painter.box_around(at.x, at.y, radius, height);
  painter.paint<4>(sharp, box, height, detail::DiscShader(at.x, at.y, radius, soft, shade));
  touch(box);
}

void SyntheticCamera::Parts::draw_tag(const SyntheticTag& tag) {
  const double module = tag.size / 8.0, height = calibration.tag_height + tag.lifted;
  const Box box =
      painter.box_around(tag.pose.x, tag.pose.y, module * detail::pattern_cells / std::numbers::sqrt2, height);
  const float ink = detail::paper_grey + static_cast<float>(options.contrast) * (detail::ink_grey - detail::paper_grey);
  const bool known = tag.tag >= 0 && static_cast<std::size_t>(tag.tag) < pattern_of.size();
  const detail::TagPattern* pattern = known ? &pattern_of[static_cast<std::size_t>(tag.tag)] : nullptr;
  painter.paint<16>(sharp, box, height, detail::TagShader(tag.pose, module, pattern, ink));
  touch(box);
}

/// What was painted, and what the lens blurs it into. One box for what overlaps: a robot's body, shadow and tag.
void SyntheticCamera::Parts::touch(const Box& box) {
  if (box.empty()) return;
  const Box reached = box.grown(blur.reach()).in(calibration.width, calibration.height);
  if (!touched.empty()) {
    Box& last = touched.back();
    const Box both = last.with(reached);
    if (both.area() <= last.area() + reached.area()) {
      last = both;
      return;
    }
  }
  touched.push_back(reached);
}

/// Back to the bare floor.
void SyntheticCamera::Parts::clean() {
  for (const Box& box : touched) {
    for (int v = box.top; v < box.bottom; ++v) {
      const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(v) * floor.width + box.left;
      const std::ptrdiff_t end = start + (box.right - box.left);
      std::copy(floor.grey.begin() + start, floor.grey.begin() + end, sharp.grey.begin() + start);
      std::copy(blurred_floor.begin() + start, blurred_floor.begin() + end, blurred.begin() + start);
    }
  }
  touched.clear();
}

}  // namespace skein::vision
