#pragma once

#include "comms/link_session.h"

namespace skein::comms {

/// LinkSession for the asercom protocol (asercom.h): over Bluetooth, a serial line or a pseudo-terminal.
class AsercomSession final : public LinkSession {
 public:
  explicit AsercomSession(const LinkOptions& options) : LinkSession(options) {}

 private:
  void begin() override;
  void put_stop() override;
  void put_request(std::optional<WheelCommand> speeds, Question question) override;
  void hear(std::span<const std::uint8_t> bytes, double now) override;
  void no_answer_to_stop(double now) override;

  void read_lines(double now);
  void heard_unasked(double now);
  void stop_answered(double now);
  void all_answered(double now);

  ReplyParser parser_;
  bool version_asked_ = false;  // on this link
  double version_asked_at_ = -never;
  int stops_unanswered_ = 0;       // stops whose answers may still come
  int late_answers_ = 0;           // how many of these were sent before the last speed command
  bool zeros_returned_ = false;    // those that a stop begins with: an answer has none
  bool heard_since_stop_ = false;  // an answer to a stop came since the newest stop was sent
};

}  // namespace skein::comms
