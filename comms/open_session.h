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
inline constexpr WheelUnit open_unit{.metres_per_step = 1e-4, .fastest = 32767, .counts_motor_steps = false};

/// A parsed frame.
struct OpenFrame {
  char kind = 0;             ///< 'W' speeds, 'X' stop, 's' status ...
  std::uint16_t number = 0;  ///< an answer has that of the answered frame
  std::vector<std::uint8_t> payload;
  std::uint8_t version = 1;  ///< of the protocol
};
std::vector<std::uint8_t> open_frame(char kind, std::uint16_t number, std::span<const std::uint8_t> payload = {});

/// The status of a robot in a frame 's'.
struct OpenStatus {
  bool timed_out = false;  ///< its watchdog has stopped it
  bool refused = false;    ///< it has not executed the answered frame
  bool booted = false;     ///< it has received no stop since power-on
  bool low = false;        ///< its battery
  WheelCommand taken;      ///< [0.1 mm/s]
  Encoders encoders;       ///< the low 16 bits of its wheels' distances [0.1 mm]
  int battery = 0;         ///< [mV]; 0: not known
};
/// None: the frame is not a status of version 1.
std::optional<OpenStatus> open_status(const OpenFrame& frame);

/// Finds frames in a robot's bytes, whatever chunks they arrive in; other bytes are skipped and counted.
class OpenParser {
 public:
  void feed(std::span<const std::uint8_t> bytes) { held_.insert(held_.end(), bytes.begin(), bytes.end()); }
  std::optional<OpenFrame> next();  ///< none: incomplete
  std::size_t pending() const noexcept { return held_.size(); }
  std::uint64_t debris() const noexcept { return debris_; }  ///< [bytes]
  void clear() noexcept { held_.clear(); }

 private:
  std::vector<std::uint8_t> held_;
  std::uint64_t debris_ = 0;
};

/// The bytes that stop any robot with this protocol: the stop twice, longer than the remainder of a partial frame.
std::span<const std::uint8_t> open_stop() noexcept;
/// Whether these bytes contain the answer to open_stop(): a status with its number, 0, which no session uses.
bool open_acknowledged(std::span<const std::uint8_t> heard) noexcept;

/// LinkSession for the open protocol. Commands are sent in every tick, changed or not, so that the robot's watchdog
/// does not stop it; each is answered, and the answer to any command at least as new as the question counts as its
/// answer: a lost datagram costs nothing.
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
  void no_answer_to_stop(double now) override;

  /// Whether a frame with this number was sent, `first` or after it.
  bool sent_since(std::uint16_t first, std::uint16_t number) const noexcept;
  void heard(const OpenFrame& frame, const OpenStatus& said, double now);
  void put(char kind, std::span<const std::uint8_t> payload = {});

  OpenParser parser_;
  std::uint8_t other_version_ = 0;  // that the robot speaks; 0: none but ours
  std::uint16_t number_ = 0;        // of the newest frame
  std::uint16_t first_stop_ = 0;    // of the stops under way
  std::uint16_t question_number_ = 0;
  WheelCommand newest_;
  struct Sent {
    std::uint16_t number = 0;
    WheelCommand speeds;
  };
  std::array<Sent, 16> sent_{};  // frame number k at k % 16
};

}  // namespace skein::comms
