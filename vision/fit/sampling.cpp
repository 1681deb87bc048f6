#include "vision/fit/sampling.h"

#include <cstdlib>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace skein::vision::detail {
namespace {

constexpr std::size_t lanes = 8;
using Lanes = float[lanes];

// ---------------------------------------------------------------------------------------------------------- baseline
// Blocks of eight in plain loops of fixed length, which the compiler turns into pairs of SSE instructions.

using Tag = TagTemplate;
using Blocks = TagTemplate::Blocks;
using Solution = std::array<float, TagTemplate::columns>;

// A row of the grid in three vectors, the last of which begins with two points of the one before.
constexpr std::size_t row_parts = 3;
constexpr std::array<std::size_t, row_parts> part_start = {0, 8, SampleGrid::side - lanes};
alignas(32) constexpr float mask[row_parts][lanes] = {
    {1, 1, 1, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1, 1, 1}, {0, 0, 1, 1, 1, 1, 1, 1}};

/// What a solution comes to in one row of the grid.
struct Line {
  float y, light, in_x, in_y, turned;
};

Line line_of(const Solution& s, float y) {
  return {.y = y,
          .light = s[Tag::light_y] * y,
          .in_x = s[Tag::along_x] + (s[Tag::shear] - s[Tag::turn]) * y,
          .in_y = s[Tag::along_y] + s[Tag::stretch_y] * y,
          .turned = s[Tag::turn] + s[Tag::shear]};
}

double total_of(const Lanes& sum) {
  double total = 0.0;
  for (const float one : sum) total += static_cast<double>(one);
  return total;
}

/// Each block's square is there four times.
float sum_of_blocks(const Lanes& total) {
  float sum = 0.0F;
  for (const float one : total) sum += one;
  return 0.25F * sum;
}

/// Between 0 and `most`; no number is 0, as for AVX2's max.
float hold(float place, float most) {
  const float from_zero = place > 0.0F ? place : 0.0F;
  return from_zero < most ? from_zero : most;
}

void place_baseline(const FloatMap& map, const Turn& turn, Places& places) {
  for (std::size_t block = 0; block < SampleGrid::count; block += lanes) {
    for (std::size_t i = block; i < block + lanes; ++i) {
      const float x = sample_grid.x[i];
      const float y = sample_grid.y[i];
      const float X = (turn.c * x - turn.s * y) + turn.x0;
      const float Y = (turn.s * x + turn.c * y) + turn.y0;
      // a0 + X (a1 + X (a3 + X a6) + Y (a4 + X a7 + Y a8)) + Y (a2 + Y (a5 + Y a9))
      const auto cubic = [X, Y](const std::array<float, LocalMap::terms>& a) {
        const float in_x = (a[1] + X * (a[3] + X * a[6])) + Y * ((a[4] + X * a[7]) + Y * a[8]);
        const float in_y = a[2] + Y * (a[5] + Y * a[9]);
        return (a[0] + X * in_x) + Y * in_y;
      };
      places.u[i] = hold(cubic(map.u), map.most_u);
      places.v[i] = hold(cubic(map.v), map.most_v);
    }
  }
}

void look_baseline(const Patch& patch, const Places& places, const TagTemplate& tag, Values& values, Sums& sums) {
  alignas(32) float sum[Sums::count][lanes] = {};
  for (std::size_t block = 0; block < SampleGrid::count; block += lanes) {
    alignas(32) Lanes fu, fv, p00, p01, p10, p11;
    for (std::size_t k = 0; k < lanes; ++k) {
      const float u = places.u[block + k];
      const float v = places.v[block + k];
      const int column = static_cast<int>(u);
      const int row = static_cast<int>(v);
      fu[k] = u - static_cast<float>(column);
      fv[k] = v - static_cast<float>(row);
      const std::uint8_t* pixel = patch.pixels + (static_cast<std::ptrdiff_t>(row) * patch.stride + column);
      p00[k] = static_cast<float>(pixel[0]);
      p01[k] = static_cast<float>(pixel[1]);
      p10[k] = static_cast<float>(pixel[patch.stride]);
      p11[k] = static_cast<float>(pixel[patch.stride + 1]);
    }
    for (std::size_t k = 0; k < lanes; ++k) {
      const std::size_t i = block + k;
      const float top = p00[k] + fu[k] * (p01[k] - p00[k]);
      const float bottom = p10[k] + fu[k] * (p11[k] - p10[k]);
      const float grey = ((top + fv[k] * (bottom - top)) - 128.0F) * sample_grid.weight[i];
      const float gx = tag.t_x[i] * grey;
      const float gy = tag.t_y[i] * grey;
      values[i] = grey;
      const float paper = tag.t[i] * grey;
      const float lit = paper + TagTemplate::ink * grey;
      sum[Sums::along_x][k] += gx;
      sum[Sums::along_y][k] += gy;
      sum[Sums::turn][k] += sample_grid.x[i] * gy - sample_grid.y[i] * gx;
      sum[Sums::paper][k] += paper;
      sum[Sums::constant][k] += grey;
      sum[Sums::light_x][k] += sample_grid.x[i] * lit;
      sum[Sums::light_y][k] += sample_grid.y[i] * lit;
      sum[Sums::square][k] += grey * grey;
    }
  }
  for (std::size_t i = 0; i < Sums::count; ++i) sums.sum[i] = total_of(sum[i]);
}

void free_baseline(const TagTemplate& tag, const Values& values, FreeSums& sums) {
  alignas(32) float sum[FreeSums::count][lanes] = {};
  for (std::size_t block = 0; block < SampleGrid::count; block += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) {
      const std::size_t i = block + k;
      const float gx = tag.t_x[i] * values[i];
      const float gy = tag.t_y[i] * values[i];
      sum[FreeSums::stretch_x][k] += sample_grid.x[i] * gx;
      sum[FreeSums::stretch_y][k] += sample_grid.y[i] * gy;
      sum[FreeSums::shear][k] += sample_grid.x[i] * gy + sample_grid.y[i] * gx;
      sum[FreeSums::blur_x][k] += tag.t_xx[i] * values[i];
      sum[FreeSums::blur_y][k] += tag.t_yy[i] * values[i];
    }
  }
  for (std::size_t i = 0; i < FreeSums::count; ++i) sums.sum[i] = total_of(sum[i]);
}

