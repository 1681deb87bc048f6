#pragma once

#include "comms/epuck_wifi.h"
#include "comms/link_session.h"

namespace skein::comms {

/// LinkSession with an e-puck2 over WiFi (epuck_wifi.h). The robot streams: from the first command on it sends about 45
/// packets a second, whether or not commands come. So nothing is counted, and no packet is unexpected: the newest one
/// says where the counters are, and its age says whether the robot lives. A packet may have been put together before a
/// command came; a question counts as answered by the second packet after it. A stop is confirmed by counters that
/// stand still. Speeds that were taken cannot be asked for.
///
/// Nothing that the robot sends, or fails to send, ends the connection: the firmware never closes a client's socket and
/// has about ten of them, so every reconnection uses one up until the robot is switched off. Only bytes that are no
/// packets do: that is no e-puck2 with the WiFi firmware.
class WifiSession final : public LinkSession {
 public:
  explicit WifiSession(const LinkOptions& options) : LinkSession(options) {}

 private:
  void begin() override;
  void put_stop() override;
  void put_request(std::optional<WheelCommand> speeds, Question question) override;
  void hear(std::span<const std::uint8_t> bytes, double now) override;
  void no_answer_to_stop(double now) override;

  void packet(const WifiPacket& packet, double now);
  void put(WheelCommand command);

  WifiParser parser_;
  WheelCommand newest_;               // what the robot was told last
  int packets_ = 0;                   // since the newest question or stop was sent
  std::optional<Encoders> standing_;  // counters since the stop
  double standing_since_ = 0.0;       // they have not changed
  int changes_ = 0;                   // of these counters
};

}  // namespace skein::comms
