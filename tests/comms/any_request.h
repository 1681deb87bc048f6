#pragma once

#include <rapidcheck.h>

#include <array>
#include <string>
#include <tuple>
#include <utility>

#include "comms/asercom.h"
#include "tests/comms/bytes.h"

namespace skein::test {

/// One thing that a program might send: sound requests of both kinds, and noise.
inline rc::Gen<Bytes> any_request() {
  const auto speed = rc::gen::inRange<int>(-1500, 1500);
  const auto as_text =
      rc::gen::map(rc::gen::tuple(rc::gen::elementOf(std::string("DEPQSVbNACLBFRGHXdsr")), speed, speed),
                   [](const std::tuple<char, int, int>& request) {
                     const auto& [letter, left, right] = request;
                     return bytes(comms::ascii_request(letter, std::array{left, right}));
                   });
  const auto as_binary = rc::gen::map(rc::gen::pair(speed, speed), [](const std::pair<int, int>& speeds) {
    const auto request = set_and_read(comms::clamped(speeds.first, speeds.second));
    return Bytes(request.begin(), request.end());
  });
  const auto letters = rc::gen::elementOf(Bytes{0xBC, 0xB0, 0xB4, 0xA9, 0x89, 0xAF, 0xBB, 0xB2, 0x9F, 0x9E,
                                                0xF8, 0xF7, 0xF6, 0x80, 0xFF, 0x00, '\r', '\n', 'D',  ','});
  return rc::gen::oneOf(as_text, as_binary, rc::gen::container<Bytes>(letters),
                        rc::gen::container<Bytes>(rc::gen::arbitrary<std::uint8_t>()));
}

}  // namespace skein::test
