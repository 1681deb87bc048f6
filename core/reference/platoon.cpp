#include "core/reference/platoon.h"

namespace skein::core {

ReferencePoint Platoon::at(std::size_t i, double t) const noexcept {
  const PathPoint point = path_->at(start_ - static_cast<double>(i) * spacing_ + speed_ * t);
  return {point.pose, {speed_, speed_ * point.curvature}};
}

ReferenceDemand Platoon::demand(double k_y) const noexcept {
  const double v = std::abs(speed_);
  return {v, v * path_->largest_curvature() + k_y * v};
}

}  // namespace skein::core
