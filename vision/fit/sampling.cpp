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

using Tag = TagTemplate;
using Blocks = TagTemplate::Blocks;
// A whole number that stands for paper.
constexpr float all_paper = 1.0F / Tag::paper_unit;

using Solution = std::array<float, TagTemplate::columns>;

constexpr std::size_t rows = SampleGrid::side;
constexpr std::size_t row_parts = SampleGrid::across / lanes;

/// A solution, for columns that are counted in their units, and what it comes to in one row of the grid.
struct Line {
  float light, in_x, in_y;
};
struct Scaled {
  float light_x, light_y, constant, paper, ink, along_x, along_y, stretch_x, stretch_y, into_x, into_y, blur_x, blur_y,
      tone;

  Scaled(const TagTemplate& tag, const Solution& s)
      : light_x(s[Tag::light_x] * Tag::paper_unit),
        light_y(s[Tag::light_y] * Tag::paper_unit),
        constant(s[Tag::constant]),
        paper(s[Tag::paper] * Tag::paper_unit),
        ink(Tag::ink / Tag::paper_unit),
        along_x(s[Tag::along_x] * tag.slope_unit),
        along_y(s[Tag::along_y] * tag.slope_unit),
        stretch_x(s[Tag::stretch_x] * tag.slope_unit),
        stretch_y(s[Tag::stretch_y] * tag.slope_unit),
        into_x((s[Tag::shear] - s[Tag::turn]) * tag.slope_unit),
        into_y((s[Tag::turn] + s[Tag::shear]) * tag.slope_unit),
        blur_x(s[Tag::blur_x] * tag.bend_unit),
        blur_y(s[Tag::blur_y] * tag.bend_unit),
        tone(s[Tag::tone] * Tag::paper_unit * Tag::paper_unit) {}
  Line line(float y) const { return {light_y * y, along_x + into_x * y, along_y + stretch_y * y}; }
};

/// Sums over the points, of products that the columns are made of.
struct Parts {
  enum Part { x, y, paper, grey, x_x, x_y, y_x, y_y, lit_x, paper_y, grey_y, xx, yy, toned, square };
  static constexpr std::size_t count = 15;
  std::array<double, count> part{};

  void to_sums(const TagTemplate& tag, Sums& sums) const {
    const auto slope = static_cast<double>(tag.slope_unit);
    const auto bend = static_cast<double>(tag.bend_unit);
    constexpr auto unit = static_cast<double>(Tag::paper_unit);
    constexpr auto ink = static_cast<double>(Tag::ink);
    auto& sum = sums.sum;
    sum[Tag::along_x] = slope * part[x];
    sum[Tag::along_y] = slope * part[y];
    sum[Tag::turn] = slope * (part[y_x] - part[x_y]);
    sum[Tag::paper] = unit * part[paper];
    sum[Tag::constant] = part[grey];
    sum[Tag::light_x] = unit * part[lit_x];
    sum[Tag::light_y] = unit * part[paper_y] + ink * part[grey_y];
    sum[Tag::stretch_x] = slope * part[x_x];
    sum[Tag::stretch_y] = slope * part[y_y];
    sum[Tag::shear] = slope * (part[y_x] + part[x_y]);
    sum[Tag::blur_x] = bend * part[xx];
    sum[Tag::blur_y] = bend * part[yy];
    sum[Tag::tone] = unit * unit * part[toned];
    sum[Sums::square] = part[square];
  }
};

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

// ---------------------------------------------------------------------------------------------------------- baseline
// Blocks of eight in plain loops of fixed length, which the compiler turns into pairs of SSE instructions.

/// Between 0 and `most`; no number is 0, as for AVX2's max.
float hold(float place, float most) {
  const float from_zero = place > 0.0F ? place : 0.0F;
  return from_zero < most ? from_zero : most;
}

/// One coordinate. In a row of the grid, a cubic of x: a0 + y (a2 + y (a5 + y a9)) + x (a1 + y (a4 + y a8)) + ...
void place_baseline(const std::array<float, LocalMap::terms>& a, float most,
                    std::array<float, SampleGrid::count>& places) {
  for (std::size_t row = 0; row < rows; ++row) {
    const float y = sample_grid.y[row];
    const float b0 = a[0] + y * (a[2] + y * (a[5] + y * a[9]));
    const float b1 = a[1] + y * (a[4] + y * a[8]);
    const float b2 = a[3] + y * a[7];
    for (std::size_t k = 0; k < SampleGrid::across; ++k) {
      const float x = sample_grid.x[k];
      places[row * SampleGrid::across + k] = hold(b0 + x * (b1 + x * (b2 + x * a[6])), most);
    }
  }
}