float felt_baseline(const TagTemplate& tag, const Values& values, const Solution& s) {
  const std::array<float, 6>& w = tag.whitening;
  alignas(32) Lanes total = {};
  for (int band = 0; band < Blocks::bands; ++band) {
    alignas(32) float gx[row_parts][lanes] = {}, gy[row_parts][lanes] = {}, turn[row_parts][lanes] = {};
    for (int line = Blocks::first_row(band); line < Blocks::first_row(band + 1); ++line) {
      const auto first = static_cast<std::size_t>(line * SampleGrid::side);
      const Line at = line_of(s, sample_grid.y[first]);
      for (std::size_t part = 0; part < row_parts; ++part) {
        for (std::size_t k = 0; k < lanes; ++k) {
          const std::size_t i = first + part_start[part] + k;
          const float x = sample_grid.x[i];
          const float light = s[Tag::light_x] * x + at.light;
          const float in_x = s[Tag::stretch_x] * x + at.in_x;
          const float in_y = at.turned * x + at.in_y;
          const float flat = (values[i] - (tag.ink * light + s[Tag::constant])) - tag.t[i] * (s[Tag::paper] + light);
          const float moved = (flat - tag.t_x[i] * in_x) - tag.t_y[i] * in_y;
          const float left = ((moved - tag.t_xx[i] * s[Tag::blur_x]) - tag.t_yy[i] * s[Tag::blur_y]) * mask[part][k];
          const float left_x = left * tag.t_x[i];
          const float left_y = left * tag.t_y[i];
          gx[part][k] += left_x;
          gy[part][k] += left_y;
          turn[part][k] += x * left_y - at.y * left_x;
        }
      }
    }
    for (std::size_t part = 0; part < row_parts; ++part) {
      alignas(32) Lanes white[3];
      for (std::size_t k = 0; k < lanes; ++k) {
        white[0][k] = (w[0] * gx[part][k] + w[1] * gy[part][k]) + w[2] * turn[part][k];
        white[1][k] = w[3] * gy[part][k] + w[4] * turn[part][k];
        white[2][k] = w[5] * turn[part][k];
      }
      for (const Lanes& each : white) {
        for (std::size_t k = 0; k < lanes; ++k) {
          const std::size_t other = k ^ 2U;
          const float block = (each[k] + each[k ^ 1U]) + (each[other] + each[other ^ 1U]);
          total[k] += block * block;
        }
      }
    }
  }
  return sum_of_blocks(total);
}

// -------------------------------------------------------------------------------------------------------------- AVX2

#if defined(__x86_64__)
#define SKEIN_AVX2 __attribute__((target("avx2")))

