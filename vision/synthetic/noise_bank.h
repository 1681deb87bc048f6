#pragma once

#include <cstdint>
#include <vector>

#include "vision/frames/frame.h"
#include "vision/synthetic/random.h"

namespace skein::vision::detail {

/// A sensor's noise: a million numbers drawn once; every row of every frame begins at another place among them.
class NoiseBank {
 public:
  NoiseBank(double sigma, std::uint64_t seed);

  /// out.grey = clean + noise, kept within 0..255.
  void add(const std::vector<std::uint8_t>& clean, Frame& out);

 private:
  std::vector<std::int8_t> numbers_;
  Random random_;
};

}  // namespace skein::vision::detail
