#include "vision/tags/tag_template.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/math/small_matrix.h"

namespace skein::vision::detail {
namespace {

/// How much of each column of cells a blurred point sees, its derivative along the axis, and its change with blur.
struct Profile {
  std::array<double, pattern_cells> share{};
  std::array<double, pattern_cells> slope{};
  std::array<double, pattern_cells> bend{};
};

Profile profile_at(double place, double sigma) {
  const auto below = [&](double edge) {
    return 0.5 * (1.0 + std::erf((place - edge) / (sigma * std::numbers::sqrt2)));
  };
  const auto density = [&](double edge) {
    const double z = (place - edge) / sigma;
    return std::exp(-0.5 * z * z) / (sigma * std::sqrt(2.0 * std::numbers::pi));
  };
  const auto bend = [&](double edge) {
    const double z = (place - edge) / (sigma * std::numbers::sqrt2);
    constexpr double step = TagTemplate::blur_step;
    return (std::erf(z / step) - std::erf(z)) / ((step * step - 1.0) * sigma * sigma);
  };
  Profile profile;
  for (int i = 0; i < pattern_cells; ++i) {
    // The white border goes on outwards: the blur must not see an edge of the paper that the points keep away from.
    const double from = i - 0.5 * pattern_cells;
    const bool first = i == 0;
    const bool last = i == pattern_cells - 1;
    const auto k = static_cast<std::size_t>(i);
    profile.share[k] = (first ? 1.0 : below(from)) - (last ? 0.0 : below(from + 1.0));
    profile.slope[k] = (first ? 0.0 : density(from)) - (last ? 0.0 : density(from + 1.0));
    profile.bend[k] = (first ? 0.0 : bend(from)) - (last ? 0.0 : bend(from + 1.0));
  }
  return profile;
}

using Profiles = std::array<Profile, SampleGrid::side>;

Profiles profiles_at(double sigma) {
  Profiles profiles;
  for (std::size_t i = 0; i < SampleGrid::side; ++i)
    profiles[i] = profile_at(static_cast<double>(sample_grid.x[i]), sigma);
  return profiles;
}

using Levels = std::array<double, SampleGrid::points>;

/// The power of two of which all these levels are whole numbers, nearly, and none of them larger than `most`.
float unit_for(double most, const Levels& a, const Levels& b) {
  double largest = 1e-6;
  for (std::size_t i = 0; i < SampleGrid::points; ++i) largest = std::max({largest, std::abs(a[i]), std::abs(b[i])});
  return static_cast<float>(std::exp2(std::ceil(std::log2(largest / most))));
}

template <class Numbers>
void count_in(float unit, const Levels& levels, Numbers& numbers) {
  for (std::size_t i = 0; i < SampleGrid::points; ++i)
    numbers[SampleGrid::place_of(i)] =
        static_cast<typename Numbers::value_type>(std::lround(levels[i] / static_cast<double>(unit)));
}

}  // namespace

std::array<float, SampleGrid::points> blurred_pattern(const TagPattern& pattern, double sigma) {
  const Profiles profiles = profiles_at(sigma);
  std::array<std::array<double, pattern_cells>, SampleGrid::side> across{};  // per column of points, row of cells
  for (std::size_t i = 0; i < SampleGrid::side; ++i)
    for (std::size_t row = 0; row < pattern_cells; ++row)
      for (std::size_t column = 0; column < pattern_cells; ++column)
        if (pattern[row * pattern_cells + column]) across[i][row] += profiles[i].share[column];
  std::array<float, SampleGrid::points> blurred{};
  for (std::size_t point = 0; point < SampleGrid::points; ++point) {
    double value = 0.0;
    for (std::size_t row = 0; row < pattern_cells; ++row)  // counted downwards, y upwards
      value +=
          profiles[point / SampleGrid::side].share[pattern_cells - 1 - row] * across[point % SampleGrid::side][row];
    blurred[point] = static_cast<float>(value);
  }
  return blurred;
}

TagTemplate::TagTemplate(const TagPattern& pattern, double blur_sigma) : sigma(blur_sigma) {
  const Profiles profiles = profiles_at(sigma);
  Levels level, level_x, level_y, level_xx, level_yy;
  for (std::size_t point = 0; point < SampleGrid::points; ++point) {
    const Profile& across = profiles[point % SampleGrid::side];
    const Profile& up = profiles[point / SampleGrid::side];
    double value = 0.0;
    double value_x = 0.0;
    double value_y = 0.0;
    double value_xx = 0.0;
    double value_yy = 0.0;
    for (std::size_t row = 0; row < pattern_cells; ++row) {
      const std::size_t height = pattern_cells - 1 - row;  // rows are counted downwards, y upwards
      for (std::size_t column = 0; column < pattern_cells; ++column) {
        if (!pattern[row * pattern_cells + column]) continue;
        value += up.share[height] * across.share[column];
        value_x += up.share[height] * across.slope[column];
        value_y += up.slope[height] * across.share[column];
        value_xx += up.share[height] * across.bend[column];
        value_yy += up.bend[height] * across.share[column];
      }
    }
    level[point] = value;
    level_x[point] = value_x;
    level_y[point] = value_y;
    level_xx[point] = value_xx;
    level_yy[point] = value_yy;
  }
  slope_unit = unit_for(std::numeric_limits<Numbers::value_type>::max(), level_x, level_y);
  bend_unit = unit_for(std::numeric_limits<SmallNumbers::value_type>::max(), level_xx, level_yy);
  count_in(paper_unit, level, t);
  count_in(slope_unit, level_x, t_x);
  count_in(slope_unit, level_y, t_y);
  count_in(bend_unit, level_xx, t_xx);
  count_in(bend_unit, level_yy, t_yy);

  normal.setZero();
  for (std::size_t point = 0; point < SampleGrid::points; ++point) normal += row(point) * row(point).transpose();
  Rigid::Map(rigid_inverse.data()) = core::math::inverse(normal.topLeftCorner<rigid_columns, rigid_columns>());
  last_step = last_step_of(normal);
  const Full inverse = core::math::inverse(normal);
  Eigen::Matrix<float, columns, columns>::Map(full_inverse.data()) = inverse.cast<float>();

  // What a fit takes of the noise for changes of its columns is missing from the residual.
  std::array<Eigen::Matrix<double, columns, 3>, static_cast<std::size_t>(Blocks::bands * Blocks::across)> blocks;
  for (auto& block : blocks) block.setZero();
  for (int band = 0; band < Blocks::bands; ++band) {
    for (int line = Blocks::first_row(band); line < Blocks::first_row(band + 1); ++line) {
      for (int column = 0; column < SampleGrid::side; ++column) {
        const int point = line * SampleGrid::side + column;
        const int block = band * Blocks::across + Blocks::of_column(column);
        const auto values = row(static_cast<std::size_t>(point));
        blocks[static_cast<std::size_t>(block)] += values * values.head<3>().transpose();
      }
    }
  }
  const Eigen::Matrix3d of_step = last_step.leftCols<3>().cast<double>();
  double felt = 0.0;
  for (const auto& block : blocks)
    felt += (of_step * (block.topRows<3>() - block.transpose() * inverse * block)).trace();
  const Eigen::Matrix3d root = of_step.llt().matrixU().toDenseMatrix() / std::sqrt(felt);
  whitening = {static_cast<float>(root(0, 0)), static_cast<float>(root(0, 1)), static_cast<float>(root(0, 2)),
               static_cast<float>(root(1, 1)), static_cast<float>(root(1, 2)), static_cast<float>(root(2, 2))};
}

TagTemplate::LastStep TagTemplate::last_step_of(const Full& normal) {
  return core::math::inverse(normal.topLeftCorner<optical_columns, optical_columns>()).topRows<3>().cast<float>();
}

Eigen::Matrix<double, TagTemplate::columns, 1> TagTemplate::row(std::size_t point) const {
  const std::size_t place = SampleGrid::place_of(point);
  const auto value = [place](const auto& numbers, float unit) {
    return static_cast<double>(numbers[place]) * static_cast<double>(unit);
  };
  const auto x = static_cast<double>(sample_grid.x_of(point));
  const auto y = static_cast<double>(sample_grid.y_of(point));
  const double grey = value(t, paper_unit);
  const double tx = value(t_x, slope_unit);
  const double ty = value(t_y, slope_unit);
  Eigen::Matrix<double, columns, 1> result;
  const double lit = grey + static_cast<double>(ink);
  result << tx, ty, x * ty - y * tx, grey, 1.0, x * lit, y * lit, value(t_xx, bend_unit), value(t_yy, bend_unit),
      grey * (1.0 - grey), x * tx, y * ty, x * ty + y * tx;
  return result;
}

}  // namespace skein::vision::detail
