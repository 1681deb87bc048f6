#pragma once

#include <limits>
#include <string>

namespace skein::comms {

/// A robot's battery, as far as the robot reports it.
struct Battery {
  double volts = std::numeric_limits<double>::quiet_NaN();  ///< [V]; NaN: an old e-puck1 reports only good and low
  bool low = false;                                         ///< below 3.5 V, or reported low: charge it

  bool good = false;  ///< reported by an old e-puck1
};

/// An e-puck's battery with less than this is low; with 3.4 V it is empty. [V]
inline constexpr double epuck_charge_below = 3.5;

/// Interprets a raw battery value. An e-puck2 reports 819.2 per volt, an e-puck1 of hardware 1.3 reports 2070 to 2560
/// for 3.4 to 4.2 V, an older one 1 or, below 3.4 V, 0. Other values are invalid.
Battery battery_of(int raw) noexcept;

/// "3.90 V", "3.40 V (low)", "good", "low"; "unknown".
std::string to_text(const Battery& battery);

}  // namespace skein::comms
