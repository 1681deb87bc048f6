#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>

#include "vision/tags/tag_pattern.h"

namespace skein::vision::detail {

/// Where a tag is looked at: a square lattice in the tag's own frame, x along its heading, y to the left, in modules
/// (eighths of the black square), the same for all tags. It reaches into the white border, but not to its edge, whose
/// other side is unknown; its pitch is no simple part of a module, so that edges are met at every phase.
struct SampleGrid {
  static constexpr int side = 22;
  static constexpr std::size_t points = side * side;
  static constexpr std::size_t count = (points + 7) / 8 * 8;  // whole vectors; the last few points weigh nothing
  static constexpr float reach = 4.6F;
  static constexpr float pitch = 2.0F * reach / (side - 1);

  alignas(32) std::array<float, count> x{};
  alignas(32) std::array<float, count> y{};
  alignas(32) std::array<float, count> weight{};  // 1, 0 for the points that only fill up the last vector

  constexpr SampleGrid() {
    for (std::size_t i = 0; i < points; ++i) {
      const std::size_t column = i % side, row = i / side;
      x[i] = static_cast<float>(column) * pitch - reach;
      y[i] = static_cast<float>(row) * pitch - reach;
      weight[i] = 1.0F;
    }
  }
};
inline constexpr SampleGrid sample_grid;

/// A lens in focus blurs by 0.7 px, the pixel's own area by 1/12 px^2 more, reading between pixels by 1/6 on average.
/// [px]
inline constexpr double sharp_sigma_px = 0.86;

/// How much two tags of 36h11, or one and the same turned by a quarter, correlate at most when they are blurred by
/// sigma modules: 0.83 at 0.18 and 0.90 at 0.4, over all pairs.
constexpr double likeness_of_others(double sigma) {
  return 0.83 + 0.33 * (sigma - 0.18);
}

/// A tag's ink (0) and paper (1) at the points of the grid, blurred by sigma [modules].
std::array<float, SampleGrid::points> blurred_pattern(const TagPattern& pattern, double sigma);

/// What a tag looks like at the points of the grid, blurred, and all that can be computed of a fit before a picture is
/// there. The picture is taken for
///
///     I = gain (T - grad T . (dx, dy) - (x T_y - y T_x) dtheta) + offset + (a x + b y) (T + ink),
///
/// which is linear in (gain dx, gain dy, gain dtheta, gain, offset, a, b): one step of Gauss and Newton is one product
/// with a matrix that is known beforehand (inverse compositional). a and b are the light's gradient, without which
/// a tag half in a lamp's cone, or in one row's light and the next's, is shifted. Three more columns let the tag
/// stretch and shear, too: no robot's tag does, one that is held up or tilted does. The last two blur it along its
/// axes: focus and motion differ from what the template was made for, but move no edge.
struct TagTemplate {
  /// blur_sigma: in modules.
  TagTemplate(const TagPattern& pattern, double blur_sigma);

  double sigma;  // of its blur [modules]

  enum Column {
    along_x,
    along_y,
    turn,
    paper,
    constant,
    light_x,
    light_y,
    stretch_x,
    stretch_y,
    shear,
    blur_x,
    blur_y
  };
  static constexpr int rigid_columns = 7;
  static constexpr int columns = 12;
  static constexpr float ink = 0.15F;  // what ink reflects, as a part of the difference between paper and ink
  using Rigid = Eigen::Matrix<double, rigid_columns, rigid_columns>;
  using Full = Eigen::Matrix<double, columns, columns>;

  alignas(32) std::array<float, SampleGrid::count> t{};    // 0 ink, 1 paper
  alignas(32) std::array<float, SampleGrid::count> t_x{};  // per module
  alignas(32) std::array<float, SampleGrid::count> t_y{};
  alignas(32) std::array<float, SampleGrid::count> t_xx{};
  alignas(32) std::array<float, SampleGrid::count> t_yy{};
  Rigid rigid_inverse;  // of the normal matrix of the first seven columns
  Full full_inverse;    // of all of them

  /// Blocks of the grid: three rows high, four points wide. The pose feels the sums over a block of residual times
  /// column: multiplied by this, their squares add up to the noise's variance (see felt_noise).
  struct Blocks {
    static constexpr int bands = 7;
    static constexpr int first_row(int band) { return band * SampleGrid::side / bands; }
    static constexpr int across = 6;
    static constexpr int of_column(int column) { return column < 16 ? column / 4 : column < 18 ? 4 : 5; }
  };
  std::array<float, 6> whitening{};  // an upper triangle, row by row

  /// The value of every column at a point.
  Eigen::Matrix<double, columns, 1> row(std::size_t point) const;
};

}  // namespace skein::vision::detail
