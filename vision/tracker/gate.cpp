#include "vision/tracker/gate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <numeric>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace skein::vision::detail {
namespace {

constexpr int cell = 4;  // edge of one [px]

// Of a cell's comparisons. Noise at the limit of what can be tracked (twice its sigma makes the threshold) reaches 5 %.
constexpr int busy_per_cent = 12;

// Of a square's cells: a tag may have an equal module with nothing but equal neighbours.
constexpr double filled = 0.92;

bool near(const Gate::Place& a, const Gate::Place& b, double distance) {
  return std::abs(a.u - b.u) < distance && std::abs(a.v - b.v) < distance &&
         std::hypot(a.u - b.u, a.v - b.v) < distance;
}

}  // namespace

Gate::Gate(int width, int height, double edge_px, Instructions instructions)
    : instructions_(instructions),
      step_(std::max(2, static_cast<int>(std::lround(edge_px / 8.0)))),
      row_step_(edge_px >= 28.0 ? 2 : 1),
      down_(step_ / row_step_ * row_step_),
      columns_(width >= 2 * step_ + cell ? width / cell : 0),
      rows_(height >= 2 * step_ + cell ? height / cell : 0),
      // What the paper covers whichever way it is turned and wherever the cells happen to lie.
      square_(std::max(2, static_cast<int>(1.2 * edge_px / std::numbers::sqrt2 / cell) - 1)),
      busy_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      across_(busy_.size()) {}

#if defined(__x86_64__)
#define SKEIN_GATE_AVX2 __attribute__((target("avx2")))

/// What the vector instructions need of a row of cells: the pixels that are compared, and what makes a cell busy.
struct CellRow {
  const Frame& frame;
  int top;        // its first row of pixels
  int step;       // to the pixel on the right that is compared
  int down;       // and to the one below
  int row_step;   // rows that are looked at
  int threshold;  // of a comparison
  int need;       // comparisons that make a cell busy
};

/// How many of a pixel's two comparisons, with its neighbour a step to the right and with the one a step below (to the
/// left and above where the picture ends), find more than the threshold: 16 pixels at once, four cells, which are
/// returned as four bytes.
inline std::uint32_t busy_of_four(const CellRow& row, int left) {
  const auto load = [](const std::uint8_t* from) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)); };
  const __m128i limit = _mm_set1_epi8(static_cast<char>(row.threshold));
  const __m128i one = _mm_set1_epi8(1);
  __m128i count = _mm_setzero_si128();
  for (int v = row.top; v < row.top + cell; v += row.row_step) {
    const std::uint8_t* const pixel = row.frame.row(v) + left;
    const __m128i here = load(pixel);
    for (const std::uint8_t* other : {pixel + row.step, row.frame.row(v + row.down) + left}) {
      const __m128i there = load(other);
      const __m128i apart = _mm_or_si128(_mm_subs_epu8(here, there), _mm_subs_epu8(there, here));
      count = _mm_add_epi8(count, _mm_min_epu8(_mm_subs_epu8(apart, limit), one));
    }
  }
  // Eight pixels make a sum of 64 bits; the even cells' become the lower half of such a lane, the odd ones' the upper.
  const __m128i even = _mm_set1_epi64x(0xffffffffLL);
  const __m128i zero = _mm_setzero_si128();
  const __m128i sums = _mm_or_si128(_mm_sad_epu8(_mm_and_si128(count, even), zero),
                                    _mm_slli_epi64(_mm_sad_epu8(_mm_andnot_si128(even, count), zero), 32));
  const __m128i words = _mm_packs_epi32(_mm_cmpgt_epi32(sums, _mm_set1_epi32(row.need - 1)), zero);
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_and_si128(_mm_packs_epi16(words, zero), one)));
}

