#pragma once

#include <chrono>
#include <thread>

namespace skein::test {

/// Waits until `condition` holds, looking every millisecond; false if it does not within a generous deadline: a loaded
/// machine makes a test slow, not red.
template <typename Condition>
bool wait_until(Condition&& condition, double deadline_s = 10.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(deadline_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace skein::test