void look_baseline(const Patch& patch, const Places& places, const TagTemplate& tag, Values& values, Sums& sums) {
  constexpr float ink = Tag::ink / Tag::paper_unit;
  alignas(32) float sum[Parts::count][lanes] = {};
  for (std::size_t row = 0; row < rows; ++row) {
    const float y = sample_grid.y[row];
    alignas(32) Lanes row_x = {}, row_y = {}, row_paper = {}, row_grey = {};
    for (std::size_t part = 0; part < row_parts; ++part) {
      const std::size_t block = row * SampleGrid::across + part * lanes;
      alignas(32) Lanes fu, fv, p00, p01, p10, p11;
      for (std::size_t k = 0; k < lanes; ++k) {
        const float u = places.u[block + k];
        const float v = places.v[block + k];
        const int at_u = static_cast<int>(u);
        const int at_v = static_cast<int>(v);
        fu[k] = u - static_cast<float>(at_u);
        fv[k] = v - static_cast<float>(at_v);
        const std::uint8_t* pixel = patch.pixels + (static_cast<std::ptrdiff_t>(at_v) * patch.stride + at_u);
        p00[k] = static_cast<float>(pixel[0]);
        p01[k] = static_cast<float>(pixel[1]);
        p10[k] = static_cast<float>(pixel[patch.stride]);
        p11[k] = static_cast<float>(pixel[patch.stride + 1]);
      }
      for (std::size_t k = 0; k < lanes; ++k) {
        const std::size_t i = block + k;
        const float x = sample_grid.x[part * lanes + k];
        const float top = p00[k] + fu[k] * (p01[k] - p00[k]);
        const float bottom = p10[k] + fu[k] * (p11[k] - p10[k]);
        const float grey = ((top + fv[k] * (bottom - top)) - 128.0F) * sample_grid.weight[part * lanes + k];
        values[i] = grey;
        const float gx = static_cast<float>(tag.t_x[i]) * grey;
        const float gy = static_cast<float>(tag.t_y[i]) * grey;
        const auto t = static_cast<float>(tag.t[i]);
        const float paper = t * grey;
        row_x[k] += gx;
        row_y[k] += gy;
        row_paper[k] += paper;
        row_grey[k] += grey;
        sum[Parts::x_x][k] += x * gx;
        sum[Parts::y_x][k] += x * gy;
        sum[Parts::lit_x][k] += x * (paper + ink * grey);
        sum[Parts::xx][k] += static_cast<float>(tag.t_xx[i]) * grey;
        sum[Parts::yy][k] += static_cast<float>(tag.t_yy[i]) * grey;
        sum[Parts::toned][k] += paper * (all_paper - t);
        sum[Parts::square][k] += grey * grey;
      }
    }
    for (std::size_t k = 0; k < lanes; ++k) {
      sum[Parts::x][k] += row_x[k];
      sum[Parts::y][k] += row_y[k];
      sum[Parts::paper][k] += row_paper[k];
      sum[Parts::grey][k] += row_grey[k];
      sum[Parts::x_y][k] += y * row_x[k];
      sum[Parts::y_y][k] += y * row_y[k];
      sum[Parts::paper_y][k] += y * row_paper[k];
      sum[Parts::grey_y][k] += y * row_grey[k];
    }
  }
  Parts parts;
  for (std::size_t i = 0; i < Parts::count; ++i) parts.part[i] = total_of(sum[i]);
  parts.to_sums(tag, sums);
}

