// Who is near whom: what the cells give is what looking at every pair gives.
#include "core/avoidance/near_robots.h"

#include <algorithm>
#include <limits>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// Robots anywhere: in a heap, in a line, far off, on one spot, now and then one whose pose is not known.
std::vector<core::Pose> anywhere(Draw& draw, int robots) {
  const double width = draw.decades(-1.0, 2.0), height = draw.chance(0.2) ? 0.0 : draw.decades(-1.0, 2.0);
  std::vector<core::Pose> poses;
  for (int i = 0; i < robots; ++i) {
    if (draw.chance(0.05))
      poses.push_back({not_known, not_known, not_known});
    else if (draw.chance(0.1) && !poses.empty())
      poses.push_back(poses.back());
    else
      poses.push_back({draw.between(-width, width), draw.between(-height, height), draw.angle()});
  }
  return poses;
}

TEST(NearRobots, NobodyWithinReachIsOverlooked) {
  holds("everyone within the reach, each once, in rising order, and nobody whose pose is not known", [] {
    Draw draw(any_seed());
    const std::vector<core::Pose> poses = anywhere(draw, any_of(0, 60));
    core::NearRobots near(poses.size());
    for (int round = 0; round < 3; ++round) {
      const double reach = draw.decades(-2.0, 1.0);
      near.sort(poses, reach);
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const auto around = near.around(i);
        RC_ASSERT(std::is_sorted(around.begin(), around.end()));
        RC_ASSERT(std::adjacent_find(around.begin(), around.end()) == around.end());
        for (std::uint32_t j = 0; j < poses.size(); ++j) {
          const bool there = std::binary_search(around.begin(), around.end(), j);
          const bool within = std::abs(poses[i].x - poses[j].x) <= reach && std::abs(poses[i].y - poses[j].y) <= reach;
          if (within && j != i) RC_ASSERT(there);
          if (j == i || std::isnan(poses[j].x)) RC_ASSERT(!there);
        }
        const std::vector<std::uint32_t> all(around.begin(), around.end());
        const auto above = near.above(i);
        const auto first = std::upper_bound(all.begin(), all.end(), static_cast<std::uint32_t>(i));
        RC_ASSERT(std::equal(first, all.end(), above.begin(), above.end()));
      }
    }
  });
}

TEST(NearRobots, TheSmallestDistanceIsThatOfAllPairs) {
  holds("bit for bit, whatever was asked before", [] {
    Draw draw(any_seed());
    const int robots = any_of(0, 60);
    core::NearRobots near(static_cast<std::size_t>(robots));
    for (int round = 0; round < 3; ++round) {
      const std::vector<core::Pose> poses = anywhere(draw, robots);
      double smallest = not_known;
      for (std::size_t i = 0; i < poses.size(); ++i)
        for (std::size_t j = i + 1; j < poses.size(); ++j)
          smallest = std::fmin(smallest, core::distance(poses[i], poses[j]));
      const double found = near.smallest_distance(poses);
      RC_ASSERT(found == smallest || (std::isnan(found) && std::isnan(smallest)));
    }
  });
}

}  // namespace
}  // namespace skein::test
