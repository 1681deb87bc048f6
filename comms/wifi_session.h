#pragma once

#include "comms/epuck_wifi.h"
#include "comms/link_session.h"

namespace skein::comms {

/// LinkSession with an e-puck2 over WiFi (epuck_wifi.h). There is no request that is not a speed command: the stop is
/// speed 0, the heartbeat repeats the newest speeds. All answers look alike, so they are counted: the connection loses
/// none. An answer may have been put together before its command was carried out, so a robot counts as stopped when
/// two answers to stops show the same counters.
class WifiSession final : public LinkSession {
 public:
  explicit WifiSession(const LinkOptions& options) : LinkSession(options) {}

 private:
  void begin() override;
  void put_stop() override;
  void put_request(std::optional<WheelCommand> speeds, bool battery) override;
  void hear(std::span<const std::uint8_t> bytes, double now) override;
  void no_answer_to_stop(double now) override;

  void answered(const WifiPacket& packet, double now);
  void put(WheelCommand command);

  WifiParser parser_;
  WheelCommand newest_;               // what the robot was told last
  int unanswered_ = 0;                // packets in the output, on their way, or being answered
  int before_stop_ = 0;               // answers that come before the one to the first stop
  int repetitions_ = 0;               // of the newest stop, without an answer
  std::optional<Encoders> standing_;  // counters in the newest answer to a stop
};

}  // namespace skein::comms