float felt_baseline(const TagTemplate& tag, const Values& values, const Solution& solution) {
  const Scaled s(tag, solution);
  std::array<float, 6> w = tag.whitening;
  for (float& one : w) one *= tag.slope_unit;
  alignas(32) Lanes total = {};
  for (int band = 0; band < Blocks::bands; ++band) {
    alignas(32) float gx[row_parts][lanes] = {}, gy[row_parts][lanes] = {}, turn[row_parts][lanes] = {};
    for (int row = Blocks::first_row(band); row < Blocks::first_row(band + 1); ++row) {
      const auto first = static_cast<std::size_t>(row) * SampleGrid::across;
      const float y = sample_grid.y[static_cast<std::size_t>(row)];
      const Line at = s.line(y);
      for (std::size_t part = 0; part < row_parts; ++part) {
        for (std::size_t k = 0; k < lanes; ++k) {
          const std::size_t i = first + part * lanes + k;
          const float x = sample_grid.x[part * lanes + k];
          const auto t_x = static_cast<float>(tag.t_x[i]);
          const auto t_y = static_cast<float>(tag.t_y[i]);
          const float light = s.light_x * x + at.light;
          const float in_x = s.stretch_x * x + at.in_x;
          const float in_y = s.into_y * x + at.in_y;
          const auto t = static_cast<float>(tag.t[i]);
          const float toned = (s.paper + light) + s.tone * (all_paper - t);
          const float flat = (values[i] - (s.ink * light + s.constant)) - t * toned;
          const float moved = (flat - t_x * in_x) - t_y * in_y;
          const float left =
              (moved - static_cast<float>(tag.t_xx[i]) * s.blur_x) - static_cast<float>(tag.t_yy[i]) * s.blur_y;
          const float left_x = left * t_x;
          const float left_y = left * t_y;
          gx[part][k] += left_x;
          gy[part][k] += left_y;
          turn[part][k] += x * left_y - y * left_x;
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
SKEIN_AVX2 inline __m256 number(const TagTemplate::Numbers& numbers, std::size_t i) {
  return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_load_si128(reinterpret_cast<const __m128i*>(&numbers[i]))));
}
SKEIN_AVX2 inline __m256 number(const TagTemplate::SmallNumbers& numbers, std::size_t i) {
  return _mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&numbers[i]))));
}

SKEIN_AVX2 void place_avx2(const std::array<float, LocalMap::terms>& a, float most,
                           std::array<float, SampleGrid::count>& places) {
  alignas(32) std::array<float, SampleGrid::across> b0, b1, b2;
  for (std::size_t i = 0; i < SampleGrid::across; i += lanes) {
    const __m256 y = _mm256_load_ps(&sample_grid.y[i]);
    const __m256 to_y = add(_mm256_set1_ps(a[5]), mul(y, _mm256_set1_ps(a[9])));
    const __m256 by_y = add(_mm256_set1_ps(a[2]), mul(y, to_y));
    _mm256_store_ps(&b0[i], add(_mm256_set1_ps(a[0]), mul(y, by_y)));
    const __m256 by_xy = add(_mm256_set1_ps(a[4]), mul(y, _mm256_set1_ps(a[8])));
    _mm256_store_ps(&b1[i], add(_mm256_set1_ps(a[1]), mul(y, by_xy)));
    _mm256_store_ps(&b2[i], add(_mm256_set1_ps(a[3]), mul(y, _mm256_set1_ps(a[7]))));
  }
  const __m256 zero = _mm256_setzero_ps();
  const __m256 largest = _mm256_set1_ps(most);
  const __m256 b3 = _mm256_set1_ps(a[6]);
  for (std::size_t row = 0; row < rows; ++row) {
    const __m256 c0 = _mm256_set1_ps(b0[row]);
    const __m256 c1 = _mm256_set1_ps(b1[row]);
    const __m256 c2 = _mm256_set1_ps(b2[row]);
    for (std::size_t k = 0; k < SampleGrid::across; k += lanes) {
      const __m256 x = _mm256_load_ps(&sample_grid.x[k]);
      const __m256 at = add(c0, mul(x, add(c1, mul(x, add(c2, mul(x, b3))))));
      _mm256_store_ps(&places[row * SampleGrid::across + k], _mm256_min_ps(_mm256_max_ps(at, zero), largest));
    }
  }
}

SKEIN_AVX2 double total_of_vector(__m256 sum) {
  alignas(32) float lane[lanes];
  _mm256_store_ps(lane, sum);
  return total_of(lane);
}