SKEIN_AVX2 inline __m256 mul(__m256 a, __m256 b) {
  return _mm256_mul_ps(a, b);
}
SKEIN_AVX2 inline __m256 add(__m256 a, __m256 b) {
  return _mm256_add_ps(a, b);
}
SKEIN_AVX2 inline __m256 sub(__m256 a, __m256 b) {
  return _mm256_sub_ps(a, b);
}

struct Coefficients {
  __m256 a[LocalMap::terms];
};

SKEIN_AVX2 inline Coefficients spread(const std::array<float, LocalMap::terms>& a) {
  Coefficients c;
  for (std::size_t i = 0; i < LocalMap::terms; ++i) c.a[i] = _mm256_set1_ps(a[i]);
  return c;
}

SKEIN_AVX2 inline __m256 cubic(const Coefficients& c, __m256 x, __m256 y) {
  const __m256* a = c.a;
  const __m256 in_x =
      add(add(a[1], mul(x, add(a[3], mul(x, a[6])))), mul(y, add(add(a[4], mul(x, a[7])), mul(y, a[8]))));
  const __m256 in_y = add(a[2], mul(y, add(a[5], mul(y, a[9]))));
  return add(add(a[0], mul(x, in_x)), mul(y, in_y));
}

SKEIN_AVX2 void place_avx2(const FloatMap& map, const Turn& turn, Places& places) {
  const Coefficients in_u = spread(map.u);
  const Coefficients in_v = spread(map.v);
  const __m256 c = _mm256_set1_ps(turn.c);
  const __m256 s = _mm256_set1_ps(turn.s);
  const __m256 x0 = _mm256_set1_ps(turn.x0);
  const __m256 y0 = _mm256_set1_ps(turn.y0);
  const __m256 zero = _mm256_setzero_ps();
  const __m256 most_u = _mm256_set1_ps(map.most_u);
  const __m256 most_v = _mm256_set1_ps(map.most_v);
  for (std::size_t i = 0; i < SampleGrid::count; i += lanes) {
    const __m256 x = _mm256_load_ps(&sample_grid.x[i]);
    const __m256 y = _mm256_load_ps(&sample_grid.y[i]);
    const __m256 X = add(sub(mul(c, x), mul(s, y)), x0);
    const __m256 Y = add(add(mul(s, x), mul(c, y)), y0);
    _mm256_store_ps(&places.u[i], _mm256_min_ps(_mm256_max_ps(cubic(in_u, X, Y), zero), most_u));
    _mm256_store_ps(&places.v[i], _mm256_min_ps(_mm256_max_ps(cubic(in_v, X, Y), zero), most_v));
  }
}

SKEIN_AVX2 double total_of_vector(__m256 sum) {
  alignas(32) float lane[lanes];
  _mm256_store_ps(lane, sum);
  return total_of(lane);
}

