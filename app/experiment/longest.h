#pragma once

namespace skein::app {

/// Limits that only a typing error exceeds.
inline constexpr double longest_length = 100.0;  ///< [m]
inline constexpr double longest_run = 86400.0;   ///< a day [s]

}  // namespace skein::app
