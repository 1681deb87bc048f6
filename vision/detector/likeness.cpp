#include "vision/detector/likeness.h"

#include <cmath>

#include "vision/frames/grey_at.h"
#include "vision/tags/tag_template.h"

namespace skein::vision::detail {
namespace {

/// From the unit square (a, b) to the picture, (0, 0) to corner 0 and on in AprilTag's order: the projective map in
/// closed form (Heckbert, 1989).
class SquareMap {
 public:
  explicit SquareMap(const Corners& c) : u0_(c[0][0]), v0_(c[0][1]) {
    const double du1 = c[1][0] - c[2][0];
    const double du2 = c[3][0] - c[2][0];
    const double dv1 = c[1][1] - c[2][1];
    const double dv2 = c[3][1] - c[2][1];
    const double su = c[0][0] - c[1][0] + c[2][0] - c[3][0];
    const double sv = c[0][1] - c[1][1] + c[2][1] - c[3][1];
    const double area = du1 * dv2 - du2 * dv1;
    g_ = (su * dv2 - du2 * sv) / area;
    h_ = (du1 * sv - su * dv1) / area;
    ua_ = c[1][0] - c[0][0] + g_ * c[1][0];
    ub_ = c[3][0] - c[0][0] + h_ * c[3][0];
    va_ = c[1][1] - c[0][1] + g_ * c[1][1];
    vb_ = c[3][1] - c[0][1] + h_ * c[3][1];
  }
  std::array<double, 2> operator()(double a, double b) const {
    const double w = g_ * a + h_ * b + 1.0;
    return {(ua_ * a + ub_ * b + u0_) / w, (va_ * a + vb_ * b + v0_) / w};
  }

 private:
  double u0_, v0_, g_, h_, ua_, ub_, va_, vb_;
};

}  // namespace

double module_px(const Corners& c) {
  const double twice_area = (c[2][0] - c[0][0]) * (c[3][1] - c[1][1]) - (c[2][1] - c[0][1]) * (c[3][0] - c[1][0]);
  return std::sqrt(0.5 * std::abs(twice_area)) / 8.0;
}

double likeness(const Frame& frame, const Corners& corners, const TagPattern& pattern) {
  const SquareMap map(corners);
  const auto wanted = blurred_pattern(pattern, sharp_sigma_px / std::max(module_px(corners), 0.5));
  double n = 0.0, seen = 0.0, seen2 = 0.0, like = 0.0, like2 = 0.0, both = 0.0;
  for (std::size_t i = 0; i < SampleGrid::points; ++i) {
    const auto [u, v] =
        map(0.5 + static_cast<double>(sample_grid.x_of(i)) / 8.0, 0.5 + static_cast<double>(sample_grid.y_of(i)) / 8.0);
    const auto grey = grey_at(frame, u, v);
    if (!grey) continue;
    const auto tag = static_cast<double>(wanted[i]);
    n += 1.0;
    seen += *grey;
    seen2 += *grey * *grey;
    like += tag;
    like2 += tag * tag;
    both += *grey * tag;
  }
  // More than a third outside: no conclusion is possible.
  if (n < 0.67 * static_cast<double>(SampleGrid::points)) return 0.0;
  const double scatter = (seen2 - seen * seen / n) * (like2 - like * like / n);
  return scatter > 1e-9 ? (both - seen * like / n) / std::sqrt(scatter) : 0.0;
}

}  // namespace skein::vision::detail