SKEIN_AVX2 void look_avx2(const Patch& patch, const Places& places, const TagTemplate& tag, Values& values,
                          Sums& sums) {
  __m256 sum[Sums::count];
  for (__m256& s : sum) s = _mm256_setzero_ps();
  const __m256i stride = _mm256_set1_epi32(patch.stride);
  const __m256i byte = _mm256_set1_epi32(0xff);
  const __m256 middle = _mm256_set1_ps(128.0F);
  const __m256 ink = _mm256_set1_ps(TagTemplate::ink);
  const int* upper = reinterpret_cast<const int*>(patch.pixels);
  const int* lower = reinterpret_cast<const int*>(patch.pixels + patch.stride);
  for (std::size_t i = 0; i < SampleGrid::count; i += lanes) {
    const __m256 u = _mm256_load_ps(&places.u[i]);
    const __m256 v = _mm256_load_ps(&places.v[i]);
    const __m256i column = _mm256_cvttps_epi32(u);
    const __m256i row = _mm256_cvttps_epi32(v);
    const __m256 fu = sub(u, _mm256_cvtepi32_ps(column));
    const __m256 fv = sub(v, _mm256_cvtepi32_ps(row));
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(row, stride), column);
    const __m256i two_above = _mm256_i32gather_epi32(upper, at, 1);
    const __m256i two_below = _mm256_i32gather_epi32(lower, at, 1);
    const __m256 p00 = _mm256_cvtepi32_ps(_mm256_and_si256(two_above, byte));
    const __m256 p01 = _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(two_above, 8), byte));
    const __m256 p10 = _mm256_cvtepi32_ps(_mm256_and_si256(two_below, byte));
    const __m256 p11 = _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(two_below, 8), byte));
    const __m256 top = add(p00, mul(fu, sub(p01, p00)));
    const __m256 bottom = add(p10, mul(fu, sub(p11, p10)));
    const __m256 weight = _mm256_load_ps(&sample_grid.weight[i]);
    const __m256 grey = mul(sub(add(top, mul(fv, sub(bottom, top))), middle), weight);
    const __m256 x = _mm256_load_ps(&sample_grid.x[i]);
    const __m256 y = _mm256_load_ps(&sample_grid.y[i]);
    const __m256 gx = mul(_mm256_load_ps(&tag.t_x[i]), grey);
    const __m256 gy = mul(_mm256_load_ps(&tag.t_y[i]), grey);
    _mm256_storeu_ps(&values[i], grey);
    const __m256 paper = mul(_mm256_load_ps(&tag.t[i]), grey);
    const __m256 lit = add(paper, mul(ink, grey));
    sum[Sums::along_x] = add(sum[Sums::along_x], gx);
    sum[Sums::along_y] = add(sum[Sums::along_y], gy);
    sum[Sums::turn] = add(sum[Sums::turn], sub(mul(x, gy), mul(y, gx)));
    sum[Sums::paper] = add(sum[Sums::paper], paper);
    sum[Sums::constant] = add(sum[Sums::constant], grey);
    sum[Sums::light_x] = add(sum[Sums::light_x], mul(x, lit));
    sum[Sums::light_y] = add(sum[Sums::light_y], mul(y, lit));
    sum[Sums::square] = add(sum[Sums::square], mul(grey, grey));
  }
  for (std::size_t i = 0; i < Sums::count; ++i) sums.sum[i] = total_of_vector(sum[i]);
}

SKEIN_AVX2 void free_avx2(const TagTemplate& tag, const Values& values, FreeSums& sums) {
  __m256 sum[FreeSums::count];
  for (__m256& s : sum) s = _mm256_setzero_ps();
  for (std::size_t i = 0; i < SampleGrid::count; i += lanes) {
    const __m256 grey = _mm256_loadu_ps(&values[i]);
    const __m256 x = _mm256_load_ps(&sample_grid.x[i]);
    const __m256 y = _mm256_load_ps(&sample_grid.y[i]);
    const __m256 gx = mul(_mm256_load_ps(&tag.t_x[i]), grey);
    const __m256 gy = mul(_mm256_load_ps(&tag.t_y[i]), grey);
    sum[FreeSums::stretch_x] = add(sum[FreeSums::stretch_x], mul(x, gx));
    sum[FreeSums::stretch_y] = add(sum[FreeSums::stretch_y], mul(y, gy));
    sum[FreeSums::shear] = add(sum[FreeSums::shear], add(mul(x, gy), mul(y, gx)));
    sum[FreeSums::blur_x] = add(sum[FreeSums::blur_x], mul(_mm256_load_ps(&tag.t_xx[i]), grey));
    sum[FreeSums::blur_y] = add(sum[FreeSums::blur_y], mul(_mm256_load_ps(&tag.t_yy[i]), grey));
  }
  for (std::size_t i = 0; i < FreeSums::count; ++i) sums.sum[i] = total_of_vector(sum[i]);
}