SKEIN_AVX2 void look_avx2(const Patch& patch, const Places& places, const TagTemplate& tag, Values& values,
                          Sums& sums) {
  const __m256 zero = _mm256_setzero_ps();
  __m256 sum[Parts::count];
  for (__m256& s : sum) s = zero;
  const __m256i stride = _mm256_set1_epi32(patch.stride);
  const __m256i byte = _mm256_set1_epi32(0xff);
  const __m256 middle = _mm256_set1_ps(128.0F);
  const __m256 ink = _mm256_set1_ps(Tag::ink / Tag::paper_unit);
  const __m256 white_paper = _mm256_set1_ps(all_paper);
  const int* upper = reinterpret_cast<const int*>(patch.pixels);
  const int* lower = reinterpret_cast<const int*>(patch.pixels + patch.stride);
  for (std::size_t row = 0; row < rows; ++row) {
    __m256 row_x = zero, row_y = zero, row_paper = zero, row_grey = zero;
    for (std::size_t part = 0; part < SampleGrid::across; part += lanes) {
      const std::size_t i = row * SampleGrid::across + part;
      const __m256 u = _mm256_load_ps(&places.u[i]);
      const __m256 v = _mm256_load_ps(&places.v[i]);
      const __m256i at_u = _mm256_cvttps_epi32(u);
      const __m256i at_v = _mm256_cvttps_epi32(v);
      const __m256 fu = sub(u, _mm256_cvtepi32_ps(at_u));
      const __m256 fv = sub(v, _mm256_cvtepi32_ps(at_v));
      const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(at_v, stride), at_u);
      const __m256i two_above = _mm256_i32gather_epi32(upper, at, 1);
      const __m256i two_below = _mm256_i32gather_epi32(lower, at, 1);
      const __m256 p00 = _mm256_cvtepi32_ps(_mm256_and_si256(two_above, byte));
      const __m256 p01 = _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(two_above, 8), byte));
      const __m256 p10 = _mm256_cvtepi32_ps(_mm256_and_si256(two_below, byte));
      const __m256 p11 = _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(two_below, 8), byte));
      const __m256 top = add(p00, mul(fu, sub(p01, p00)));
      const __m256 bottom = add(p10, mul(fu, sub(p11, p10)));
      const __m256 weight = _mm256_load_ps(&sample_grid.weight[part]);
      const __m256 grey = mul(sub(add(top, mul(fv, sub(bottom, top))), middle), weight);
      _mm256_storeu_ps(&values[i], grey);
      const __m256 x = _mm256_load_ps(&sample_grid.x[part]);
      const __m256 gx = mul(number(tag.t_x, i), grey);
      const __m256 gy = mul(number(tag.t_y, i), grey);
      const __m256 t = number(tag.t, i);
      const __m256 paper = mul(t, grey);
      row_x = add(row_x, gx);
      row_y = add(row_y, gy);
      row_paper = add(row_paper, paper);
      row_grey = add(row_grey, grey);
      sum[Parts::x_x] = add(sum[Parts::x_x], mul(x, gx));
      sum[Parts::y_x] = add(sum[Parts::y_x], mul(x, gy));
      sum[Parts::lit_x] = add(sum[Parts::lit_x], mul(x, add(paper, mul(ink, grey))));
      sum[Parts::xx] = add(sum[Parts::xx], mul(number(tag.t_xx, i), grey));
      sum[Parts::yy] = add(sum[Parts::yy], mul(number(tag.t_yy, i), grey));
      sum[Parts::toned] = add(sum[Parts::toned], mul(paper, sub(white_paper, t)));
      sum[Parts::square] = add(sum[Parts::square], mul(grey, grey));
    }
    const __m256 y = _mm256_set1_ps(sample_grid.y[row]);
    sum[Parts::x] = add(sum[Parts::x], row_x);
    sum[Parts::y] = add(sum[Parts::y], row_y);
    sum[Parts::paper] = add(sum[Parts::paper], row_paper);
    sum[Parts::grey] = add(sum[Parts::grey], row_grey);
    sum[Parts::x_y] = add(sum[Parts::x_y], mul(y, row_x));
    sum[Parts::y_y] = add(sum[Parts::y_y], mul(y, row_y));
    sum[Parts::paper_y] = add(sum[Parts::paper_y], mul(y, row_paper));
    sum[Parts::grey_y] = add(sum[Parts::grey_y], mul(y, row_grey));
  }
  Parts parts;
  for (std::size_t i = 0; i < Parts::count; ++i) parts.part[i] = total_of_vector(sum[i]);
  parts.to_sums(tag, sums);
}

