#pragma once

#include <cmath>

/// Elementary functions with the same bits on every machine: a run is repeated to the bit wherever it is verified.
/// The C library's are not used for numbers that a record or a replay depends on: it chooses their code by what the
/// processor can do, and changes it from version to version, so that the last digit differs. Source: SLEEF's functions
/// without fused multiply-add, within 3.5 units in the last place. `std::sqrt`, `std::remainder` and `std::fmod` are
/// exact everywhere.
namespace skein::core::math {

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

double sin(double x) noexcept;
double cos(double x) noexcept;
/// Both at the cost of one.
SinCos sincos(double x) noexcept;
double tan(double x) noexcept;
double atan2(double y, double x) noexcept;
double exp(double x) noexcept;
double exp2(double x) noexcept;
double expm1(double x) noexcept;
double log(double x) noexcept;
double log2(double x) noexcept;
double tanh(double x) noexcept;
double pow(double x, double y) noexcept;

inline double squared(double x) noexcept {
  return x * x;
}

/// The root of the sum of squares; of numbers between 1e-150 and 1e150, or 0.
inline double hypot(double x, double y) noexcept {
  return std::sqrt(x * x + y * y);
}
inline double hypot(double x, double y, double z) noexcept {
  return std::sqrt(x * x + y * y + z * z);
}

}  // namespace skein::core::math
