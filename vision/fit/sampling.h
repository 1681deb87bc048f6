#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "vision/fit/plane_map.h"
#include "vision/tags/tag_template.h"

namespace skein::vision::detail {

/// The instructions that the two loops over a tag's points are made of. Both do the same operations in the same order,
/// without fused multiplications: their results agree to the last bit.
enum class Instructions {
  baseline,  // what every x86-64 has
  avx2,
};

/// The best that this machine supports. SKEIN_BASELINE=1 in the environment restricts it to the baseline.
Instructions best_instructions();

/// Image positions of the grid's points, relative to a corner that keeps the numbers small. [px]
struct Places {
  alignas(32) std::array<float, SampleGrid::count> u;
  alignas(32) std::array<float, SampleGrid::count> v;
};

/// The polynomials of a LocalMap in the tag's own frame (modules), their constants counted from the corner. Places are
/// clamped to between 0 and these: whatever a polynomial yields far from its centre, nothing is read outside the
/// picture.
struct FloatMap {
  std::array<float, LocalMap::terms> u;
  std::array<float, LocalMap::terms> v;
  float most_u;
  float most_v;
};

/// The result of one look at the picture: sums over the points of grey level times column, in the order of
/// TagTemplate's columns, and of the grey levels' squares.
struct Sums {
  static constexpr std::size_t square = TagTemplate::columns;
  static constexpr std::size_t count = TagTemplate::columns + 1;
  std::array<double, count> sum{};
};

/// Grey levels at the points, 128 less than in the picture: the sums lose fewer digits.
using Values = std::array<float, SampleGrid::count>;

/// `pixels`: the picture's byte at the corner; four bytes from every place, in its row and in the next, are read.
struct Patch {
  const std::uint8_t* pixels = nullptr;
  int stride = 0;
};

void place_points(Instructions instructions, const FloatMap& map, Places& places);
void look_at_points(Instructions instructions, const Patch& patch, const Places& places, const TagTemplate& tag,
                    Values& values, Sums& sums);

/// The effective variance of the noise for the pose, from the residuals of a solution of all columns: the sums of
/// residual times column over each of the template's blocks are taken to be independent. Noise that neighbouring points
/// share, and the edges of shadows and specks, count as much as they move the tag; what changes all points alike does
/// not count.
float felt_noise(Instructions instructions, const TagTemplate& tag, const Values& values,
                 const std::array<float, TagTemplate::columns>& solution);

}  // namespace skein::vision::detail
