#include "vision/synthetic/floor.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "vision/calibration/calibration.h"
#include "vision/synthetic/random.h"
#include "vision/synthetic/shaders.h"

namespace skein::vision::detail {
namespace {

/// Smooth noise: random values at the points of a grid, blended between them. [-1, 1]
class ValueNoise {
 public:
  /// pitch: of the grid [m].
  ValueNoise(std::uint64_t seed, float pitch) : seed_(seed), pitch_(pitch) {}

  /// The noise at points beside each other.
  template <std::size_t count>
  std::array<float, count> operator()(const Points<count>& points) {
    std::array<float, count> s, t;
    std::array<int, count> columns, rows;
    for (std::size_t i = 0; i < count; ++i) {
      const float x = points.x[i] / pitch_, y = points.y[i] / pitch_;
      columns[i] = whole_below(x);
      rows[i] = whole_below(y);
      s[i] = ease(x - static_cast<float>(columns[i]));
      t[i] = ease(y - static_cast<float>(rows[i]));
    }
    Cells cells{columns[0], columns[0], rows[0], rows[0]};
    for (std::size_t i = 0; i < count; ++i) {
      cells.left = std::min(cells.left, columns[i]);
      cells.right = std::max(cells.right, columns[i]);
      cells.top = std::min(cells.top, rows[i]);
      cells.bottom = std::max(cells.bottom, rows[i]);
    }
    std::array<float, count> above_left, above_right, below_left, below_right;
    if (draw(cells)) {
      for (std::size_t i = 0; i < count; ++i) {
        const float* corner = drawn_.data() + (rows[i] - cells_.top) * side + (columns[i] - cells_.left);
        above_left[i] = corner[0];
        above_right[i] = corner[1];
        below_left[i] = corner[side];
        below_right[i] = corner[side + 1];
      }
    } else {  // so far apart that hardly two of them share a value
      for (std::size_t i = 0; i < count; ++i) {
        const auto left = static_cast<float>(columns[i]), top = static_cast<float>(rows[i]);
        above_left[i] = at(left, top);
        above_right[i] = at(left + 1, top);
        below_left[i] = at(left, top + 1);
        below_right[i] = at(left + 1, top + 1);
      }
    }
    std::array<float, count> noise;
    for (std::size_t i = 0; i < count; ++i) {
      const float above = above_left[i] + s[i] * (above_right[i] - above_left[i]);
      const float below = below_left[i] + s[i] * (below_right[i] - below_left[i]);
      noise[i] = above + t[i] * (below - above);
    }
    return noise;
  }

 private:
  static constexpr int side = 16;  // of what is drawn at once

  /// Of the grid, the last ones included.
  struct Cells {
    int left, right, top, bottom;
  };

  /// Sees to the values at the corners of these cells; false where they are too many.
  bool draw(const Cells& cells) {
    if (cells.left >= cells_.left && cells.right <= cells_.right && cells.top >= cells_.top &&
        cells.bottom <= cells_.bottom)
      return true;
    constexpr int exact = 1 << 23;  // up to there, numbers that differ by one differ as floats
    if (cells.right - cells.left > side - 2 || cells.bottom - cells.top > side - 2 || std::abs(cells.left) > exact ||
        std::abs(cells.top) > exact)
      return false;
    cells_ = cells;
    for (int row = cells.top; row <= cells.bottom + 1; ++row)
      for (int column = cells.left; column <= cells.right + 1; ++column)
        drawn_[static_cast<std::size_t>((row - cells.top) * side + column - cells.left)] =
            at(static_cast<float>(column), static_cast<float>(row));
    return true;
  }

  static float ease(float t) { return t * t * (3.0F - 2.0F * t); }
  /// std::floor of what fits an int: without SSE 4.1 that is a call.
  static int whole_below(float x) {
    const int whole = static_cast<int>(x);
    return whole - (static_cast<float>(whole) > x ? 1 : 0);
  }
  float at(float i, float j) const {
    const auto column = static_cast<std::uint64_t>(static_cast<std::int64_t>(i));
    const auto row = static_cast<std::uint64_t>(static_cast<std::int64_t>(j));
    const std::uint64_t bits = Random::mix(seed_ + column * 0x9e3779b97f4a7c15ULL + row * 0xc2b2ae3d27d4eb4fULL);
    return static_cast<float>(bits >> 40) * (2.0F / 16777216.0F) - 1.0F;
  }

  std::uint64_t seed_;
  float pitch_;
  Cells cells_{0, -1, 0, -1};  // mostly the next points lie in them, too
  std::array<float, side * side> drawn_{};
};

class LinoleumShader {
 public:
  explicit LinoleumShader(std::uint64_t seed)
      : coarse_(seed, 0.11F), fine_(seed + 1, 0.018F), finest_(seed + 2, 0.004F) {}

  template <std::size_t count>
  void operator()(const Points<count>& at, Shades<count>& shades) {
    const std::array<float, count> coarse = coarse_(at), fine = fine_(at), finest = finest_(at);
    for (std::size_t i = 0; i < count; ++i)
      shades.grey[i] = 150.0F + (9.0F * coarse[i] + 7.0F * fine[i] + 6.0F * finest[i]);
    shades.cover.fill(1.0F);
  }

 private:
  ValueNoise coarse_, fine_, finest_;
};

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
    painter_.paint<1>(canvas_, {0, 0, canvas_.width, canvas_.height}, 0.0, LinoleumShader(random_.bits()));
    constexpr double tile = 0.5;
    const int across = static_cast<int>(reach_x_ / tile), down = static_cast<int>(reach_y_ / tile);
    for (int i = -across; i <= across; ++i)
      strip(tile * i + 0.07, 0.0, std::numbers::pi / 2, 2.0 * reach_y_, 0.003, {95.0F, 0.6F});
    for (int i = -down; i <= down; ++i) strip(0.0, tile * i - 0.11, 0.0, 2.0 * reach_x_, 0.003, {95.0F, 0.6F});
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
    // In pieces, since every pixel of a box around the whole of a long thin one would have to be computed.
    const int pieces = static_cast<int>(std::ceil(length / std::max(0.05, 2.0 * width)));
    const double piece = length / pieces;
    for (int i = 0; i < pieces; ++i) {
      const double along = (i + 0.5) * piece - 0.5 * length;
      short_strip(x + along * std::cos(angle), y + along * std::sin(angle), angle, piece, width, shade);
    }
  }

  void short_strip(double x, double y, double angle, double length, double width, Shade shade) {
    const Box box = painter_.box_around(x, y, std::hypot(length, width) / 2.0, 0.0);
    painter_.paint<16>(canvas_, box, 0.0, StripShader(x, y, angle, length, width, shade));
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
