#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "core/estimation/measurement.h"
#include "core/estimation/pose_filter.h"

namespace skein::core {

/// Sees from the robots' motion whether they obey their commands later than the time stamps of their poses and the
/// known delays of the links explain: then pictures are older than their stamps say, or something holds commands up.
/// Each motion that is seen is compared with what was commanded so long before, for delays from 0 to 2.5 s; who drives
/// on steadily shows nothing. Does not allocate.
class DelayWatch {
 public:
  /// What one robot was seen to do from one sight to another, some 0.2 s later. `to_wheel`: from its middle to one of
  /// its wheels [m]. One robot in each tick is enough.
  void see(const PoseFilter& filter, const Measurement& from, const Measurement& to, double to_wheel) noexcept;
  /// By how much all that was seen is late [s]; nullopt: it is not, or too little was seen.
  std::optional<double> late() const noexcept;
  /// Discards what was seen.
  void forget() noexcept { *this = {}; }

 private:
  static constexpr std::size_t delays = 26;
  static constexpr double seconds(std::size_t k) noexcept { return static_cast<double>(k) / 10.0; }

  std::array<double, delays> errors_{};  // of each delay: squared, of what was seen in the last 10 s [m^2]
  double moved_ = 0.0;                   // likewise: the squares of what was seen
  double noise_ = 0.0;                   // and their variances by the noise of the poses
};

}  // namespace skein::core
