// libFuzzer: build with clang and -DSKEIN_FUZZ=ON, run fuzz_calibration -max_total_time=60.
#include <cstddef>

#include "tests/fuzz/calibration_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  skein::fuzz::calibration({data, size});
  return 0;
}
