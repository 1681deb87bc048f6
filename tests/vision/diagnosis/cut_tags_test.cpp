// Tags of which the border of a picture or a cover leaves a part, seen never before: which ones they are and where.
#include "vision/diagnosis/cut_tags.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "tests/vision/support.h"
#include "vision/synthetic/random.h"
#include "vision/synthetic/synthetic_camera.h"
#include "vision/tags/tag_family.h"
#include "vision/tags/tag_pattern.h"
#include "vision/tags/tag_plane.h"

namespace skein::vision::detail {
namespace {

/// A dozen tags along the border, turned in any way, their middles a third of an edge outside to one inside.
struct Scene {
  explicit Scene(unsigned seed) : random(seed) {
    calibration.tag_size = random.between(0.04, 0.06);
    const double edge = tag_edge_px(calibration), right = calibration.width - 1.0, bottom = calibration.height - 1.0;
    for (int i = 0; i < 12; ++i) {
      const double in = random.between(-0.33, 1.0) * edge,
                   along = 0.15 + 0.7 * (i / 4 + random.between(0.2, 0.8)) / 3.0;
      const Eigen::Vector2d at = i % 4 == 0   ? Eigen::Vector2d(in, along * bottom)
                                 : i % 4 == 1 ? Eigen::Vector2d(along * right, in)
                                 : i % 4 == 2 ? Eigen::Vector2d(right - in, along * bottom)
                                              : Eigen::Vector2d(along * right, bottom - in);
      const auto place = world_from_pixel(calibration, at, calibration.tag_height);
      EXPECT_TRUE(place);
      tags.push_back(
          {static_cast<int>(seed) * 12 + i, {place->x(), place->y(), random.between(-3.1, 3.1)}, calibration.tag_size});
      inside.push_back(in / edge);
    }
    SyntheticCamera(calibration, {.noise_sigma = random.between(1.0, 4.0), .brightness = random.between(0.4, 1.0)},
                    seed)
        .render(tags, 0.0, frame);
  }

