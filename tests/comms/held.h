#pragma once

#include <malloc.h>

#include <cstddef>
#include <filesystem>

namespace skein::test {

inline long entries(const char* directory) {
  return std::distance(std::filesystem::directory_iterator(directory), std::filesystem::directory_iterator());
}

/// What this process holds now.
struct Held {
  long descriptors = entries("/proc/self/fd");
  long threads = entries("/proc/self/task");
  std::size_t memory = ::mallinfo2().uordblks;  // [bytes]; 0 under the sanitizers
};

}  // namespace skein::test
