#pragma once

#include <string_view>

#include "app/calibration/calibration_file.h"
#include "app/calibration/floor_marks_file.h"
#include "tests/fuzz/damage.h"

namespace skein::fuzz {

/// `bytes` as a calibration, and as marks on the floor: what is accepted survives being written and read again.
inline void calibration(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto read = app::parse_calibration(text, "fuzz.toml");
  if (read)
    must_hold(app::parse_calibration(app::format_calibration(*read), "again.toml") == read);
  else
    must_hold(read.error().find("fuzz.toml:") == 0);
  const auto marks = app::parse_floor_marks(text, "fuzz.toml");
  must_hold(marks ? !marks->empty() : marks.error().find("fuzz.toml:") == 0);
}

}  // namespace skein::fuzz
