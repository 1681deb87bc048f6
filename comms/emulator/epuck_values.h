#pragma once

#include <array>
#include <cstdint>

namespace skein::comms {

/// What the sensors of an emulated e-puck read: a robot alone on a table.
struct EpuckValues {
  std::array<int, 8> proximity{12, 9, 15, 11, 10, 14, 8, 13};
  std::array<int, 8> ambient{3900, 3905, 3898, 3910, 3902, 3897, 3908, 3901};
  std::array<int, 3> acceleration{2048, 2050, 2870};
  std::uint8_t selector = 3;
};
inline constexpr EpuckValues epuck_alone;

/// A number wrapped to 16 bits.
constexpr int as_int16(int value) {
  return static_cast<std::int16_t>(value);
}

}  // namespace skein::comms