  Random random;
  Calibration calibration = overhead_calibration(2.0, 1.5);
  Frame frame;
  std::vector<SyntheticTag> tags;
  std::vector<double> inside;  // how far the middles are, in edges
};

TEST(CutTags, AreKnownByABareHalfAndNoneIsTakenForAnother) {
  int found = 0;
  for (unsigned seed = 0; seed < 3; ++seed) {
    const Scene scene(seed);
    std::vector<int> asked;
    for (const SyntheticTag& tag : scene.tags) asked.push_back(tag.tag);
    for (int other = 0; other < 100; ++other) asked.push_back(largest_tag - other);  // which are not there
    const auto poses = find_cut_tags(scene.frame, scene.calibration, asked);
    ASSERT_EQ(poses.size(), asked.size());
    for (std::size_t i = 0; i < scene.tags.size(); ++i) {
      const core::Pose& at = scene.tags[i].pose;
      // Deeper inside, where the paper's corner alone may be cut, or nothing is, others find it.
      if (scene.inside[i] > 0.05 && scene.inside[i] < 0.5) {
        EXPECT_TRUE(poses[i]) << "seed " << seed << ", tag " << i << ", " << scene.inside[i];
        ++found;
      }
      if (!poses[i]) continue;
      EXPECT_LT(core::distance(*poses[i], at), 0.002);
      EXPECT_NEAR(core::wrap_angle(poses[i]->theta - at.theta), 0.0, 0.06);
    }
    for (std::size_t i = scene.tags.size(); i < asked.size(); ++i) EXPECT_FALSE(poses[i]) << asked[i];
  }
  EXPECT_GT(found, 8) << "else the scenes show nothing";
}

/// The bits in the left half of a tag that is turned by so many quarters to the left.
std::uint32_t left_half(const TagPattern& pattern, int quarters) {
  constexpr std::size_t side = pattern_cells, first = 2;
  std::uint32_t bits = 0;
  for (std::size_t k = first; k < side - first; ++k)
    for (std::size_t j = first; j < side / 2; ++j) {
      std::size_t row = k, column = j;
      for (int turn = 0; turn < quarters; ++turn) row = std::exchange(column, side - 1 - row);
      bits = 2 * bits + (pattern[row * side + column] ? 1 : 0);
    }
  return bits;
}

/// What the border leaves of two tags may be the same, in a few cases of a thousand.
TEST(CutTags, OfWhichTheSameIsLeftAreNotToldApart) {
  const std::vector<TagPattern> all = tag_patterns();
  std::map<std::uint32_t, std::vector<std::pair<int, int>>> halves;  // the tags and turns that show them
  for (std::size_t tag = 0; tag < all.size(); ++tag)
    for (int quarters = 0; quarters < 4; ++quarters)
      halves[left_half(all[tag], quarters)].emplace_back(static_cast<int>(tag), quarters);
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  const auto place =
      world_from_pixel(calibration, {calibration.width - 1.0, 0.5 * calibration.height}, calibration.tag_height);
  ASSERT_TRUE(place);
  int looks = 0, controls = 0;
  for (const auto& [bits, shown_by] : halves) {
    int& done = shown_by.size() > 1 ? looks : controls;
    if (done++ >= 3) continue;
    const auto [tag, quarters] = shown_by.front();
    const core::Pose pose{place->x(), place->y(), core::wrap_angle(0.5 * core::pi * quarters)};
    Frame frame;
    SyntheticCamera(calibration, {}, 1).render(std::vector{SyntheticTag{tag, pose, calibration.tag_size}}, 0.0, frame);
    std::vector<int> asked;
    for (const auto& [one, turn] : shown_by) asked.push_back(one);
    for (const auto& found : find_cut_tags(frame, calibration, asked))
      EXPECT_EQ(found.has_value(), shown_by.size() == 1) << "tag " << tag << ", turned " << quarters << " times";
  }
  EXPECT_GT(looks, 0);
}

TEST(CoveredTags, AreKnownByAHalfAndNoneIsTakenForAnother) {
  const Calibration calibration = overhead_calibration(2.0, 1.5);
  int known = 0;
  const unsigned seeds = test::sanitized ? 1 : 2;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    Random random(seed);
    std::vector<SyntheticTag> tags;
    std::vector<int> asked;
    for (int i = 0; i < 12; ++i) {
      tags.push_back({static_cast<int>(seed) * 12 + i,
                      {0.4 * (i % 4) - 0.6, 0.4 * (i / 4) - 0.4, random.between(-3.1, 3.1)},
                      calibration.tag_size});
      asked.push_back(tags.back().tag);
    }
    const int others = test::sanitized ? 10 : 100;
    for (int other = 0; other < others; ++other) asked.push_back(largest_tag - other);  // which are not there
    Frame frame;
    SyntheticCamera(calibration, {.noise_sigma = 3.0}, seed).render(tags, 0.0, frame);
    for (const SyntheticTag& tag : tags) {  // something grey over one half of each
      const auto at = pixel_from_world(calibration, {tag.pose.x, tag.pose.y, calibration.tag_height});
      const double edge = tag_edge_px(calibration), across = -tag.pose.theta + tag.tag % 4 * 0.5 * core::pi;
      for (int v = 0; v < frame.height; ++v)
        for (int u = 0; u < frame.width; ++u) {
          const double du = u - at->x(), dv = v - at->y();
          const bool beyond = du * std::cos(across) + dv * std::sin(across) > 0.03 * edge;
          if (beyond && std::hypot(du, dv) < 1.2 * edge) frame.row(v)[u] = 90;
        }
    }
    const auto poses = find_covered_tags(frame, calibration, asked, {0, 0, frame.width, frame.height});
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (!poses[i]) continue;
      ASSERT_LT(i, tags.size()) << "tag " << asked[i] << " is not there";
      const core::Pose& at = tags[i].pose;
      EXPECT_LT(std::hypot(poses[i]->x - at.x, poses[i]->y - at.y), 0.003) << asked[i];
      EXPECT_LT(std::abs(core::wrap_angle(poses[i]->theta - at.theta)), 0.1) << asked[i];
      ++known;
    }
  }
  EXPECT_GE(known, 11 * static_cast<int>(seeds)) << "of 12 each";
}

}  // namespace
}  // namespace skein::vision::detail