/// The same with 32 pixels at once, for as many columns of cells as fit; the next one is returned.
SKEIN_GATE_AVX2 int busy_avx2(const CellRow& row, int columns, std::uint8_t* busy) {
  const __m256i limit = _mm256_set1_epi8(static_cast<char>(row.threshold));
  const __m256i one = _mm256_set1_epi8(1);
  const __m256i even = _mm256_set1_epi64x(0xffffffffLL);
  const __m256i zero = _mm256_setzero_si256();
  const __m256i least = _mm256_set1_epi32(row.need - 1);
  constexpr int cells = 8;
  int column = 0;
  for (; column + cells <= columns && (column + cells) * cell + row.step <= row.frame.width; column += cells) {
    __m256i count = zero;
    for (int v = row.top; v < row.top + cell; v += row.row_step) {
      const std::uint8_t* const pixel = row.frame.row(v) + column * cell;
      const __m256i here = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(pixel));
      for (const std::uint8_t* other : {pixel + row.step, row.frame.row(v + row.down) + column * cell}) {
        const __m256i there = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(other));
        const __m256i apart = _mm256_or_si256(_mm256_subs_epu8(here, there), _mm256_subs_epu8(there, here));
        count = _mm256_add_epi8(count, _mm256_min_epu8(_mm256_subs_epu8(apart, limit), one));
      }
    }
    const __m256i sums =
        _mm256_or_si256(_mm256_sad_epu8(_mm256_and_si256(count, even), zero),
                        _mm256_slli_epi64(_mm256_sad_epu8(_mm256_andnot_si256(even, count), zero), 32));
    const __m256i over = _mm256_cmpgt_epi32(sums, least);
    const __m128i words = _mm_packs_epi32(_mm256_castsi256_si128(over), _mm256_extracti128_si256(over, 1));
    const __m128i bytes = _mm_and_si128(_mm_packs_epi16(words, words), _mm_set1_epi8(1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(busy + column), bytes);
  }
  return column;
}
#endif

void Gate::count_busy(const Frame& frame, int first, int last, int threshold) {
  const int rows = cell / row_step_;
  const int need = cell * rows * 2 * busy_per_cent / 100;
  for (int r = first; r < last; ++r) {
    std::uint8_t* busy = busy_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    const int down = (r + 1) * cell + down_ <= frame.height ? down_ : -down_;
    int column = 0;
#if defined(__x86_64__)
    const CellRow row{frame, r * cell, step_, down, row_step_, threshold, need};
    if (instructions_ == Instructions::avx2) column = busy_avx2(row, columns_, busy);
    constexpr int cells = 4;
    for (; column + cells <= columns_ && (column + cells) * cell + step_ <= frame.width; column += cells) {
      const std::uint32_t four = busy_of_four(row, column * cell);
      std::memcpy(busy + column, &four, sizeof four);
    }
#endif
    for (; column < columns_; ++column) {
      const int across = (column + 1) * cell + step_ <= frame.width ? step_ : -step_;
      int sum = 0;
      for (int v = r * cell; v < (r + 1) * cell; v += row_step_) {
        const std::uint8_t* pixel = frame.row(v) + column * cell;
        const std::uint8_t* below = frame.row(v + down) + column * cell;
        for (int i = 0; i < cell; ++i) {
          sum += std::abs(pixel[i] - pixel[i + across]) > threshold ? 1 : 0;
          sum += std::abs(pixel[i] - below[i]) > threshold ? 1 : 0;
        }
      }
      busy[column] = sum >= need;
    }
  }
}

namespace {

/// Of every column, the busy cells among the next `square`, for `squares` columns.
void count_across(const std::uint8_t* busy, int square, int squares, std::uint8_t* across) {
  int column = 0;
#if defined(__x86_64__)
  constexpr int columns = 16;
  while (squares >= columns && column < squares) {
    column = std::min(column, squares - columns);
    __m128i sum = _mm_setzero_si128();
    for (int k = 0; k < square; ++k)
      sum = _mm_add_epi8(sum, _mm_loadu_si128(reinterpret_cast<const __m128i*>(busy + column + k)));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(across + column), sum);
    column += columns;
  }
#endif
  for (; column < squares; ++column)
    across[column] = static_cast<std::uint8_t>(std::accumulate(busy + column, busy + column + square, 0));
}

}  // namespace