SKEIN_AVX2 float felt_avx2(const TagTemplate& tag, const Values& values, const Solution& s) {
  const std::array<float, 6>& w = tag.whitening;
  const __m256 light_x = _mm256_set1_ps(s[Tag::light_x]);
  const __m256 stretch_x = _mm256_set1_ps(s[Tag::stretch_x]);
  const __m256 constant = _mm256_set1_ps(s[Tag::constant]);
  const __m256 gain = _mm256_set1_ps(s[Tag::paper]);
  const __m256 blur_x = _mm256_set1_ps(s[Tag::blur_x]);
  const __m256 blur_y = _mm256_set1_ps(s[Tag::blur_y]);
  const __m256 ink = _mm256_set1_ps(tag.ink);
  __m256 total = _mm256_setzero_ps();
  for (int band = 0; band < Blocks::bands; ++band) {
    __m256 gx[row_parts], gy[row_parts], turn[row_parts];
    for (std::size_t part = 0; part < row_parts; ++part) gx[part] = gy[part] = turn[part] = _mm256_setzero_ps();
    for (int line = Blocks::first_row(band); line < Blocks::first_row(band + 1); ++line) {
      const auto first = static_cast<std::size_t>(line * SampleGrid::side);
      const Line at = line_of(s, sample_grid.y[first]);
      const __m256 line_y = _mm256_set1_ps(at.y);
      const __m256 line_light = _mm256_set1_ps(at.light);
      const __m256 line_in_x = _mm256_set1_ps(at.in_x);
      const __m256 line_in_y = _mm256_set1_ps(at.in_y);
      const __m256 turned = _mm256_set1_ps(at.turned);
      for (std::size_t part = 0; part < row_parts; ++part) {
        const std::size_t i = first + part_start[part];
        const __m256 x = _mm256_loadu_ps(&sample_grid.x[i]);
        const __m256 t_x = _mm256_loadu_ps(&tag.t_x[i]);
        const __m256 t_y = _mm256_loadu_ps(&tag.t_y[i]);
        const __m256 light = add(mul(light_x, x), line_light);
        const __m256 in_x = add(mul(stretch_x, x), line_in_x);
        const __m256 in_y = add(mul(turned, x), line_in_y);
        const __m256 flat = sub(sub(_mm256_loadu_ps(&values[i]), add(mul(ink, light), constant)),
                                mul(_mm256_loadu_ps(&tag.t[i]), add(gain, light)));
        const __m256 moved = sub(sub(flat, mul(t_x, in_x)), mul(t_y, in_y));
        const __m256 left =
            mul(sub(sub(moved, mul(_mm256_loadu_ps(&tag.t_xx[i]), blur_x)), mul(_mm256_loadu_ps(&tag.t_yy[i]), blur_y)),
                _mm256_load_ps(mask[part]));
        const __m256 left_x = mul(left, t_x);
        const __m256 left_y = mul(left, t_y);
        gx[part] = add(gx[part], left_x);
        gy[part] = add(gy[part], left_y);
        turn[part] = add(turn[part], sub(mul(x, left_y), mul(line_y, left_x)));
      }
    }
    for (std::size_t part = 0; part < row_parts; ++part) {
      const __m256 white[3] = {add(add(mul(_mm256_set1_ps(w[0]), gx[part]), mul(_mm256_set1_ps(w[1]), gy[part])),
                                   mul(_mm256_set1_ps(w[2]), turn[part])),
                               add(mul(_mm256_set1_ps(w[3]), gy[part]), mul(_mm256_set1_ps(w[4]), turn[part])),
                               mul(_mm256_set1_ps(w[5]), turn[part])};
      for (const __m256& each : white) {
        const __m256 pairs = add(each, _mm256_permute_ps(each, 0xB1));
        const __m256 block = add(pairs, _mm256_permute_ps(pairs, 0x4E));
        total = add(total, mul(block, block));
      }
    }
  }
  alignas(32) float lane[lanes];
  _mm256_store_ps(lane, total);
  return sum_of_blocks(lane);
}

#endif

}  // namespace

Instructions best_instructions() {
#if defined(__x86_64__)
  const char* held = std::getenv("SKEIN_BASELINE");
  const bool hold = held != nullptr && std::strcmp(held, "1") == 0;
  if (!hold && __builtin_cpu_supports("avx2")) return Instructions::avx2;
#endif
  return Instructions::baseline;
}

void place_points(Instructions instructions, const FloatMap& map, const Turn& turn, Places& places) {
#if defined(__x86_64__)
  if (instructions == Instructions::avx2) return place_avx2(map, turn, places);
#endif
  place_baseline(map, turn, places);
}

void look_at_points(Instructions instructions, const Patch& patch, const Places& places, const TagTemplate& tag,
                    Values& values, Sums& sums) {
#if defined(__x86_64__)
  if (instructions == Instructions::avx2) return look_avx2(patch, places, tag, values, sums);
#endif
  look_baseline(patch, places, tag, values, sums);
}

void sum_free_columns(Instructions instructions, const TagTemplate& tag, const Values& values, FreeSums& sums) {
#if defined(__x86_64__)
  if (instructions == Instructions::avx2) return free_avx2(tag, values, sums);
#endif
  free_baseline(tag, values, sums);
}

float felt_noise(Instructions instructions, const TagTemplate& tag, const Values& values,
                 const std::array<float, TagTemplate::columns>& solution) {
#if defined(__x86_64__)
  if (instructions == Instructions::avx2) return felt_avx2(tag, values, solution);
#endif
  return felt_baseline(tag, values, solution);
}

}  // namespace skein::vision::detail
