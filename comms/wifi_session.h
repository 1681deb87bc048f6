#pragma once

#include "comms/epuck_wifi.h"
#include "comms/link_session.h"

namespace skein::comms {

/// LinkSession for an e-puck2 over WiFi (epuck_wifi.h). The robot streams: from the first command on it sends about 45
/// packets per second, whether or not commands come. So answers are not matched to requests, and no packet is
/// unsolicited: the newest packet has the counters, and its age shows whether the robot is alive. A packet may have
/// been composed before a command came; a question counts as answered by the second packet after TCP has delivered it:
/// where commands are lost on their way, packets of a robot that drives on by an older one still come. A stop is
/// confirmed by constant counters. The speeds taken cannot be read back.
///
/// A pause of the stream does not end the connection: the firmware never closes a client's socket and has about ten of
/// them, so every reconnection uses one up until the robot is switched off. Only invalid packets end it: then it is not
/// an e-puck2 with the WiFi firmware.
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
  WheelCommand newest_;               // the last command sent
  bool heard_ = false;                // something, on this connection
  int packets_ = 0;                   // since the newest question or stop was delivered
  std::uint64_t asked_end_ = 0;       // its end in the output
  std::optional<Encoders> standing_;  // counters since the stop
  double standing_since_ = 0.0;       // since when they have not changed [s]
  int changes_ = 0;                   // of these counters
};

}  // namespace skein::comms
