#include "vision/tracker/gate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numbers>

#if defined(__x86_64__)
#include <emmintrin.h>
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

Gate::Gate(int width, int height, double edge_px)
    : step_(std::max(2, static_cast<int>(std::lround(edge_px / 8.0)))),
      row_step_(edge_px >= 28.0 ? 2 : 1),
      columns_(width >= 2 * step_ + cell ? width / cell : 0),
      rows_(height >= 2 * step_ + cell ? height / cell : 0),
      // What the paper covers whichever way it is turned and wherever the cells happen to lie.
      square_(std::max(2, static_cast<int>(1.2 * edge_px / std::numbers::sqrt2 / cell) - 1)),
      busy_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      across_(busy_.size()) {}

/// How many of a pixel's two comparisons, with its neighbour a step to the right and with the one a step below (to the
/// left and above where the picture ends), find more than the threshold: 16 pixels at once, added to `count`.
#if defined(__x86_64__)
__m128i add_busy(__m128i count, const std::uint8_t* pixel, const std::uint8_t* below, int step, __m128i threshold) {
  const auto load = [](const std::uint8_t* from) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)); };
  const __m128i here = load(pixel);
  const __m128i one = _mm_set1_epi8(1);
  for (const std::uint8_t* other : {pixel + step, below}) {
    const __m128i there = load(other);
    const __m128i apart = _mm_or_si128(_mm_subs_epu8(here, there), _mm_subs_epu8(there, here));
    count = _mm_add_epi8(count, _mm_min_epu8(_mm_subs_epu8(apart, threshold), one));
  }
  return count;
}
#endif

void Gate::count_busy(const Frame& frame, int first, int last, int threshold) {
  const int rows = cell / row_step_;
  const int need = cell * rows * 2 * busy_per_cent / 100;
  for (int r = first; r < last; ++r) {
    std::uint8_t* busy = busy_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    const int down = (r + 1) * cell + step_ <= frame.height ? step_ : -step_;
    int column = 0;
#if defined(__x86_64__)
    const __m128i limit = _mm_set1_epi8(static_cast<char>(threshold));
    const __m128i even = _mm_set1_epi64x(0xffffffffLL);  // of the cells
    for (; (column + 4) * cell + step_ <= frame.width; column += 4) {
      __m128i count = _mm_setzero_si128();
      for (int v = r * cell; v < (r + 1) * cell; v += row_step_) {
        count = add_busy(count, frame.row(v) + column * cell, frame.row(v + down) + column * cell, step_, limit);
      }
      const __m128i zero = _mm_setzero_si128();
      alignas(16) std::uint64_t sums[4];
      _mm_store_si128(reinterpret_cast<__m128i*>(sums), _mm_sad_epu8(_mm_and_si128(count, even), zero));
      _mm_store_si128(reinterpret_cast<__m128i*>(sums + 2), _mm_sad_epu8(_mm_andnot_si128(even, count), zero));
      busy[column] = static_cast<int>(sums[0]) >= need;
      busy[column + 1] = static_cast<int>(sums[2]) >= need;
      busy[column + 2] = static_cast<int>(sums[1]) >= need;
      busy[column + 3] = static_cast<int>(sums[3]) >= need;
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

void Gate::scan(const Frame& frame, int first, int last, int threshold) {
  first = std::clamp(first, 0, rows_);
  last = std::clamp(last, first, rows_);
  count_busy(frame, first, last, std::clamp(threshold, 1, 254));
  for (int r = first; r < last; ++r) {
    const std::uint8_t* busy = busy_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    std::uint8_t* across = across_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    int sum = 0;
    for (int c = 0; c < columns_; ++c) {
      sum += busy[c] - (c >= square_ ? busy[c - square_] : 0);
      if (c + 1 >= square_) across[c + 1 - square_] = static_cast<std::uint8_t>(sum);
    }
  }
}

const std::vector<Gate::Place>& Gate::places(int first, int last, const std::vector<Place>& known, double apart) {
  marks_.clear();
  places_.clear();
  const int need = static_cast<int>(std::ceil(filled * square_ * square_ - 1e-9));
  const int least_across = square_ - (square_ * square_ - need);  // or too much is missing in one row already
  const double middle = 0.5 * square_ * cell - 0.5;
  for (int r = std::max(0, first); r < std::min(last, rows_ - square_ + 1); ++r) {
    const std::uint8_t* across = across_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    for (int c = 0; c + square_ <= columns_; ++c) {
      if (across[c] < least_across) continue;
      int sum = 0;
      for (int k = 0; k < square_; ++k) sum += across[c + k * columns_];
      if (sum < need) continue;
      // What is compared lies half a step to the right of where it is counted.
      const Place mark{c * cell + middle + 0.5 * step_, r * cell + middle};
      if (std::none_of(known.begin(), known.end(), [&](const Place& k) { return near(k, mark, apart); }))
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
