#pragma once

#include <cstdint>
#include <random>

namespace skein::core {

/// A seeded random number generator with the same values for every standard library: the engine's sequence is fixed by
/// the C++ standard, and the distributions are implemented here (std::normal_distribution differs between libraries).
class Random {
 public:
  /// Streams of one seed are independent: one for each robot.
  Random(std::uint64_t seed, std::uint64_t stream);

  /// Uniform in [0, 1).
  double uniform() noexcept;
  /// Gaussian with mean 0 and standard deviation 1.
  double gaussian() noexcept;

 private:
  std::mt19937_64 engine_;
};

}  // namespace skein::core
