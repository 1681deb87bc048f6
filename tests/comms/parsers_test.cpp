// The emulated firmware against what the manufacturer's own parsers answered: fixtures/parsers.txt.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "tests/comms/bytes.h"
#include "tests/places.h"

namespace skein::comms {
namespace {

using test::Bytes;

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  for (std::size_t i = 0; text != "-" && i + 1 < text.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
  return bytes;
}

TEST(EpuckFirmware, AnswersAsTheManufacturersParsers) {
  std::ifstream file(test::in_source("tests/comms/fixtures/parsers.txt"));
  int robots[2] = {0, 0};
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    std::string robot, in, out, motors;
    ASSERT_TRUE(words >> robot >> in >> out >> motors) << line;
    const bool first = robot == "epuck1";
    ++robots[first ? 0 : 1];
    EpuckFirmware firmware(first ? core::MotorModel::epuck1 : core::MotorModel::epuck2);
    EXPECT_EQ(test::ask(firmware, from_hex(in)), from_hex(out)) << line;
    Bytes told;
    for (const double speed : {firmware.told().left, firmware.told().right}) {
      const auto value = static_cast<std::int16_t>(speed);
      told.push_back(static_cast<std::uint8_t>(value & 0xFF));
      told.push_back(static_cast<std::uint8_t>((value >> 8) & 0xFF));
    }
    EXPECT_EQ(told, from_hex(motors)) << line;
  }
  EXPECT_EQ(robots[0], 250);
  EXPECT_EQ(robots[1], 250);
}

}  // namespace
}  // namespace skein::comms
