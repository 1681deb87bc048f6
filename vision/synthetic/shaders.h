#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/geometry/pose.h"
#include "vision/synthetic/painter.h"
#include "vision/tags/tag_pattern.h"

namespace skein::vision::detail {

/// Grey levels in full light.
inline constexpr float paper_grey = 225.0F;
inline constexpr float ink_grey = 30.0F;

/// A disc whose cover falls from full to none over `soft` [m] at its edge, or at once.
class DiscShader {
 public:
  DiscShader(double x, double y, double radius, double soft, Shade shade)
      : x_(static_cast<float>(x)),
        y_(static_cast<float>(y)),
        radius_(static_cast<float>(radius)),
        per_metre_(static_cast<float>(soft > 0.0 ? 1.0 / soft : 1e6)),
        shade_(shade) {}

  Shade operator()(float px, float py) const {
    return {shade_.grey, shade_.cover * std::clamp(inside(px, py) * per_metre_, 0.0F, 1.0F)};
  }
  std::optional<Shade> even(float px, float py, float reach) const {
    const float depth = inside(px, py);
    if ((depth - reach) * per_metre_ >= 1.0F) return shade_;
    if (depth + reach <= 0.0F) return Shade{};
    return {};
  }

 private:
  float inside(float px, float py) const { return radius_ - std::sqrt((px - x_) * (px - x_) + (py - y_) * (py - y_)); }
  float x_, y_, radius_, per_metre_;
  Shade shade_;
};

/// A rectangle of a length along `angle` and a width across it.
class StripShader {
 public:
  StripShader(double x, double y, double angle, double length, double width, Shade shade)
      : x_(static_cast<float>(x)),
        y_(static_cast<float>(y)),
        c_(static_cast<float>(std::cos(angle))),
        s_(static_cast<float>(std::sin(angle))),
        half_length_(static_cast<float>(length / 2.0)),
        half_width_(static_cast<float>(width / 2.0)),
        shade_(shade) {}

  Shade operator()(float px, float py) const {
    const auto [along, across] = place(px, py);
    return along >= -half_length_ && along < half_length_ && std::abs(across) < half_width_ ? shade_ : Shade{};
  }
  std::optional<Shade> even(float px, float py, float reach) const {
    const auto [along, across] = place(px, py);
    const float inside = std::min(half_length_ - std::abs(along), half_width_ - std::abs(across));
    if (inside > reach) return shade_;
    if (inside < -reach) return Shade{};
    return {};
  }

 private:
  struct Place {
    float along, across;  // [m]
  };
  Place place(float px, float py) const { return {c_ * (px - x_) + s_ * (py - y_), c_ * (py - y_) - s_ * (px - x_)}; }
  float x_, y_, c_, s_, half_length_, half_width_;
  Shade shade_;
};

/// A printed tag with its white border.
class TagShader {
 public:
  /// pattern: nullptr for blank paper.
  TagShader(const core::Pose& pose, double module, const TagPattern* pattern, float ink)
      : x_(static_cast<float>(pose.x)),
        y_(static_cast<float>(pose.y)),
        c_(static_cast<float>(std::cos(pose.theta) / module)),
        s_(static_cast<float>(std::sin(pose.theta) / module)),
        per_metre_(static_cast<float>(1.0 / module)) {
    for (std::size_t i = 0; i < grey_.size(); ++i) grey_[i] = pattern == nullptr || (*pattern)[i] ? paper_grey : ink;
  }

  Shade operator()(float px, float py) const {
    const int cell = cell_at(px, py);
    return cell < 0 ? Shade{} : Shade{grey_[static_cast<std::size_t>(cell)], 1.0F};
  }
  template <std::size_t count>
  void operator()(const Points<count>& at, Shades<count>& shades) const {
    std::array<int, count> cells;
    for (std::size_t i = 0; i < count; ++i) cells[i] = cell_at(at.x[i], at.y[i]);
    for (std::size_t i = 0; i < count; ++i) shades.cover[i] = cells[i] < 0 ? 0.0F : 1.0F;
    for (std::size_t i = 0; i < count; ++i) shades.grey[i] = grey_[static_cast<std::size_t>(std::max(cells[i], 0))];
  }
  std::optional<Shade> even(float px, float py, float reach) const {
    constexpr float rounding = 1e-3F;  // far more than floats of this size lose
    const auto [column, row] = place(px, py);
    const float around = reach * per_metre_ + rounding;
    const float left = column - around, right = column + around, top = row - around, bottom = row + around;
    if (right < 0.0F || left >= pattern_cells || bottom < 0.0F || top >= pattern_cells) return Shade{};
    if (!(left >= 0.0F && right < pattern_cells && top >= 0.0F && bottom < pattern_cells)) return {};
    const int first_u = static_cast<int>(left), first_v = static_cast<int>(top);
    const int last_u = static_cast<int>(right), last_v = static_cast<int>(bottom);
    const float first = grey(first_u, first_v);
    if (grey(last_u, first_v) != first || grey(first_u, last_v) != first || grey(last_u, last_v) != first) return {};
    if (last_u - first_u > 1 || last_v - first_v > 1)
      for (int v = first_v; v <= last_v; ++v)
        for (int u = first_u; u <= last_u; ++u)
          if (grey(u, v) != first) return {};
    return Shade{first, 1.0F};
  }

 private:
  struct Place {
    float column, row;  // in modules; rows downwards
  };
  Place place(float px, float py) const {
    return {0.5F * pattern_cells + c_ * (px - x_) + s_ * (py - y_),
            0.5F * pattern_cells + s_ * (px - x_) - c_ * (py - y_)};
  }
  /// -1: beside the tag.
  int cell_at(float px, float py) const {
    const auto [column, row] = place(px, py);
    const bool on_it = (column >= 0.0F) & (column < pattern_cells) & (row >= 0.0F) & (row < pattern_cells);
    const int cell = static_cast<int>(on_it ? row : 0.0F) * pattern_cells + static_cast<int>(on_it ? column : 0.0F);
    return on_it ? cell : -1;
  }
  float grey(int column, int row) const {
    return grey_[static_cast<std::size_t>(row) * pattern_cells + static_cast<std::size_t>(column)];
  }
  float x_, y_, c_, s_, per_metre_;
  std::array<float, pattern_cells * pattern_cells> grey_;
};

}  // namespace skein::vision::detail
