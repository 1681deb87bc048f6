#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace skein::core {

/// One number for every pair of different robots. Symmetric by construction, as (18c-e) require: (i, j) and (j, i) are
/// the same cell.
class PairTable {
 public:
  PairTable() = default;
  explicit PairTable(std::size_t robots, double value = 0.0)
      : robots_(robots), cells_(robots * (robots - 1) / 2, value) {}

  std::size_t robots() const noexcept { return robots_; }

  /// The value for robots i != j, both counted from 0.
  double operator()(std::size_t i, std::size_t j) const noexcept { return cells_[cell(i, j)]; }
  void set(std::size_t i, std::size_t j, double value) noexcept {
    cells_[cell(i, j)] = value;
    uniform_ = cells_.size() == 1;
  }
  void fill(double value) noexcept {
    std::fill(cells_.begin(), cells_.end(), value);
    uniform_ = true;
  }

  /// Whether all pairs are known to have the same value: the table was filled, and no pair was set individually since.
  bool uniform() const noexcept { return uniform_; }
  /// The values of the pairs (i, i+1), (i, i+2), ..., contiguous, for loops over whole rows; i < robots - 1.
  const double* row(std::size_t i) const noexcept { return cells_.data() + cell(i, i + 1); }

  /// Whether the value of all pairs is known to be 0, so that there is nothing to add up or to release.
  bool none() const noexcept { return cells_.empty() || (uniform_ && cells_.front() == 0.0); }

  /// The sum over all robots j != i, as in (18f, g).
  double row_sum(std::size_t i) const noexcept {
    if (none()) return 0.0;
    double sum = 0.0;
    for (std::size_t j = 0; j < robots_; ++j)
      if (j != i) sum += (*this)(i, j);
    return sum;
  }
  double largest() const noexcept { return cells_.empty() ? 0.0 : *std::max_element(cells_.begin(), cells_.end()); }

  friend bool operator==(const PairTable& a, const PairTable& b) {
    return a.robots_ == b.robots_ && a.cells_ == b.cells_;
  }

 private:
  // Row by row through the upper triangle: (0,1) (0,2) ... (1,2) ...
  std::size_t cell(std::size_t i, std::size_t j) const noexcept {
    if (i > j) std::swap(i, j);
    return i * (2 * robots_ - i - 1) / 2 + (j - i - 1);
  }

  std::size_t robots_ = 0;
  std::vector<double> cells_;
  bool uniform_ = true;
};

}  // namespace skein::core
