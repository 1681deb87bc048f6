#pragma once

#include <chrono>
#include <thread>

namespace skein::test {

/// Waits for something that another thread or process does, looking every 2 ms; false: it has not happened by a
/// generous deadline. A loaded machine makes a test slow, not red.
template <typename Condition>
bool eventually(Condition&& condition, std::chrono::seconds deadline = std::chrono::seconds(60)) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace skein::test
