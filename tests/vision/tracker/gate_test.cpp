#include "vision/tracker/gate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "vision/synthetic/random.h"

namespace skein::vision {
namespace {

/// Grey levels without order, flat in between: busy squares everywhere and nowhere.
Frame patchwork(int width, int height) {
  detail::Random random(7);
  Frame frame;
  frame.resize(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const bool flat = (u / 60 + v / 60) % 2 == 0;
      frame.row(v)[u] = flat ? 128 : static_cast<std::uint8_t>(256.0 * random.unit());
    }
  return frame;
}

TEST(Gate, AllInstructionsFindTheSamePlacesAtEveryWidth) {
  std::size_t most = 0;
  for (const int width : {1280, 652, 333, 61})
    for (const double edge : {12.0, 38.0, 200.0}) {
      const Frame frame = patchwork(width, 240);
      detail::Gate fast(frame.width, frame.height, edge, detail::best_instructions());
      detail::Gate slow(frame.width, frame.height, edge, detail::Instructions::baseline);
      for (const int threshold : {20, 60}) {
        fast.scan(frame, 0, fast.rows(), threshold);
        slow.scan(frame, 0, slow.rows(), threshold);
        const std::vector<detail::Gate::Place> found = fast.places(0, fast.rows(), {}, 0.7 * edge);
        const std::vector<detail::Gate::Place>& expected = slow.places(0, slow.rows(), {}, 0.7 * edge);
        ASSERT_EQ(found.size(), expected.size()) << width << " wide, edge " << edge;
        for (std::size_t i = 0; i < found.size(); ++i) {
          EXPECT_EQ(found[i].u, expected[i].u);
          EXPECT_EQ(found[i].v, expected[i].v);
        }
        most = std::max(most, found.size());
      }
    }
  EXPECT_GT(most, 20U);
}

}  // namespace
}  // namespace skein::vision
