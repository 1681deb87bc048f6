#include "core/avoidance/near_robots.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/math/elementary.h"

namespace skein::core {

NearRobots::NearRobots(std::size_t robots)
    : buckets_(std::bit_ceil(2 * robots + 1)), cells_(robots), begin_(buckets_ + 2), sorted_(robots), near_(robots) {}

std::size_t NearRobots::bucket(std::int64_t x, std::int64_t y) const noexcept {
  const auto a = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL;
  const auto b = static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fULL;
  return static_cast<std::size_t>((a ^ b) >> 32) & (buckets_ - 1);
}

void NearRobots::sort(std::span<const Pose> poses, double reach) noexcept {
  constexpr double farthest = 1e9;  // cells from the origin: what is beyond shares the last one
  const auto cell = [&](double at) {
    return static_cast<std::int64_t>(std::clamp(std::floor(at / reach), -farthest, farthest));
  };
  std::fill(begin_.begin(), begin_.end(), 0U);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const bool known = !std::isnan(poses[i].x) && !std::isnan(poses[i].y);
    cells_[i] = known ? Cell{cell(poses[i].x), cell(poses[i].y), true} : Cell{0, 0, false};
    if (known) ++begin_[bucket(cells_[i].x, cells_[i].y) + 2];
  }
  for (std::size_t b = 0; b < buckets_; ++b) begin_[b + 2] += begin_[b + 1];
  // Each bucket's beginning moves to its end as it fills, which is the next one's beginning: hence the shift by one.
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (cells_[i].known) sorted_[begin_[bucket(cells_[i].x, cells_[i].y) + 1]++] = static_cast<std::uint32_t>(i);
}

std::span<const std::uint32_t> NearRobots::gather(std::size_t i, std::size_t first) noexcept {
  const Cell& here = cells_[i];
  if (!here.known) return {};
  std::array<std::size_t, 9> looked{};
  std::size_t buckets = 0, found = 0;
  for (std::int64_t dx = -1; dx <= 1; ++dx)
    for (std::int64_t dy = -1; dy <= 1; ++dy) {
      const std::size_t b = bucket(here.x + dx, here.y + dy);
      if (std::find(looked.begin(), looked.begin() + buckets, b) != looked.begin() + buckets) continue;
      looked[buckets++] = b;
      for (std::uint32_t k = begin_[b]; k < begin_[b + 1]; ++k)
        if (sorted_[k] >= first && sorted_[k] != i) near_[found++] = sorted_[k];
    }
  std::sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(found));
  return {near_.data(), found};
}

double NearRobots::smallest_distance(std::span<const Pose> poses) noexcept {
  // Two that are nearer than the reach are all seen; where the nearest are farther apart than that, look farther.
  constexpr double farther = 2.0, enough = 1e6, rounding = 1.0 + 1e-9;
  double smallest = std::numeric_limits<double>::quiet_NaN();
  if (poses.size() < 2) return smallest;
  for (double reach = last_reach_; reach < enough; reach *= farther) {
    sort(poses, reach);
    for (std::size_t i = 0; i < poses.size(); ++i)
      for (const std::uint32_t j : above(i)) {
        const double dx = poses[i].x - poses[j].x, dy = poses[i].y - poses[j].y;
        if (dx * dx + dy * dy > rounding * smallest * smallest) continue;
        smallest = std::fmin(smallest, math::hypot(dx, dy));
      }
    if (!(smallest <= reach)) continue;
    last_reach_ = std::max(1.1 * smallest, 1e-3);
    break;
  }
  return smallest;
}

}  // namespace skein::core
