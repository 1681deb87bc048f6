#include "app/run/histogram.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>
#include <vector>

namespace skein::app {
namespace {

TEST(Histogram, IsEmptyAtFirst) {
  const Histogram histogram;
  EXPECT_EQ(histogram.total(), 0u);
  EXPECT_EQ(histogram.quantile(0.5), 0.0);
}

TEST(Histogram, CountsWhatIsOutOfRangeAtItsEnds) {
  Histogram histogram;
  for (const double seconds : {-1.0, 0.0, 1e-9, 100.0}) histogram.add(seconds);
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(histogram.total(), 4u);
  EXPECT_EQ(histogram.count(0), 3u);
  EXPECT_EQ(histogram.count(Histogram::sizes - 1), 1u);
  EXPECT_EQ(histogram.largest(), 100.0);
}

RC_GTEST_PROP(Histogram, QuantilesAreThoseOfTheSortedDurationsToOneSize, ()) {
  auto microseconds = *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(2, 5'000'000)));
  Histogram histogram;
  for (const int us : microseconds) histogram.add(1e-6 * us);
  std::sort(microseconds.begin(), microseconds.end());
  for (const double share : {0.01, 0.5, 0.99, 1.0}) {
    const auto rank =
        static_cast<std::size_t>(std::max(1.0, std::ceil(share * static_cast<double>(microseconds.size()))));
    const double exact = 1e-6 * microseconds[rank - 1];
    RC_ASSERT(histogram.quantile(share) >= exact * (1.0 - 1e-9));
    RC_ASSERT(histogram.quantile(share) <= exact * 1.0443);
  }
}

RC_GTEST_PROP(Histogram, WhatWasAddedSinceIsAsIfItWereAloneToOneSize,
              (std::vector<int> before, std::vector<int> after)) {
  Histogram histogram, alone;
  for (const int us : before) histogram.add(1e-6 * us);
  const Histogram earlier = histogram;
  for (const int us : after) histogram.add(1e-6 * us), alone.add(1e-6 * us);
  const Histogram since = histogram.since(earlier);
  RC_ASSERT(since.total() == alone.total());
  for (std::size_t size = 0; size < Histogram::sizes; ++size) RC_ASSERT(since.count(size) == alone.count(size));
  for (const double share : {0.5, 0.99, 1.0}) {
    RC_ASSERT(since.quantile(share) >= alone.quantile(share));
    RC_ASSERT(since.quantile(share) <= std::max(1.0443e-6, 1.0443 * alone.quantile(share)));
  }
  Histogram sum = earlier;
  sum += since;
  RC_ASSERT(sum.total() == histogram.total());
  RC_ASSERT(sum.quantile(0.99) == histogram.quantile(0.99));
}

}  // namespace
}  // namespace skein::app
