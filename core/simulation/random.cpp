#include "core/simulation/random.h"

#include <cmath>
#include <numbers>

#include "core/math/elementary.h"

namespace skein::core {
namespace {

/// One step of SplitMix64 (Steele, Lea, Flood 2014): turns neighbouring seeds into unrelated ones.
std::uint64_t mix(std::uint64_t z) noexcept {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream) : engine_(mix(mix(seed) ^ stream)) {}

double Random::uniform() noexcept {
  return static_cast<double>(engine_() >> 11) * 0x1p-53;
}

double Random::gaussian() noexcept {
  // Box and Muller; 1 - uniform() is never 0. The second value of the pair is not kept: a draw depends on nothing but
  // its place.
  const double radius = std::sqrt(-2.0 * math::log(1.0 - uniform()));
  return radius * math::cos(2.0 * std::numbers::pi * uniform());
}

}  // namespace skein::core
