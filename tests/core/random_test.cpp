// Seeded randomness: the numbers themselves are fixed here, so that a change of them in any build is seen.
#include "core/simulation/random.h"

#include <cmath>
#include <vector>

#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Random;

TEST(Random, GivesTheseNumbersInEveryBuild) {
  // Computed with another program, from the published definitions of SplitMix64, MT19937-64 and Box-Muller. The uniform
  // numbers are exact; log and cos are each maths library's own to the last bit or two.
  Random a(1, 0), b(1, 1), c(20101208, 7);
  EXPECT_EQ(a.uniform(), 0x1.c41664bccfccap-2);
  EXPECT_EQ(a.uniform(), 0x1.5048b06e200cap-2);
  EXPECT_EQ(a.uniform(), 0x1.7d2769b9059f3p-1);
  EXPECT_NEAR(a.gaussian(), -0.025343157730289455, 1e-14);
  EXPECT_NEAR(a.gaussian(), 0.5917738559153889, 1e-14);
  EXPECT_EQ(b.uniform(), 0x1.b3370781c5d3ep-1);
  EXPECT_EQ(b.uniform(), 0x1.44d62a86078d4p-2);
  EXPECT_EQ(b.uniform(), 0x1.46625bd2fdf2fp-1);
  EXPECT_NEAR(b.gaussian(), 0.2687445437560491, 1e-14);
  EXPECT_NEAR(b.gaussian(), -0.22181869536990406, 1e-14);
  EXPECT_EQ(c.uniform(), 0x1.983d2f280e1a4p-3);
  EXPECT_EQ(c.uniform(), 0x1.a2b6a951e8f1ep-2);
  EXPECT_EQ(c.uniform(), 0x1.dfaa7308e2f90p-2);
  EXPECT_NEAR(c.gaussian(), 0.45022736819047177, 1e-14);
  EXPECT_NEAR(c.gaussian(), -0.9698653534331422, 1e-14);
}

TEST(Random, RepeatsForOneSeedAndStream) {
  holds("same seed and stream, same numbers; another seed or stream, others", [] {
    Draw draw(any_seed());
    const auto seed = static_cast<std::uint64_t>(draw.between(0.0, 1e6));
    const auto stream = static_cast<std::uint64_t>(draw.whole(0, 20));
    Random one(seed, stream), same(seed, stream), next_seed(seed + 1, stream), next_stream(seed, stream + 1);
    bool seeds_differ = false, streams_differ = false;
    for (int k = 0; k < 10; ++k) {
      const double x = one.gaussian();
      RC_ASSERT(same.gaussian() == x);
      seeds_differ |= next_seed.gaussian() != x;
      streams_differ |= next_stream.gaussian() != x;
    }
    RC_ASSERT(seeds_differ && streams_differ);
  });
}

TEST(Random, IsUniformAndGaussian) {
  // 1e5 draws: means within five standard errors, by the moments of either distribution.
  constexpr int count = 100000;
  Random random(3, 0);
  double sum = 0.0, squares = 0.0, low = 1.0, high = 0.0;
  std::vector<int> tenth(10);
  for (int k = 0; k < count; ++k) {
    const double u = random.uniform();
    sum += u, squares += u * u, low = std::min(low, u), high = std::max(high, u);
    ++tenth[static_cast<std::size_t>(10.0 * u)];
  }
  EXPECT_GE(low, 0.0);
  EXPECT_LT(high, 1.0);
  EXPECT_NEAR(sum / count, 0.5, 5.0 * std::sqrt(1.0 / 12.0 / count));
  EXPECT_NEAR(squares / count, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / count));
  for (const int in_tenth : tenth) EXPECT_NEAR(in_tenth, count / 10, 5.0 * std::sqrt(0.09 * count));

  double first = 0.0, second = 0.0, fourth = 0.0, product = 0.0, last = 0.0;
  for (int k = 0; k < count; ++k) {
    const double g = random.gaussian();
    first += g, second += g * g, fourth += g * g * g * g, product += g * last;
    last = g;
  }
  EXPECT_NEAR(first / count, 0.0, 5.0 / std::sqrt(count));
  EXPECT_NEAR(second / count, 1.0, 5.0 * std::sqrt(2.0 / count));
  EXPECT_NEAR(fourth / count, 3.0, 5.0 * std::sqrt(96.0 / count));
  EXPECT_NEAR(product / count, 0.0, 5.0 / std::sqrt(count));
}

TEST(Random, StreamsOfOneSeedAreUnrelated) {
  constexpr int count = 20000;
  for (std::uint64_t stream = 0; stream < 6; ++stream) {
    Random one(11, stream), other(11, stream + 1);
    double product = 0.0;
    for (int k = 0; k < count; ++k) product += one.gaussian() * other.gaussian();
    EXPECT_NEAR(product / count, 0.0, 5.0 / std::sqrt(count)) << stream;
  }
}

}  // namespace
}  // namespace skein::test
