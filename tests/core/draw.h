#pragma once

#include <rapidcheck.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/control/gains.h"
#include "core/control/tracking_error.h"
#include "core/geometry/pose.h"

namespace skein::test {

/// Numbers for one random case. RapidCheck chooses the seed (and prints it when the case fails); the numbers come from
/// the standard's engine, not from core/simulation/random.h, which is itself under test.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}

  double between(double low, double high) { return low + (high - low) * unit(); }
  bool chance(double probability) { return unit() < probability; }
  int whole(int low, int high) { return low + static_cast<int>(unit() * (high - low + 1)); }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  /// 10^low to 10^high, every decade alike: laws like this one change character over many sizes of error.
  double decades(double low, double high) { return std::pow(10.0, between(low, high)); }
  double angle() { return -core::pi + 2.0 * core::pi * (1.0 - unit()); }  // (-pi, pi]
  core::Pose pose(double reach) { return {between(-reach, reach), between(-reach, reach), angle()}; }

 private:
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::mt19937_64 engine_;
};

/// A seed from RapidCheck, whatever the present size of its cases; printed when a case fails.
inline std::uint64_t any_seed() {
  return *rc::gen::noShrink(rc::gen::resize(rc::kNominalSize, rc::gen::arbitrary<std::uint64_t>()));
}

/// low..high, both included, every value alike from the first case on; shrinks towards low.
inline int any_of(int low, int high) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(low, high + 1));
}

/// A group of robots at one moment: gains that satisfy (18), errors, reference velocities.
struct Group {
  core::Gains gains;
  std::vector<core::TrackingError> errors;
  std::vector<core::Twist> reference;

  std::size_t robots() const { return errors.size(); }
};

/// Errors of every size: zero, millimetres, metres, and now and then as far as `largest`.
core::TrackingError random_error(Draw& draw, double largest = 10.0);

/// Gains with everything that (18) leaves free drawn at random, each robot and each pair for itself; in one case of
/// four (18f, g) are met with equality. Both saturations; the coupling as asked.
Group random_group(Draw& draw, std::size_t robots, core::Coupling coupling);

/// The same with a random form of the coupling.
Group random_group(Draw& draw, std::size_t robots);

}  // namespace skein::test
