#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
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
  /// The smallest box around both.
  Box with(const Box& other) const {
    return {std::min(left, other.left), std::min(top, other.top), std::max(right, other.right),
            std::max(bottom, other.bottom)};
  }
  int area() const { return empty() ? 0 : (right - left) * (bottom - top); }
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

/// A shader's result at a point: its brightness in full light [grey levels] and how much of the ground it hides (0..1).
struct Shade {
  float grey = 0.0F;
  float cover = 0.0F;
};

/// Points on a plane [m], and a shader's results there: in arrays, for the compiler's vector instructions.
template <std::size_t count>
struct Points {
  std::array<float, count> x, y;
};
template <std::size_t count>
struct Shades {
  std::array<float, count> grey, cover;
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
  /// light(u, v) multiplies a shader's brightness.
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
  /// the picture's corners. A shader may also have even(x, y, reach) -> optional<Shade>: the one shade of all points
  /// within `reach` of (x, y), where it knows that there is only one. That saves the samples and changes no pixel.
  /// So does a shader that is asked of several points at once: shader(Points, Shades&).
  template <int samples, typename Shader>
  void paint(Canvas& canvas, const Box& box, double height, Shader&& shader) {
    if (box.empty()) return;
    const int columns = (box.right - box.left + cell - 1) / cell;
    const int rows = (box.bottom - box.top + cell - 1) / cell;
    const auto node = [columns](int r, int c) {
      return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns + 1) + static_cast<std::size_t>(c);
    };
    nodes_.resize(node(rows + 1, 0));
    for (int r = 0; r <= rows; ++r) {
      for (int c = 0; c <= columns; ++c) {
        const auto point =
            world_from_pixel(calibration_, {box.left + c * cell - 0.5, box.top + r * cell - 0.5}, height);
        nodes_[node(r, c)] = point ? point->cast<float>().eval() : Eigen::Vector2f(1e6F, 1e6F);
      }
    }
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const Eigen::Vector2f* top = &nodes_[node(r, c)];
        const int left = box.left + c * cell;
        const int above = box.top + r * cell;
        const Box area{left, above, std::min(left + cell, box.right), std::min(above + cell, box.bottom)};
        paint_cell<samples>(canvas, area, Patch(top, top + columns + 1), shader);
      }
    }
  }

 private:
  static constexpr int cell = 8;  // [px]

  /// The plane in a cell: bilinear between its corners. (s, t): part of the cell's edges.
  struct Patch {
    Patch(const Eigen::Vector2f* above, const Eigen::Vector2f* below)
        : corner(above[0]),
          along_u(above[1] - above[0]),
          along_v(below[0] - above[0]),
          twist(below[1] - below[0] - along_u) {}
    float x(float s, float t) const { return corner.x() + s * along_u.x() + t * (along_v.x() + s * twist.x()); }
    float y(float s, float t) const { return corner.y() + s * along_u.y() + t * (along_v.y() + s * twist.y()); }
    /// The largest distance of a point from the centre, in a square whose edge is this part of the cell's edge. [m]
    float reach(float part) const {
      constexpr float rounding = 1e-6F;  // [m]
      return (along_u.norm() + along_v.norm() + 2.0F * twist.norm()) * 0.5F * part + rounding;
    }
    Eigen::Vector2f corner, along_u, along_v, twist;
  };

  /// What the samples of a row's pixels add up to.
  struct Sums {
    std::array<float, cell> grey;
    std::array<float, cell> cover;
  };

  template <int samples, typename Shader>
  void paint_cell(Canvas& canvas, const Box& area, const Patch& patch, Shader& shader) const {
    constexpr bool may_be_even = requires { shader.even(0.0F, 0.0F, 0.0F); };
    // With few samples, the question takes as long as the samples.
    constexpr bool ask_each_pixel = may_be_even && samples > 4;
    Sums sums;
    const auto fill = [&sums](const Shade& shade, std::size_t from, std::size_t end) {
      float grey = 0.0F, cover = 0.0F;
      for (int k = 0; k < samples; ++k) {
        grey += shade.cover * shade.grey;
        cover += shade.cover;
      }
      std::fill(sums.grey.begin() + from, sums.grey.begin() + end, grey);
      std::fill(sums.cover.begin() + from, sums.cover.begin() + end, cover);
    };
    if constexpr (may_be_even) {
      if (const auto shade = shader.even(patch.x(0.5F, 0.5F), patch.y(0.5F, 0.5F), patch.reach(1.0F))) {
        if (shade->cover == 0.0F) return;
        fill(*shade, 0, cell);
        for (int v = area.top; v < area.bottom; ++v) lay<samples>(sums, area, v, canvas);
        return;
      }
    }
    [[maybe_unused]] const float reach = patch.reach(1.0F / cell);
    constexpr int pixels = samples == 1 ? cell : 1;  // at a time, for the compiler's vector instructions
    for (int v = area.top; v < area.bottom; ++v) {
      for (int u = 0; u < area.right - area.left; u += pixels) {
        if constexpr (ask_each_pixel) {
          const float s = (static_cast<float>(u) + 0.5F) / cell;
          const float t = (static_cast<float>(v - area.top) + 0.5F) / cell;
          if (const auto shade = shader.even(patch.x(s, t), patch.y(s, t), reach)) {
            const auto pixel = static_cast<std::size_t>(u);
            fill(*shade, pixel, pixel + 1);
            continue;
          }
        }
        sample<samples, pixels>(patch, u, v - area.top, shader, sums);
      }
      lay<samples>(sums, area, v, canvas);
    }
  }

  /// `pixels` of a cell from (u, v) on.
  template <int samples, int pixels, typename Shader>
  static void sample(const Patch& patch, int u, int v, Shader& shader, Sums& sums) {
    static constexpr auto places = sample_places<samples>();
    constexpr std::size_t points = pixels * samples;
    Points<points> at;
    Shades<points> shades;
    for (std::size_t i = 0; i < points; ++i) {
      const float s = (static_cast<float>(u + static_cast<int>(i / samples)) + 0.5F + places[i % samples][0]) / cell;
      const float t = (static_cast<float>(v) + 0.5F + places[i % samples][1]) / cell;
      at.x[i] = patch.x(s, t);
      at.y[i] = patch.y(s, t);
    }
    if constexpr (requires { shader(at, shades); }) {
      shader(at, shades);
    } else {
      for (std::size_t i = 0; i < points; ++i) {
        const Shade shade = shader(at.x[i], at.y[i]);
        shades.grey[i] = shade.grey;
        shades.cover[i] = shade.cover;
      }
    }
    for (std::size_t i = 0; i < pixels; ++i) {
      float grey_sum = 0.0F, cover_sum = 0.0F;
      for (std::size_t k = 0; k < samples; ++k) {
        grey_sum += shades.cover[i * samples + k] * shades.grey[i * samples + k];
        cover_sum += shades.cover[i * samples + k];
      }
      sums.grey[static_cast<std::size_t>(u) + i] = grey_sum;
      sums.cover[static_cast<std::size_t>(u) + i] = cover_sum;
    }
  }

  template <int samples>
  void lay(const Sums& sums, const Box& area, int v, Canvas& canvas) const {
    float* row = canvas.row(v) + area.left;
    const Light light = light_;
    for (int i = 0; i < area.right - area.left; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const float in_light = light(static_cast<float>(area.left + i), static_cast<float>(v)) * sums.grey[k];
      row[i] += (in_light - sums.cover[k] * row[i]) / samples;
    }
  }

  Calibration calibration_;
  Light light_;
  std::vector<Eigen::Vector2f> nodes_;
};

/// A Gaussian blur of part of a picture; beyond the picture's edge the last pixel is repeated.
class Blur {
 public:
  explicit Blur(double sigma_px);
  /// Pixels around a place that its blurred value depends on.
  int reach() const { return static_cast<int>(weights_.size()) - 1; }
  /// Blurs the box of `from`, rounded to whole grey levels, into the same place of `to` (rows of from.width bytes).
  void apply(const Canvas& from, const Box& box, std::uint8_t* to);

 private:
  /// to[i] = the weighted sum of middle[i - reach * step] .. middle[i + reach * step], for i = 0 .. width - 1.
  void weigh(const float* middle, std::ptrdiff_t step, int width, float* to) const;

  std::vector<float> weights_;  // from the middle outwards
  std::vector<float> padded_;   // one row of the box and what it depends on at both ends
  std::vector<float> across_;   // the rows of the box blurred along u
  std::vector<float> down_;     // one of them blurred along v
};

}  // namespace skein::vision::detail
