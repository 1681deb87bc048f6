#include "ui/plots/plot_history.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace skein::ui {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr PlotHistory::Range nothing{infinity, -infinity};

void widen(PlotHistory::Range& range, double value) {
  if (std::isnan(value)) return;
  range.low = std::min(range.low, value);
  range.high = std::max(range.high, value);
}

void widen(PlotHistory::Range& range, const PlotHistory::Range& by) {
  range.low = std::min(range.low, by.low);
  range.high = std::max(range.high, by.high);
}

}  // namespace

void PlotHistory::add(double t, const std::vector<double>& values) {
  if (blocks_.empty() || blocks_.back().size == block_size) {
    blocks_.emplace_back();
    blocks_.back().curves.resize(curves_);
    for (Curve& curve : blocks_.back().curves) {
      curve.part.fill(nothing);
      curve.whole = nothing;
    }
    while (blocks_.size() > 2 && (blocks_.size() - 1) * block_size >= most_) blocks_.pop_front();
  }
  Block& block = blocks_.back();
  const std::size_t k = block.size++;
  block.t[k] = t;
  for (std::size_t c = 0; c < curves_; ++c) {
    Curve& curve = block.curves[c];
    curve.value[k] = values[c];
    widen(curve.part[k / part_size], values[c]);
    widen(curve.whole, values[c]);
  }
}

std::size_t PlotHistory::index_after(double t) const {
  const auto block =
      std::partition_point(blocks_.begin(), blocks_.end(), [&](const Block& b) { return b.t[b.size - 1] <= t; });
  if (block == blocks_.end()) return size();
  const auto sample =
      std::upper_bound(block->t.begin(), block->t.begin() + static_cast<std::ptrdiff_t>(block->size), t);
  return static_cast<std::size_t>(block - blocks_.begin()) * block_size +
         static_cast<std::size_t>(sample - block->t.begin());
}

/// Of the samples begin to end: whole blocks and parts where they fit in, single samples at the edges.
PlotHistory::Range PlotHistory::range_of(std::size_t curve, std::size_t begin, std::size_t end) const {
  Range range = nothing;
  while (begin < end) {
    const Curve& here = blocks_[begin / block_size].curves[curve];
    const std::size_t k = begin % block_size;
    if (k == 0 && begin + block_size <= end) {
      widen(range, here.whole);
      begin += block_size;
    } else if (k % part_size == 0 && begin + part_size <= end) {
      widen(range, here.part[k / part_size]);
      begin += part_size;
    } else {
      widen(range, here.value[k]);
      ++begin;
    }
  }
  return range;
}

void PlotHistory::points(std::size_t curve, double from, double to, std::size_t columns,
                         std::vector<Point>& out) const {
  out.clear();
  if (empty()) return;
  std::size_t begin = index_after(from);
  std::size_t end = index_after(to);
  begin -= begin > 0 ? 1 : 0;
  end += end < size() ? 1 : 0;
  // Columns of a power of two, counted from the first sample: they stay what they are while the picture moves on.
  std::size_t width = std::bit_ceil((end - begin) / std::max<std::size_t>(1, columns) + 1);
  if (width <= 2) width = 1;
  for (std::size_t k = begin; k < end;) {
    const std::size_t next = std::min(end, (k / width + 1) * width);
    if (next - k == 1) {
      out.push_back({time(k), at(curve, k)});
    } else {
      const Range range = range_of(curve, k, next);
      const bool falls = at(curve, k) > at(curve, next - 1);
      const double t = time(k), last = time(next - 1);
      if (range.low > range.high) {
        out.push_back({t, std::numeric_limits<double>::quiet_NaN()});
      } else {
        out.push_back({t, falls ? range.high : range.low});
        out.push_back({last, falls ? range.low : range.high});
      }
    }
    k = next;
  }
}

void drop_level_points(std::vector<PlotHistory::Point>& points, double tolerance) {
  std::size_t kept = 0, level = 0;  // of what is kept: how many, and where the level stretch at its end begins
  for (const PlotHistory::Point& point : points) {
    const bool same = kept > 0 && std::abs(point.value - points[level].value) <= tolerance;
    if (same && kept > level + 1) --kept;  // between the first and the last of a stretch
    if (!same) level = kept;
    points[kept++] = point;
  }
  points.resize(kept);
}

PlotHistory::Range PlotHistory::range(std::size_t curve, double from, double to) const {
  if (empty()) return nothing;
  std::size_t begin = index_after(from);
  if (begin > 0 && time(begin - 1) == from) --begin;
  return range_of(curve, begin, index_after(to));
}

double PlotHistory::value(std::size_t curve, double t) const {
  const std::size_t after = empty() ? 0 : index_after(t);
  return after > 0 ? at(curve, after - 1) : std::numeric_limits<double>::quiet_NaN();
}

void PlotHistory::each(
    double from, double to,
    const std::function<void(double t, const std::function<double(std::size_t curve)>& value)>& take) const {
  if (empty()) return;
  std::size_t begin = index_after(from);
  if (begin > 0 && time(begin - 1) == from) --begin;
  const std::size_t end = index_after(to);
  for (std::size_t k = begin; k < end; ++k) take(time(k), [&](std::size_t curve) { return at(curve, k); });
}

}  // namespace skein::ui
