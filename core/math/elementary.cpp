#include "core/math/elementary.h"

#include <sleef.h>

#include <numbers>

namespace skein::core::math {

double sin(double x) noexcept {
  return Sleef_cinz_sind1_u35purec(x);
}

double cos(double x) noexcept {
  // SLEEF rounds x/pi - 1/2 to an integer, and next to -1/2 on ARM in another way than on x86-64, which gives 1 here.
  if (x <= 0.0 && x > -1.5 * 0x1p-53 * std::numbers::pi) return 1.0;
  return Sleef_cinz_cosd1_u35purec(x);
}

SinCos sincos(double x) noexcept {
  const Sleef_double_2 both = Sleef_cinz_sincosd1_u35purec(x);
  return {both.x, both.y};
}

double tan(double x) noexcept {
  return Sleef_cinz_tand1_u35purec(x);
}

double atan2(double y, double x) noexcept {
  return Sleef_cinz_atan2d1_u35purec(y, x);
}

double exp(double x) noexcept {
  return Sleef_cinz_expd1_u10purec(x);
}

double exp2(double x) noexcept {
  return Sleef_cinz_exp2d1_u35purec(x);
}

double expm1(double x) noexcept {
  return Sleef_cinz_expm1d1_u10purec(x);
}

double log(double x) noexcept {
  return Sleef_cinz_logd1_u35purec(x);
}

double log2(double x) noexcept {
  return Sleef_cinz_log2d1_u35purec(x);
}

double tanh(double x) noexcept {
  return Sleef_cinz_tanhd1_u35purec(x);
}

double pow(double x, double y) noexcept {
  return Sleef_cinz_powd1_u10purec(x, y);
}

}  // namespace skein::core::math
