#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "comms/link_session.h"

namespace skein::comms {

/// The open protocol (docs/open-protocol.md), host's side. The robot's is resources/robots/open_robot.
inline constexpr WheelUnit open_unit{.metres_per_step = 1e-4, .fastest = 32767};

/// A frame taken apart.
struct OpenFrame {
  char kind = 0;             ///< 'W' speeds, 'X' stop, 's' status ...
  std::uint16_t number = 0;  ///< an answer has that of what it answers
  std::vector<std::uint8_t> payload;
};
std::vector<std::uint8_t> open_frame(char kind, std::uint16_t number, std::span<const std::uint8_t> payload = {});

/// What a robot says of itself in a frame 's'.
struct OpenStatus {
  bool timed_out = false;  ///< its watchdog has stopped it
  bool refused = false;    ///< it has not obeyed what this answers
  bool booted = false;     ///< it has heard no stop since it was switched on
  bool low = false;        ///< its battery
  WheelCommand taken;      ///< [0.1 mm/s]
  Encoders encoders;       ///< the low 16 bits of what its wheels have rolled [0.1 mm]
  int battery = 0;         ///< [mV]; 0: it does not know
};
/// None: the frame is no status.
std::optional<OpenStatus> open_status(const OpenFrame& frame);

/// Finds frames in what a robot sends, whatever chunks it arrives in; bytes that are none are passed over and counted.
class OpenParser {
 public:
  void feed(std::span<const std::uint8_t> bytes) { held_.insert(held_.end(), bytes.begin(), bytes.end()); }
  std::optional<OpenFrame> next();  ///< none: not yet whole
  std::size_t pending() const noexcept { return held_.size(); }
  std::uint64_t debris() const noexcept { return debris_; }  ///< [bytes]
  void clear() noexcept { held_.clear(); }

 private:
  std::vector<std::uint8_t> held_;
  std::uint64_t debris_ = 0;
};

/// What stops any robot that speaks the protocol: the stop twice, longer than what a frame broken off can still want.
std::span<const std::uint8_t> open_stop() noexcept;
/// Whether the answer to a stop is in there.
bool open_acknowledged(std::span<const std::uint8_t> heard) noexcept;

/// LinkSession with a robot that speaks the open protocol. Every command is sent in every tick, changed or not, so that
/// the robot's watchdog does not bite; each is answered, and the answer to any command that is as new as the question
/// settles it: a datagram that is lost costs nothing.
class OpenSession final : public LinkSession {
 public:
  explicit OpenSession(const LinkOptions& options) : LinkSession(fed(options), open_unit) {}

 private:
  static LinkOptions fed(LinkOptions options) {
    options.repeat_speeds = true;
    return options;
  }
  void begin() override;
  void put_stop() override;
  void put_request(std::optional<WheelCommand> speeds, Question question) override;
  void hear(std::span<const std::uint8_t> bytes, double now) override;
  void no_answer_to_stop(double now) override { repeat_stop(now); }

  void heard(const OpenFrame& frame, const OpenStatus& said, double now);
  void put(char kind, std::span<const std::uint8_t> payload = {});

  OpenParser parser_;
  std::uint16_t number_ = 0;      // of the newest frame
  std::uint16_t first_stop_ = 0;  // of the stops under way
  std::uint16_t question_number_ = 0;
  WheelCommand newest_;
  struct Sent {
    std::uint16_t number = 0;
    WheelCommand speeds;
  };
  std::array<Sent, 16> sent_{};  // frame number k at k % 16
};

}  // namespace skein::comms
