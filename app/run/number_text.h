#pragma once

#include <string>

namespace skein::app {

/// A number for people, with so many decimals. What rounds to zero has no sign: "0.00", never "-0.00".
std::string fixed(double value, int decimals);
/// The same with at most so many significant digits, as "{:.4g}" prints them.
std::string significant(double value, int digits);

}  // namespace skein::app
