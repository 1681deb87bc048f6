#include "vision/synthetic/floor.h"

#include <numbers>

#include "vision/calibration/calibration.h"
#include "vision/synthetic/random.h"

namespace skein::vision::detail {
namespace {

/// Smooth noise: random values at the points of a grid of pitch 1, blended between them. [-1, 1]
float value_noise(float x, float y, std::uint64_t seed) {
  const float fx = std::floor(x);
  const float fy = std::floor(y);
  const auto at = [&](float i, float j) {
    const auto column = static_cast<std::uint64_t>(static_cast<std::int64_t>(i));
    const auto row = static_cast<std::uint64_t>(static_cast<std::int64_t>(j));
    const std::uint64_t bits = Random::mix(seed + column * 0x9e3779b97f4a7c15ULL + row * 0xc2b2ae3d27d4eb4fULL);
    return static_cast<float>(bits >> 40) * (2.0F / 16777216.0F) - 1.0F;
  };
  const auto ease = [](float t) { return t * t * (3.0F - 2.0F * t); };
  const float s = ease(x - fx);
  const float t = ease(y - fy);
  const float top = at(fx, fy) + s * (at(fx + 1, fy) - at(fx, fy));
  const float bottom = at(fx, fy + 1) + s * (at(fx + 1, fy + 1) - at(fx, fy + 1));
  return top + t * (bottom - top);
}

class FloorPainter {
 public:
  FloorPainter(Painter& painter, const Calibration& calibration, std::uint64_t seed, Canvas& canvas)
      : painter_(painter), canvas_(canvas), random_(seed) {
    // The part of the floor in the picture: clutter is strewn over it.
    for (const double u : {0.0, calibration.width - 1.0}) {
      for (const double v : {0.0, calibration.height - 1.0}) {
        const auto corner = world_from_pixel(calibration, {u, v}, 0.0);
        if (!corner) continue;
        reach_x_ = std::max(reach_x_, std::abs(corner->x()));
        reach_y_ = std::max(reach_y_, std::abs(corner->y()));
      }
    }
  }

  void linoleum() {
    const std::uint64_t seed = random_.bits();
    painter_.paint<1>(canvas_, {0, 0, canvas_.width, canvas_.height}, 0.0, [seed](float x, float y) {
      const float mottle = 9.0F * value_noise(x / 0.11F, y / 0.11F, seed) +
                           7.0F * value_noise(x / 0.018F, y / 0.018F, seed + 1) +
                           6.0F * value_noise(x / 0.004F, y / 0.004F, seed + 2);
      return Shade{150.0F + mottle, 1.0F};
    });
    constexpr double tile = 0.5;
    for (double x = -tile * std::floor(reach_x_ / tile); x <= reach_x_; x += tile) {
      strip(x + 0.07, 0.0, std::numbers::pi / 2, 2.0 * reach_y_, 0.003, {95.0F, 0.6F});
    }
    for (double y = -tile * std::floor(reach_y_ / tile); y <= reach_y_; y += tile) {
      strip(0.0, y - 0.11, 0.0, 2.0 * reach_x_, 0.003, {95.0F, 0.6F});
    }
  }

  void piece_of_clutter() {
    const double x = random_.between(-reach_x_, reach_x_);
    const double y = random_.between(-reach_y_, reach_y_);
    const double angle = random_.between(-std::numbers::pi, std::numbers::pi);
    const auto grey = static_cast<float>(random_.between(20.0, 235.0));
    switch (random_.below(6)) {
      case 0:  // tape
        strip(x, y, angle, random_.between(0.05, 0.35), random_.between(0.012, 0.025), {grey, 0.92F});
        break;
      case 1: {  // a black square in a white one: all that a tag has but its bits
        const double size = random_.between(0.03, 0.07);
        strip(x, y, angle, 1.25 * size, 1.25 * size, {paper_grey, 1.0F});
        strip(x, y, angle, size, size, {ink_grey, 1.0F});
        break;
      }
      case 2:
        cable(x, y, angle);
        break;
      case 3:
        disc(x, y, random_.between(0.01, 0.03), {grey, 0.9F});
        break;
      default:  // dirt
        disc(x, y, random_.between(0.001, 0.004), {static_cast<float>(random_.between(30.0, 110.0)), 0.8F});
        break;
    }
  }

 private:
  void strip(double x, double y, double angle, double length, double width, Shade shade) {
    // In pieces, since every pixel of a box around the whole of a long thin one would be asked for.
    const int pieces = static_cast<int>(std::ceil(length / std::max(0.05, 2.0 * width)));
    const double piece = length / pieces;
    for (int i = 0; i < pieces; ++i) {
      const double along = (i + 0.5) * piece - 0.5 * length;
      short_strip(x + along * std::cos(angle), y + along * std::sin(angle), angle, piece, width, shade);
    }
  }

  void short_strip(double x, double y, double angle, double length, double width, Shade shade) {
    const auto cx = static_cast<float>(x);
    const auto cy = static_cast<float>(y);
    const auto c = static_cast<float>(std::cos(angle));
    const auto s = static_cast<float>(std::sin(angle));
    const auto half_length = static_cast<float>(length / 2.0);
    const auto half_width = static_cast<float>(width / 2.0);
    const Box box = painter_.box_around(x, y, std::hypot(length, width) / 2.0, 0.0);
    painter_.paint<16>(canvas_, box, 0.0, [=](float px, float py) {
      const float along = c * (px - cx) + s * (py - cy);
      const float across = c * (py - cy) - s * (px - cx);
      return along >= -half_length && along < half_length && std::abs(across) < half_width ? shade : Shade{};
    });
  }

  void disc(double x, double y, double radius, Shade shade) {
    const auto cx = static_cast<float>(x);
    const auto cy = static_cast<float>(y);
    const auto r2 = static_cast<float>(radius * radius);
    painter_.paint<16>(canvas_, painter_.box_around(x, y, radius, 0.0), 0.0, [=](float px, float py) {
      return (px - cx) * (px - cx) + (py - cy) * (py - cy) < r2 ? shade : Shade{};
    });
  }

  void cable(double x, double y, double angle) {
    double bend = random_.between(-1.0, 1.0);
    for (int i = 0; i < 24; ++i) {
      constexpr double step = 0.012;
      x += step * std::cos(angle);
      y += step * std::sin(angle);
      strip(x, y, angle, 1.6 * step, 0.005, {45.0F, 1.0F});
      bend += random_.between(-1.0, 1.0);
      angle += 0.12 * bend;
    }
  }

  Painter& painter_;
  Canvas& canvas_;
  Random random_;
  double reach_x_ = 0.0;
  double reach_y_ = 0.0;
};

}  // namespace

void paint_floor(Painter& painter, const Calibration& calibration, int clutter, std::uint64_t seed, Canvas& canvas) {
  FloorPainter floor(painter, calibration, seed, canvas);
  floor.linoleum();
  for (int i = 0; i < clutter; ++i) floor.piece_of_clutter();
}

}  // namespace skein::vision::detail
