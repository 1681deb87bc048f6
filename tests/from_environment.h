#pragma once

#include <cstdlib>

namespace skein::test {

/// The number in this variable of the environment.
inline double number_from_environment(const char* name, double otherwise) {
  const char* const text = std::getenv(name);
  return text ? std::atof(text) : otherwise;
}

}  // namespace skein::test
