// The fuzzers' targets (tests/fuzz) on seeded mutations of real conversations: short, and the same every time.
#include <string>

#include "core/simulation/random.h"
#include "tests/comms/bytes.h"
#include "tests/fuzz/targets.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using test::Bytes;

Bytes mutated(Bytes bytes, core::Random& random) {
  const auto below = [&random](std::size_t limit) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(limit));
  };
  for (std::size_t changes = 1 + below(12); changes > 0; --changes) {
    const auto at = static_cast<std::ptrdiff_t>(below(bytes.size() + 1));
    const auto byte = static_cast<std::uint8_t>(below(256));
    if (bytes.empty() || random.uniform() < 0.4)
      bytes.insert(bytes.begin() + at, byte);
    else if (random.uniform() < 0.5)
      bytes.erase(bytes.begin() + std::min(at, static_cast<std::ptrdiff_t>(bytes.size()) - 1));
    else
      bytes[static_cast<std::size_t>(at) % bytes.size()] = byte;
  }
  return bytes;
}

void run(const std::vector<Bytes>& seeds, void (*target)(std::span<const std::uint8_t>)) {
  core::Random random(20101208, 0);
  for (const Bytes& seed : seeds) {
    target(seed);
    Bytes bytes = seed;
    for (int i = 0; i < 1500; ++i) {
      bytes = mutated(i % 50 == 0 ? seed : bytes, random);  // wander off, and begin again
      target(bytes);
    }
  }
}

TEST(Fuzz, WhateverARobotSays) {
  const std::string greeting = EpuckFirmware(core::MotorModel::epuck1).greeting();
  run({{},
       test::bytes("s\r\n"),
       test::bytes("d\r\nz,Command not found\r\ns\r\n"),
       test::bytes(greeting + "s\r\n"),
       Bytes{'s', '\r', '\n', 1, 2, 3, 4, 's', '\r', '\n', 0, 's', '\r', 0}},
      fuzz::replies);
}

TEST(Fuzz, WhateverAWifiRobotSays) {
  Bytes sensors(105, 0);
  sensors[0] = 0x02;
  run({{}, {0x03}, sensors, Bytes{0x03, 0x03, 0x03, 0x01}}, fuzz::packets);
}

TEST(Fuzz, WhateverAHostSends) {
  const auto stop = stop_sequence();
  const auto set = test::set_and_read({300, -300});
  run({{},
       {stop.begin(), stop.end()},
       {set.begin(), set.end()},
       test::bytes("D,100,-200\nQ\nE\nP,1,2\nV\nb\nR\n"),
       Bytes{0x89, 0xBC, 0x64, 0xF8, 0x00, 0xF7, 1, 2, 3}},
      fuzz::commands);
}

}  // namespace
}  // namespace skein::comms
