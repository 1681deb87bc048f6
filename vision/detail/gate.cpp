#include "vision/detail/gate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace skein::vision::detail {
namespace {

// Of a cell's comparisons. Noise at the limit of what can be tracked (twice its sigma makes the threshold) reaches 5 %.
constexpr int busy_per_cent = 22;

// Of a square's cells: a tag may have four equal modules in a row.
constexpr double filled = 0.85;

bool near(const Gate::Place& a, const Gate::Place& b, double distance) {
  return std::abs(a.u - b.u) < distance && std::abs(a.v - b.v) < distance &&
         std::hypot(a.u - b.u, a.v - b.v) < distance;
}

}  // namespace

Gate::Gate(int width, int height, double edge_px)
    : width_(width),
      step_(std::max(2, static_cast<int>(std::lround(edge_px / 8.0)))),
      // As large as possible with a square of two at least that a tag covers whichever way it is turned and wherever
      // the cells happen to lie.
      cell_(edge_px * 1.2 / std::numbers::sqrt2 >= 3 * 8 ? 8 : 4),
      columns_(std::max(0, width - step_) / cell_),
      rows_(height / cell_),
      square_(std::max(2, static_cast<int>(edge_px * 1.2 / std::numbers::sqrt2 / cell_) - 1)),
      busy_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      across_(busy_.size()) {}

/// Blocks of fixed length, which the compiler turns into a handful of vector instructions.
template <int cell>
void Gate::count_busy(const Frame& frame, int first, int last, int threshold) {
  constexpr int row_step = cell / 4;  // four rows of a cell say enough
  constexpr int block = 32;
  constexpr int need = cell * 4 * busy_per_cent / 100;
  const auto limit = static_cast<std::uint8_t>(std::clamp(threshold, 1, 254));
  for (int r = first; r < last; ++r) {
    std::uint8_t* busy = busy_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    int column = 0;
    for (; column + block / cell <= columns_; column += block / cell) {
      std::uint8_t count[block] = {};
      for (int v = r * cell; v < (r + 1) * cell; v += row_step) {
        const std::uint8_t* __restrict left = frame.row(v) + column * cell;
        const std::uint8_t* __restrict right = left + step_;
        for (int i = 0; i < block; ++i) {
          const auto apart = static_cast<std::uint8_t>(std::max(left[i], right[i]) - std::min(left[i], right[i]));
          count[i] = static_cast<std::uint8_t>(count[i] + (apart > limit ? 1 : 0));
        }
      }
      for (int c = 0; c < block / cell; ++c) {
        int sum = 0;
        for (int i = 0; i < cell; ++i) sum += count[c * cell + i];
        busy[column + c] = sum >= need ? 1 : 0;
      }
    }
    for (; column < columns_; ++column) {
      int sum = 0;
      for (int v = r * cell; v < (r + 1) * cell; v += row_step) {
        const std::uint8_t* left = frame.row(v) + column * cell;
        for (int i = 0; i < cell; ++i) sum += std::abs(left[i] - left[i + step_]) > limit ? 1 : 0;
      }
      busy[column] = sum >= need ? 1 : 0;
    }
  }
}

void Gate::look(const Frame& frame, int first, int last, int threshold) {
  first = std::clamp(first, 0, rows_);
  last = std::clamp(last, first, rows_);
  if (cell_ == 8) {
    count_busy<8>(frame, first, last, threshold);
  } else {
    count_busy<4>(frame, first, last, threshold);
  }
  for (int r = first; r < last; ++r) {
    const std::uint8_t* busy = busy_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    std::uint8_t* across = across_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    for (int c = 0; c + square_ <= columns_; ++c) {
      int sum = 0;
      for (int k = 0; k < square_; ++k) sum += busy[c + k];
      across[c] = static_cast<std::uint8_t>(sum);
    }
  }
}

const std::vector<Gate::Place>& Gate::places(int first, int last, const std::vector<Place>& known, double apart) {
  marks_.clear();
  places_.clear();
  const int need = static_cast<int>(std::ceil(filled * square_ * square_ - 1e-9));
  const double middle = 0.5 * square_ * cell_ - 0.5;
  for (int r = std::max(0, first); r < std::min(last, rows_ - square_ + 1); ++r) {
    const std::uint8_t* across = across_.data() + static_cast<std::ptrdiff_t>(r) * columns_;
    for (int c = 0; c + square_ <= columns_; ++c) {
      int sum = 0;
      for (int k = 0; k < square_; ++k) sum += across[c + k * columns_];
      if (sum < need) continue;
      // What is compared lies half a step to the right of where it is counted.
      const Place mark{c * cell_ + middle + 0.5 * step_, r * cell_ + middle};
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
