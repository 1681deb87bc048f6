#pragma once

#include <chrono>

namespace skein::test {

/// CLOCK_MONOTONIC [s].
inline double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace skein::test