SKEIN_AVX2 float felt_avx2(const TagTemplate& tag, const Values& values, const Solution& solution) {
  const Scaled s(tag, solution);
  std::array<float, 6> w = tag.whitening;
  for (float& one : w) one *= tag.slope_unit;
  const __m256 light_x = _mm256_set1_ps(s.light_x);
  const __m256 stretch_x = _mm256_set1_ps(s.stretch_x);
  const __m256 into_y = _mm256_set1_ps(s.into_y);
  const __m256 constant = _mm256_set1_ps(s.constant);
  const __m256 gain = _mm256_set1_ps(s.paper);
  const __m256 blur_x = _mm256_set1_ps(s.blur_x);
  const __m256 blur_y = _mm256_set1_ps(s.blur_y);
  const __m256 ink = _mm256_set1_ps(s.ink);
  const __m256 tone = _mm256_set1_ps(s.tone);
  const __m256 white_paper = _mm256_set1_ps(all_paper);
  __m256 total = _mm256_setzero_ps();
  for (int band = 0; band < Blocks::bands; ++band) {
    __m256 gx[row_parts], gy[row_parts], turn[row_parts];
    for (std::size_t part = 0; part < row_parts; ++part) gx[part] = gy[part] = turn[part] = _mm256_setzero_ps();
    for (int row = Blocks::first_row(band); row < Blocks::first_row(band + 1); ++row) {
      const auto first = static_cast<std::size_t>(row) * SampleGrid::across;
      const float row_y = sample_grid.y[static_cast<std::size_t>(row)];
      const Line at = s.line(row_y);
      const __m256 y = _mm256_set1_ps(row_y);
      const __m256 line_light = _mm256_set1_ps(at.light);
      const __m256 line_in_x = _mm256_set1_ps(at.in_x);
      const __m256 line_in_y = _mm256_set1_ps(at.in_y);
      for (std::size_t part = 0; part < row_parts; ++part) {
        const std::size_t i = first + part * lanes;
        const __m256 x = _mm256_load_ps(&sample_grid.x[part * lanes]);
        const __m256 t_x = number(tag.t_x, i);
        const __m256 t_y = number(tag.t_y, i);
        const __m256 light = add(mul(light_x, x), line_light);
        const __m256 in_x = add(mul(stretch_x, x), line_in_x);
        const __m256 in_y = add(mul(into_y, x), line_in_y);
        const __m256 t = number(tag.t, i);
        const __m256 toned = add(add(gain, light), mul(tone, sub(white_paper, t)));
        const __m256 flat = sub(sub(_mm256_loadu_ps(&values[i]), add(mul(ink, light), constant)), mul(t, toned));
        const __m256 moved = sub(sub(flat, mul(t_x, in_x)), mul(t_y, in_y));
        const __m256 left = sub(sub(moved, mul(number(tag.t_xx, i), blur_x)), mul(number(tag.t_yy, i), blur_y));
        const __m256 left_x = mul(left, t_x);
        const __m256 left_y = mul(left, t_y);
        gx[part] = add(gx[part], left_x);
        gy[part] = add(gy[part], left_y);
        turn[part] = add(turn[part], sub(mul(x, left_y), mul(y, left_x)));
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

void place_points([[maybe_unused]] Instructions instructions, const FloatMap& map, Places& places) {
#if defined(__x86_64__)
  if (instructions == Instructions::avx2) {
    place_avx2(map.u, map.most_u, places.u);
    place_avx2(map.v, map.most_v, places.v);
    return;
  }
#endif
  place_baseline(map.u, map.most_u, places.u);
  place_baseline(map.v, map.most_v, places.v);
}

void look_at_points([[maybe_unused]] Instructions instructions, const Patch& patch, const Places& places,
                    const TagTemplate& tag, Values& values, Sums& sums) {
#if defined(__x86_64__)
  if (instructions == Instructions::avx2) return look_avx2(patch, places, tag, values, sums);
#endif
  look_baseline(patch, places, tag, values, sums);
}

float felt_noise([[maybe_unused]] Instructions instructions, const TagTemplate& tag, const Values& values,
                 const std::array<float, TagTemplate::columns>& solution) {
#if defined(__x86_64__)
  if (instructions == Instructions::avx2) return felt_avx2(tag, values, solution);
#endif
  return felt_baseline(tag, values, solution);
}

}  // namespace skein::vision::detail
