#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "comms/link_session.h"

namespace skein::comms {

/// A Khepera IV's serial protocol, over a cable or Bluetooth: K-Team's server on the robot reads lines and answers each
/// with one, "D,l,r" (speeds) "d", "R" (positions) "r,l,r", "V,0" (battery) "v,mV", "B" (version) "b,A,1", and unknown
/// commands with "$". The unit of speed is 0.6781 mm/s, that of position 0.006781 mm.
///
/// It discards input that arrives while it answers. So one line at a time is sent, and a new command waits for the
/// answers to the previous one. It has no watchdog.
inline constexpr WheelUnit khepera_unit{
    .metres_per_step = 0.6781e-3, .fastest = 1200, .most_unconfirmed = 0, .counts_motor_steps = false};
inline constexpr double khepera_charge_below = 6.8;  ///< with less its battery, of two cells, is low [V]

/// A position as a counter of the same unit as the speeds.
std::int16_t khepera_steps(std::int64_t pulses) noexcept;

/// Ends a partial line, and stops both wheels.
std::span<const std::uint8_t> khepera_stop() noexcept;
/// Whether it has taken a speed command.
bool khepera_acknowledged(std::span<const std::uint8_t> heard) noexcept;

/// LinkSession for a Khepera IV. A "d" may answer a line that the stop has completed, while the stop itself was
/// discarded. A robot is known to stand only when the last stop must be among those that it has answered.
class KheperaSession final : public LinkSession {
 public:
  explicit KheperaSession(const LinkOptions& options) : LinkSession(options, khepera_unit) {}

 private:
  void begin() override;
  void put_stop() override;
  void put_request(std::optional<WheelCommand> speeds, Question question) override;
  void hear(std::span<const std::uint8_t> bytes, double now) override;
  void no_answer_to_stop(double now) override;

  void line(std::string_view text, double now);
  void stop_answered(std::string_view text, double now);
  void say(std::string text);
  void come_up(double now);

  std::string heard_;              // the start of a line that has not ended
  std::deque<std::string> lines_;  // to be sent, one after the other
  char awaited_ = 0;               // the letter of the awaited answer; 0: none
  double answered_at_ = 0.0;       // when the newest line was answered, and the next one sent [s]
  int stops_wanted_ = 0;           // answers until the robot is known to stand
  bool version_asked_ = false;
};

}  // namespace skein::comms
