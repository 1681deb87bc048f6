#include "core/reference/platoon.h"

#include <algorithm>
#include <cmath>

#include "core/reference/blend.h"

namespace skein::core {

Platoon::Gap Platoon::gap(double t) const noexcept {
  double spacing = spacing_;
  for (const SpacingChange& change : changes_) {
    if (t <= change.t) break;
    if (t < change.t + change.duration) {
      const Blend done = blend(t - change.t, change.duration);
      const double more = change.spacing - spacing;
      return {spacing + done.share * more, done.rate * more};
    }
    spacing = change.spacing;
  }
  return {spacing, 0.0};
}

ReferencePoint Platoon::at(std::size_t i, double t) const noexcept {
  const Gap now = gap(t);
  const auto behind = static_cast<double>(i);
  const PathPoint point = path_->at(start_ - behind * now.spacing + speed_ * t);
  const double v = speed_ - behind * now.rate;
  return {point.pose, {v, v * point.curvature}};
}

ReferenceDemand Platoon::demand(double k_y) const noexcept {
  double v = std::abs(speed_), spacing = spacing_;
  const double last = static_cast<double>(std::max<std::size_t>(robots_, 1) - 1);
  for (const SpacingChange& change : changes_) {
    v = std::max(v, std::abs(speed_ - last * Blend::steepest * (change.spacing - spacing) / change.duration));
    spacing = change.spacing;
  }
  return {v, v * path_->largest_curvature() + k_y * v};
}

}  // namespace skein::core
