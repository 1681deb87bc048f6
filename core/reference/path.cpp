#include "core/reference/path.h"

#include "core/math/elementary.h"

namespace skein::core {
namespace {

/// The point at arc length s of a circle that is left counter-clockwise from the angle `from` (seen from its centre).
PathPoint on_arc(double centre_x, double centre_y, double radius, double from, double s) noexcept {
  const double angle = from + s / radius;
  return {{centre_x + radius * math::cos(angle), centre_y + radius * math::sin(angle), wrap_angle(angle + pi / 2.0)},
          1.0 / radius};
}

}  // namespace

double wrap_length(double s, double length) noexcept {
  const double wrapped = std::fmod(s, length);
  return wrapped < 0.0 ? wrapped + length : wrapped;
}

std::vector<Pose> sampled(const Path& path, std::size_t parts) {
  std::vector<Pose> poses;
  for (std::size_t k = 0; k <= parts; ++k)
    poses.push_back(path.at(path.length() * static_cast<double>(k) / static_cast<double>(parts)).pose);
  return poses;
}

RoundedRectangle::RoundedRectangle(double width, double height, double corner_radius) noexcept
    : width_(width),
      height_(height),
      radius_(corner_radius),
      horizontal_(width - 2.0 * corner_radius),
      vertical_(height - 2.0 * corner_radius),
      corner_(pi / 2.0 * corner_radius) {}

PathPoint RoundedRectangle::at(double s) const noexcept {
  s = wrap_length(s, length());
  // The second half of the lap is the first turned by 180 degrees.
  const double half = 0.5 * length();
  const bool second = s >= half;
  if (second) s -= half;

  const double x = 0.5 * width_;
  const double y = 0.5 * height_;
  PathPoint point;
  if (s < horizontal_) {
    point = {{-x + radius_ + s, -y, 0.0}, 0.0};
  } else if (s < horizontal_ + corner_) {
    point = on_arc(x - radius_, -y + radius_, radius_, -pi / 2.0, s - horizontal_);
  } else if (s < horizontal_ + corner_ + vertical_) {
    point = {{x, -y + radius_ + (s - horizontal_ - corner_), pi / 2.0}, 0.0};
  } else {
    point = on_arc(x - radius_, y - radius_, radius_, 0.0, s - horizontal_ - corner_ - vertical_);
  }
  if (second) point.pose = {-point.pose.x, -point.pose.y, wrap_angle(point.pose.theta + pi)};
  return point;
}

PathPoint Circle::at(double s) const noexcept {
  return on_arc(0.0, 0.0, radius_, 0.0, wrap_length(s, length()));
}

}  // namespace skein::core
