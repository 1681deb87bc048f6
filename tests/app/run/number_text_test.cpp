#include "app/run/number_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace skein::app {
namespace {

TEST(NumberText, HasNoSignBeforeAZeroAndRoundsAsUsual) {
  EXPECT_EQ(fixed(-0.0, 0), "0");
  EXPECT_EQ(fixed(-0.3, 0), "0");
  EXPECT_EQ(fixed(-0.004, 2), "0.00");
  EXPECT_EQ(fixed(-0.006, 2), "-0.01");
  EXPECT_EQ(fixed(-10.0, 0), "-10");
  EXPECT_EQ(fixed(0.004, 2), "0.00");
  EXPECT_EQ(fixed(-std::numeric_limits<double>::infinity(), 1), "-inf");
  EXPECT_EQ(significant(-0.0, 3), "0");
  EXPECT_EQ(significant(-0.00012345, 3), "-0.000123");
  EXPECT_EQ(significant(-1e-9, 3), "-1e-09");
}

}  // namespace
}  // namespace skein::app
