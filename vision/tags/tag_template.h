#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>

#include "vision/tags/tag_pattern.h"

namespace skein::vision::detail {

/// The points at which a tag is sampled: a square lattice in the tag's own frame, x along its heading, y to the left,
/// in modules (eighths of the black square), the same for all tags. It reaches into the white border, but not to its
/// edge, whose other side is unknown; its pitch is no simple fraction of a module, so that points meet edges at every
/// phase. In arrays over the lattice, each row fills whole vectors.
struct SampleGrid {
  static constexpr int side = 22;
  static constexpr std::size_t points = side * side;
  static constexpr std::size_t across = (side + 7) / 8 * 8;  // of a row: the last few weigh nothing
  static constexpr std::size_t count = across * side;
  static constexpr float reach = 4.6F;
  static constexpr float pitch = 2.0F * reach / (side - 1);

  alignas(32) std::array<float, across> x{};       // of each column
  alignas(32) std::array<float, across> weight{};  // 1, 0 for the columns that only fill up the last vector
  alignas(32) std::array<float, across> y{};       // of each row

  constexpr SampleGrid() {
    for (std::size_t i = 0; i < side; ++i) {
      x[i] = y[i] = static_cast<float>(i) * pitch - reach;
      weight[i] = 1.0F;
    }
  }

  /// Of a point, row by row, its coordinates and its place in an array.
  constexpr float x_of(std::size_t point) const { return x[point % side]; }
  constexpr float y_of(std::size_t point) const { return y[point / side]; }
  static constexpr std::size_t place_of(std::size_t point) { return point / side * across + point % side; }
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

/// What a tag looks like at the points of the grid, blurred, and all parts of a fit that can be computed in advance.
/// The picture is taken for
///
///     I = gain (T - grad T . (dx, dy) - (x T_y - y T_x) dtheta) + offset + (a x + b y) (T + ink),
///
/// which is linear in (gain dx, gain dy, gain dtheta, gain, offset, a, b): one step of Gauss and Newton is one product
/// with a matrix that is known beforehand (inverse compositional). a and b are the light's gradient, without which
/// a tag half in a lamp's cone, or in one row's light and the next's, is shifted. Two more columns blur it along its
/// axes: focus and motion differ from what the template was made for, but move no edge. Tone, T (1 - T), bends the
/// curve of the grey levels: a camera's gamma, overexposure, or ink that spreads makes edges brighter or darker than
/// the mean of both sides, all around. The last three let the tag stretch and shear, too: a tag on a robot does not,
/// one that is held up or tilted does.
struct alignas(64) TagTemplate {
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
    blur_x,
    blur_y,
    tone,
    stretch_x,
    stretch_y,
    shear
  };
  static constexpr int rigid_columns = 7;
  static constexpr int optical_columns = 10;
  static constexpr int columns = 13;
  static constexpr float ink = 0.15F;  // what ink reflects, as a part of the difference between paper and ink
  using Rigid = Eigen::Matrix<double, rigid_columns, rigid_columns>;
  using Optical = Eigen::Matrix<double, optical_columns, optical_columns>;
  using Full = Eigen::Matrix<double, columns, columns>;

  /// The columns of blur are the template blurred so many times as much less the template itself, scaled as its second
  /// derivative along the axis (which is twice its derivative by the blur's variance). An infinitesimal step would
  /// leave a large part of a real one, such as motion's, in the residual.
  static constexpr double blur_step = 1.5;

  /// Whole numbers of a unit, a power of two: less than half the memory of floats, which every frame has to load into
  /// the caches.
  using Numbers = std::array<std::int16_t, SampleGrid::count>;
  using SmallNumbers = std::array<std::int8_t, SampleGrid::count>;
  alignas(32) Numbers t{};    // 0 ink, 1 paper
  alignas(32) Numbers t_x{};  // per module
  alignas(32) Numbers t_y{};
  alignas(32) SmallNumbers t_xx{};  // of blur along x, per module^2
  alignas(32) SmallNumbers t_yy{};
  static constexpr float paper_unit = 1.0F / 16384.0F;                // of t
  float slope_unit = 1.0F;                                            // of t_x and t_y
  float bend_unit = 1.0F;                                             // of t_xx and t_yy
  std::array<double, rigid_columns * rigid_columns> rigid_inverse{};  // of the normal matrix of the first seven columns
  std::array<float, columns * columns> full_inverse{};                // of all of them
  float full(Eigen::Index row, Eigen::Index column) const {
    return full_inverse[static_cast<std::size_t>(row * columns + column)];
  }

  /// The first three rows of the inverse of the normal matrix of the first ten columns: times the sums, the step of a
  /// fit in which the tag is free to blur and to change its tone; times the noise, that step's covariance. Points lie
  /// further apart than a sharp edge is wide. In a picture softer or sharper than the template, the first seven columns
  /// take the difference at the few points that are near edges for a step, which the noise does not explain.
  using LastStep = Eigen::Matrix<float, 3, optical_columns>;
  LastStep last_step;
  static LastStep last_step_of(const Full& normal);

  /// Blocks of the grid: three rows high, four points wide (the last two). The pose depends on the sums over a block of
  /// residual times column: multiplied by this, their squares add up to the noise's variance (see felt_noise).
  struct Blocks {
    static constexpr int bands = 7;
    static constexpr int first_row(int band) { return band * SampleGrid::side / bands; }
    static constexpr int across = 6;
    static constexpr int of_column(int column) { return column / 4; }
  };
  std::array<float, 6> whitening{};  // an upper triangle, row by row

  /// The normal matrix itself, for fits that leave points out.
  Full normal;

  /// The value of every column at a point.
  Eigen::Matrix<double, columns, 1> row(std::size_t point) const;
};

}  // namespace skein::vision::detail
