#include "app/calibration/floor_marks_file.h"

#include <gtest/gtest.h>

namespace skein::app {
namespace {

TEST(FloorMarks, AreReadAndRefused) {
  const auto marks = parse_floor_marks(
      "[[tag]]\nid = 5\nx = -0.5\ny = 0.25\n[[point]]\nu = 12.5\nv = 7\nx = 1.0\ny = 2\nz = 0.01\n", "m.toml");
  ASSERT_TRUE(marks) << marks.error();
  ASSERT_EQ(marks->size(), 2U);
  EXPECT_EQ((*marks)[0].tag, 5);
  EXPECT_FALSE((*marks)[0].seen);
  EXPECT_EQ((*marks)[1].u, 12.5);
  EXPECT_EQ((*marks)[1].z, 0.01);
  EXPECT_TRUE((*marks)[1].seen);
  const struct {
    const char* text;
    const char* problem;
  } cases[] = {
      {"", "m.toml:1:1: no mark on this floor, allowed: [[tag]] or [[point]]"},
      {"[[tag]]\nid = 5\nx = 1\n", "m.toml:1:1: tag.1.y: missing, allowed: a number from -100 to 100 m"},
      {"[[tag]]\nid = 587\nx = 1\ny = 1\n", "m.toml:2:6: tag.1.id: found 587, allowed: a whole number from 0 to 586"},
      {"[[tag]]\nid = 5\nx = 1\ny = 1\n[[tag]]\nid = 5\nx = 1\ny = 1\n",
       "m.toml:6:6: tag.2.id: found 5 again, allowed: each tag once"},
      {"[[tag]]\nid = 5\nx = 1\ny = 1\nangle = 2\n",
       "m.toml:5:1: tag.1.angle: unknown key, allowed in tag.1: id, x, y, z"},
      {"tag = 3\n", "m.toml:1:7: tag: found 3, allowed: tables [[tag]]"},
      {"[[point\n", "m.toml:1:8: "},
  };
  for (const auto& [text, problem] : cases) {
    const auto refused = parse_floor_marks(text, "m.toml");
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(refused.error().substr(0, std::string(problem).size()), problem);
  }
}

}  // namespace
}  // namespace skein::app
