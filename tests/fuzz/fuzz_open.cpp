// libFuzzer: build with clang and -DSKEIN_FUZZ=ON, run fuzz_open -max_total_time=60.
#include <cstddef>

#include "tests/fuzz/open_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  skein::fuzz::to_open_robot({data, size});
  skein::fuzz::from_open_robot({data, size});
  skein::fuzz::from_khepera({data, size});
  return 0;
}