void Gate::fetch(const Frame& frame, int first, int last, int part, int parts) const {
  constexpr int line = 64;  // of a cache [bytes]
  const int top = std::clamp(first, 0, rows_) * cell / row_step_;
  const int bottom = (std::clamp(last, 0, rows_) * cell + down_) / row_step_;
  const int end = std::min(top + (bottom - top) * (part + 1) / parts, (frame.height - 1) / row_step_ + 1);
  for (int row = top + (bottom - top) * part / parts; row < end; ++row) {
    const std::uint8_t* const pixels = frame.row(row * row_step_);
    for (int at = 0; at < frame.width; at += line) __builtin_prefetch(pixels + at, 0, 2);
  }
}

void Gate::scan(const Frame& frame, int first, int last, int threshold) {
  first = std::clamp(first, 0, rows_);
  last = std::clamp(last, first, rows_);
  count_busy(frame, first, last, std::clamp(threshold, 1, 254));
  for (int r = first; r < last; ++r) {
    const std::uint8_t* busy = busy_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    std::uint8_t* across = across_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    const int squares = columns_ - square_ + 1;
    if (squares > 0) count_across(busy, square_, squares, across);
  }
}

/// The next column from `c` on, before `end`, with at least so many busy cells; `end`: there is none.
int next_column(const std::uint8_t* across, int c, int end, int least) {
#if defined(__x86_64__)
  constexpr int columns = 16;
  const __m128i wanted = _mm_set1_epi8(static_cast<char>(least));
  for (; c + columns <= end; c += columns) {
    const __m128i here = _mm_loadu_si128(reinterpret_cast<const __m128i*>(across + c));
    const int found = _mm_movemask_epi8(_mm_cmpeq_epi8(_mm_max_epu8(here, wanted), here));
    if (found != 0) return c + std::countr_zero(static_cast<unsigned>(found));
  }
#endif
  while (c < end && across[c] < least) ++c;
  return c;
}

const std::vector<Gate::Place>& Gate::places(int first, int last, const std::vector<Known>& known, double apart) {
  marks_.clear();
  places_.clear();
  const int need = static_cast<int>(std::ceil(filled * square_ * square_ - 1e-9));
  // Or too much is missing in one row already.
  const int least_across = std::max(0, square_ - (square_ * square_ - need));
  const double middle = 0.5 * square_ * cell - 0.5;
  for (int r = std::max(0, first); r < std::min(last, rows_ - square_ + 1); ++r) {
    const std::uint8_t* across = across_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    const int end = columns_ - square_ + 1;
    for (int c = next_column(across, 0, end, least_across); c < end;
         c = next_column(across, c + 1, end, least_across)) {
      int sum = 0;
      for (int k = 0; k < square_; ++k) sum += across[c + k * columns_];
      if (sum < need) continue;
      // What is compared lies half a step to the right of where it is counted.
      const Place mark{c * cell + middle + 0.5 * step_, r * cell + middle};
      if (std::none_of(known.begin(), known.end(), [&](const Known& k) { return near(k.middle, mark, k.apart); }))
        marks_.push_back(mark);
    }
  }
  // A tag has several marks: their middle is its own. Two tags side by side are taken apart by the distance.
  while (!marks_.empty()) {
    Place place = marks_.front();
    for (int round = 0; round < 2; ++round) {
      Place sum;
      double count = 0.0;
      for (const Place& mark : marks_) {
        if (!near(mark, place, 0.8 * apart)) continue;
        sum.u += mark.u;
        sum.v += mark.v;
        count += 1.0;
      }
      if (count > 0.0) place = {sum.u / count, sum.v / count};
    }
    const Place seed = marks_.front();
    std::erase_if(marks_, [&](const Place& mark) { return near(mark, place, apart) || near(mark, seed, 1.0); });
    places_.push_back(place);
  }
  return places_;
}

}  // namespace skein::vision::detail
