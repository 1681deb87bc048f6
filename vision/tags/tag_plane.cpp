#include "vision/tags/tag_plane.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace skein::vision {
namespace {

using Point = std::complex<double>;

/// Twice the area of a quadrilateral, by its diagonals.
double twice_area(const std::array<Point, 4>& p) {
  return std::abs(std::imag(std::conj(p[2] - p[0]) * (p[3] - p[1])));
}

}  // namespace

std::optional<TagOnPlane> place_on_plane(const Calibration& calibration, const Corners& corners) {
  std::array<Point, 4> seen;
  std::array<Point, 4> placed;
  for (std::size_t i = 0; i < 4; ++i) {
    seen[i] = {corners[i][0], corners[i][1]};
    const auto point = world_from_pixel(calibration, {corners[i][0], corners[i][1]}, calibration.tag_height);
    if (!point) return std::nullopt;
    placed[i] = {point->x(), point->y()};
  }

  // AprilTag's corners on a tag of edge 1 at the origin with heading 0, as complex numbers x + iy: turning and scaling
  // is one multiplication, and the least-squares square is   placed_i ~ centre + m model_i,   m = edge e^(i theta),
  //   centre = mean(placed),   m = sum(conj(model_i) (placed_i - centre)) / sum |model_i|^2.
  static constexpr Point model[4] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  const Point centre = (placed[0] + placed[1] + placed[2] + placed[3]) / 4.0;
  Point m = 0.0;
  for (std::size_t i = 0; i < 4; ++i) m += std::conj(model[i]) * (placed[i] - centre);
  m /= 2.0;  // sum |model_i|^2 = 4 * 1/2
  double misfit = 0.0;
  for (std::size_t i = 0; i < 4; ++i) misfit += std::norm(placed[i] - centre - m * model[i]);

  TagOnPlane tag;
  tag.pose = {centre.real(), centre.imag(), core::wrap_angle(std::arg(m))};
  tag.edge = std::abs(m);
  tag.misfit = std::sqrt(misfit / 4.0);
  tag.metres_per_px = std::sqrt(twice_area(placed) / twice_area(seen));
  if (!std::isfinite(tag.metres_per_px) || tag.edge <= 0.0) return std::nullopt;
  return tag;
}

Eigen::Vector2d middle_of(const Corners& corners) {
  Eigen::Vector2d middle(0.0, 0.0);
  for (const auto& corner : corners) middle += 0.25 * Eigen::Vector2d(corner[0], corner[1]);
  return middle;
}

double tag_edge_px(const Calibration& calibration) {
  const Eigen::Vector2d middle(0.5 * (calibration.width - 1), 0.5 * (calibration.height - 1));
  const auto centre = world_from_pixel(calibration, middle, calibration.tag_height);
  if (!centre) return 0.0;
  const double half = calibration.tag_size / 2.0;
  const auto left = pixel_from_world(calibration, {centre->x() - half, centre->y(), calibration.tag_height});
  const auto right = pixel_from_world(calibration, {centre->x() + half, centre->y(), calibration.tag_height});
  return left && right ? (*right - *left).norm() : 0.0;
}

PoseSigma pose_sigma(const TagOnPlane& tag, double corner_sigma) {
  // Eight coordinates less the fit's four parameters leave four degrees of freedom, over which 4 misfit^2 is spread:
  // misfit is itself an estimate of the noise of one coordinate. A crude one, but it knows of blur, glare and fingers
  // on the paper.
  const double sigma = std::max(corner_sigma * tag.metres_per_px, tag.misfit);
  // The mean of four corners halves the noise; the heading's lever is sqrt(sum |corner - centre|^2) = sqrt(2) edge.
  return {sigma / 2.0, sigma / (std::numbers::sqrt2 * tag.edge)};
}

}  // namespace skein::vision
