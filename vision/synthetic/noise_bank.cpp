#include "vision/synthetic/noise_bank.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein::vision::detail {
namespace {

constexpr std::size_t bank_size = std::size_t{1} << 20;

/// Grey levels rounded to whole ones, each as often among 65536 as the normal distribution has it.
std::vector<std::int8_t> quantiles(double sigma) {
  std::vector<std::int8_t> table;
  table.reserve(65536);
  for (int level = -127; level <= 127; ++level) {
    const double up_to = 0.5 * (1.0 + std::erf((level + 0.5) / (sigma * std::numbers::sqrt2)));
    const auto end = level == 127 ? std::size_t{65536} : static_cast<std::size_t>(std::lround(up_to * 65536.0));
    table.resize(std::max(table.size(), end), static_cast<std::int8_t>(level));
  }
  return table;
}

}  // namespace

NoiseBank::NoiseBank(double sigma, std::uint64_t seed) : random_(Random::mix(seed ^ 0x5eed0f4015e5ULL)) {
  if (!(sigma > 0.0)) return;
  const std::vector<std::int8_t> table = quantiles(sigma);
  numbers_.resize(bank_size);
  for (std::size_t i = 0; i < bank_size; i += 4) {
    std::uint64_t bits = random_.bits();
    for (std::size_t k = 0; k < 4; ++k, bits >>= 16) numbers_[i + k] = table[bits & 0xffff];
  }
}

void NoiseBank::add(const std::vector<std::uint8_t>& clean, Frame& out) {
  if (numbers_.empty()) {
    std::copy(clean.begin(), clean.end(), out.grey.begin());
    return;
  }
  for (int v = 0; v < out.height; ++v) {
    // Blocks of a fixed length are what the compiler turns into a handful of vector instructions.
    constexpr int block = 64;
    const std::uint8_t* __restrict from = clean.data() + static_cast<std::ptrdiff_t>(v) * out.width;
    const std::int8_t* __restrict noise =
        numbers_.data() + random_.below(bank_size - static_cast<std::size_t>(out.width));
    std::uint8_t* __restrict to = out.row(v);
    // In 16 bits, of which a vector holds eight.
    const auto one = [from, noise](int u) {
      const auto sum = static_cast<std::int16_t>(from[u] + noise[u]);
      return static_cast<std::uint8_t>(std::clamp<std::int16_t>(sum, 0, 255));
    };
    int u = 0;
    for (; u + block <= out.width; u += block) {
      for (int i = 0; i < block; ++i) to[u + i] = one(u + i);
    }
    for (; u < out.width; ++u) to[u] = one(u);
  }
}

}  // namespace skein::vision::detail
