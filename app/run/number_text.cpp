#include "app/run/number_text.h"

#include <fmt/format.h>

namespace skein::app {
namespace {

std::string without_sign_of_zero(std::string text) {
  if (text.front() == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

}  // namespace

std::string fixed(double value, int decimals) {
  return without_sign_of_zero(fmt::format("{:.{}f}", value, decimals));
}

std::string significant(double value, int digits) {
  return without_sign_of_zero(fmt::format("{:.{}g}", value, digits));
}

}  // namespace skein::app
