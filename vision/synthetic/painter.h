#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "vision/calibration/calibration.h"

namespace skein::vision::detail {

/// Pixels [left, right) x [top, bottom).
struct Box {
  int left = std::numeric_limits<int>::max();
  int top = std::numeric_limits<int>::max();
  int right = std::numeric_limits<int>::min();
  int bottom = std::numeric_limits<int>::min();

  bool empty() const { return left >= right || top >= bottom; }
  Box grown(int by) const { return empty() ? *this : Box{left - by, top - by, right + by, bottom + by}; }
  Box in(int width, int height) const {
    return {std::max(left, 0), std::max(top, 0), std::min(right, width), std::min(bottom, height)};
  }
};

/// A picture of grey levels that are not yet rounded.
struct Canvas {
  int width = 0;
  int height = 0;
  std::vector<float> grey;

  float* row(int v) { return grey.data() + static_cast<std::ptrdiff_t>(v) * width; }
  const float* row(int v) const { return grey.data() + static_cast<std::ptrdiff_t>(v) * width; }
};

/// What a shader says of a point: its brightness in full light [grey levels] and how much of the ground it hides
/// (0..1).
struct Shade {
  float grey = 0.0F;
  float cover = 0.0F;
};

/// Where `count` points are sampled in a pixel: all columns and all rows differ (Hammersley), so that an upright edge,
/// too, is placed to 1/count of a pixel and not to 1/sqrt(count) as on a square grid.
template <int count>
constexpr std::array<std::array<float, 2>, count> sample_places() {
  std::array<std::array<float, 2>, count> places{};
  for (int i = 0; i < count; ++i) {
    int reversed = 0;
    for (int bit = 1, value = i; bit < count; bit *= 2, value /= 2) reversed = 2 * reversed + value % 2;
    places[static_cast<std::size_t>(i)] = {(static_cast<float>(i) + 0.5F) / count - 0.5F,
                                           (static_cast<float>(reversed) + 0.5F) / count - 0.5F};
  }
  return places;
}

/// Renders objects on planes above the floor into a canvas, as seen by the calibration's camera.
class Painter {
 public:
  /// light(u, v) multiplies what a shader says.
  struct Light {
    float at_centre = 1.0F;
    float per_u = 0.0F;  // linear over the picture
    float per_v = 0.0F;
    float vignette = 0.0F;  // times the squared distance from the middle
    float centre_u = 0.0F;
    float centre_v = 0.0F;
    float operator()(float u, float v) const {
      const float du = u - centre_u;
      const float dv = v - centre_v;
      return at_centre + per_u * du + per_v * dv - vignette * (du * du + dv * dv);
    }
  };

  Painter(const Calibration& calibration, const Light& light) : calibration_(calibration), light_(light) {}

  /// The pixels that a disc around (x, y) on the plane z = height can touch; empty where a point of it cannot be seen.
  Box box_around(double x, double y, double radius, double height) const {
    Box box;
    constexpr int corners = 8;  // of a polygon around the disc
    const double reach = radius / std::cos(std::numbers::pi / corners);
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / corners;
      const auto pixel =
          pixel_from_world(calibration_, {x + reach * std::cos(angle), y + reach * std::sin(angle), height});
      // A point far outside: no part of the disc is worth drawing, and its pixel might not fit an int.
      if (!pixel || pixel->cwiseAbs().maxCoeff() > 1e5) return {};
      box.left = std::min(box.left, static_cast<int>(std::floor(pixel->x())));
      box.top = std::min(box.top, static_cast<int>(std::floor(pixel->y())));
      box.right = std::max(box.right, static_cast<int>(std::ceil(pixel->x())) + 1);
      box.bottom = std::max(box.bottom, static_cast<int>(std::ceil(pixel->y())) + 1);
    }
    return box.in(calibration_.width, calibration_.height);
  }

  /// shader(x, y) -> Shade is asked at `samples` points of every pixel of the box. The map from pixels to the plane is
  /// exact at the corners of 8x8 cells and bilinear within them: 0.002 px off at worst with a distortion of 20 px at
  /// the picture's corners.
  template <int samples, typename Shader>
  void paint(Canvas& canvas, const Box& box, double height, Shader&& shader) {
    if (box.empty()) return;
    static constexpr auto places = sample_places<samples>();
    constexpr int cell = 8;
    const int columns = (box.right - box.left + cell - 1) / cell;
    const int rows = (box.bottom - box.top + cell - 1) / cell;
    nodes_.resize(static_cast<std::size_t>(columns + 1) * static_cast<std::size_t>(rows + 1));
    for (int r = 0; r <= rows; ++r) {
      for (int c = 0; c <= columns; ++c) {
        const auto point =
            world_from_pixel(calibration_, {box.left + c * cell - 0.5, box.top + r * cell - 0.5}, height);
        nodes_[static_cast<std::size_t>(r * (columns + 1) + c)] =
            point ? point->cast<float>().eval() : Eigen::Vector2f(1e6F, 1e6F);
      }
    }
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const Eigen::Vector2f* top = &nodes_[static_cast<std::size_t>(r * (columns + 1) + c)];
        const Eigen::Vector2f* bottom = top + columns + 1;
        const Eigen::Vector2f along_u = top[1] - top[0];
        const Eigen::Vector2f along_v = bottom[0] - top[0];
        const Eigen::Vector2f twist = bottom[1] - bottom[0] - along_u;
        const int u_end = std::min(box.left + (c + 1) * cell, box.right);
        const int v_end = std::min(box.top + (r + 1) * cell, box.bottom);
        for (int v = box.top + r * cell; v < v_end; ++v) {
          for (int u = box.left + c * cell; u < u_end; ++u) {
            float grey = 0.0F;
            float cover = 0.0F;
            for (const auto& place : places) {
              const float s = (static_cast<float>(u - box.left - c * cell) + 0.5F + place[0]) / cell;
              const float t = (static_cast<float>(v - box.top - r * cell) + 0.5F + place[1]) / cell;
              const float x = top->x() + s * along_u.x() + t * (along_v.x() + s * twist.x());
              const float y = top->y() + s * along_u.y() + t * (along_v.y() + s * twist.y());
              const Shade shade = shader(x, y);
              grey += shade.cover * shade.grey;
              cover += shade.cover;
            }
            float& pixel = canvas.row(v)[u];
            const float light = light_(static_cast<float>(u), static_cast<float>(v));
            pixel += (light * grey - cover * pixel) / samples;
          }
        }
      }
    }
  }

 private:
  Calibration calibration_;
  Light light_;
  std::vector<Eigen::Vector2f> nodes_;
};

/// A Gaussian blur of part of a picture; beyond the picture's edge its last pixel goes on.
class Blur {
 public:
  explicit Blur(double sigma_px);
  /// Pixels around a place that its blurred value depends on.
  int reach() const { return static_cast<int>(weights_.size()) - 1; }
  /// Blurs the box of `from`, rounded to whole grey levels, into the same place of `to` (rows of from.width bytes).
  void apply(const Canvas& from, const Box& box, std::uint8_t* to);

 private:
  std::vector<float> weights_;  // from the middle outwards
  std::vector<float> padded_;   // one row of the box and what it depends on at both ends
  std::vector<float> across_;   // the rows of the box blurred along u
};

}  // namespace skein::vision::detail
