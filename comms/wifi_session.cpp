#include "comms/wifi_session.h"

namespace skein::comms {
namespace {

constexpr int most_repetitions = 2;  // of a stop, before the connection is given up

}  // namespace

void WifiSession::begin() {
  parser_.clear();
  newest_ = {};
  unanswered_ = before_stop_ = 0;
  standing_.reset();
}

/// A packet that is partly written must be finished, one that is not begun need not be sent.
void WifiSession::put(WheelCommand command) {
  const std::size_t whole = output_.size() / wifi_command_size;
  output_.resize(output_.size() - whole * wifi_command_size);
  unanswered_ -= static_cast<int>(whole);
  const auto packet = wifi_command(command);
  output_.insert(output_.end(), packet.begin(), packet.end());
  ++unanswered_;
  newest_ = command;
}

void WifiSession::put_stop() {
  put({});
  if (phase_ == Phase::synchronising) return;
  before_stop_ = unanswered_ - 1;
  repetitions_ = 0;
  standing_.reset();
}

void WifiSession::put_request(std::optional<WheelCommand> speeds, bool /*battery*/) {
  put(speeds.value_or(newest_));  // every answer tells the battery
}

void WifiSession::hear(std::span<const std::uint8_t> bytes, double now) {
  parser_.feed(bytes);
  while (const auto packet = parser_.next()) {
    // Only what has been written can be answered: else it is somebody else's robot, or not a robot.
    if (unanswered_ <= static_cast<int>(output_.size() / wifi_command_size))
      return garble("the robot sent a packet that nobody asked for");
    --unanswered_;
    answered(*packet, now);
  }
  if (parser_.garbled()) garble("the robot sent what is no packet: is it an e-puck2 with the WiFi firmware?");
}

void WifiSession::answered(const WifiPacket& packet, double now) {
  if (packet.sensors) {
    read_counters(packet.encoders, now);
    read_battery(packet.battery, now);
  }
  if (phase_ == Phase::waiting) {
    if (unanswered_ == 0) exchange_answered(now);
    return;
  }
  if (before_stop_ > 0) {
    --before_stop_;
    return;
  }
  const bool stands = packet.sensors && standing_ == packet.encoders;
  standing_ = packet.encoders;
  if (stands) stop_acknowledged_ = true;
  if (unanswered_ > 0) return;
  if (!stop_acknowledged_) return send_stop(now);  // once more, to see whether the counters stand
  synchronised();
  send_pending(now);
}

void WifiSession::no_answer_to_stop(double now) {
  // What TCP was given it delivers, or the connection is dead; and a robot that forgot an answer never makes up for it.
  if (++repetitions_ > most_repetitions) return garble("the robot owes answers: connecting anew");
  repeat_stop(now);
}

}  // namespace skein::comms
