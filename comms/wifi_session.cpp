#include "comms/wifi_session.h"

namespace skein::comms {
namespace {

constexpr int packets_to_answer = 2;  // the first may be older than the question
// Counters that have not moved for so long belong to a robot that stands: an e-puck2 at 13 steps/s or more, the slowest
// speed that it is given, makes a step at least every 77 ms. [s]
constexpr double stands_after = 0.1;

}  // namespace

void WifiSession::begin() {
  parser_.clear();
  heard_ = false;
  newest_ = {};
  packets_ = changes_ = 0;
  standing_.reset();
}

/// A packet that is partly written must be finished, one that is not begun need not be sent.
void WifiSession::put(WheelCommand command) {
  const std::size_t whole = output_.size() / wifi_command_size;
  output_.resize(output_.size() - whole * wifi_command_size);
  const auto packet = wifi_command(command);
  output_.insert(output_.end(), packet.begin(), packet.end());
  newest_ = command;
}

void WifiSession::put_stop() {
  put({});
  if (phase_ == Phase::synchronising) return;
  packets_ = changes_ = 0;
  asked_end_ = output_end();
  standing_.reset();
}

void WifiSession::put_request(std::optional<WheelCommand> speeds, Question question) {
  put(speeds.value_or(newest_));  // every packet tells the battery
  if (question == Question::none) return;
  packets_ = 0;
  asked_end_ = output_end();
}

void WifiSession::hear(std::span<const std::uint8_t> bytes, double now) {
  heard_ = true;
  parser_.feed(bytes);
  while (const auto next = parser_.next()) packet(*next, now);
  if (parser_.garbled()) garble("the robot sent an invalid packet: is it an e-puck2 with the WiFi firmware?");
}

void WifiSession::packet(const WifiPacket& packet, double now) {
  if (!packet.sensors) return;
  read_counters(packet.encoders, now, now);  // unsolicited: their time in flight is not known
  read_battery(packet.battery, now);
  // What came before the robot had the request says nothing about it.
  if (!output_.empty() || !delivered(asked_end_)) return;
  ++packets_;
  if (phase_ == Phase::up) {
    if (answer_due() && packets_ >= packets_to_answer) answered({}, now);
    return;
  }
  if (packets_ < packets_to_answer) return;
  if (standing_ != packet.encoders) {
    standing_ = packet.encoders;
    standing_since_ = now;
    ++changes_;
    return;
  }
  if (now - standing_since_ < stands_after) return;
  stands(now);
  synchronised();
  send_pending(now);
}

void WifiSession::no_answer_to_stop(double now) {
  // A robot that has just come to a stand needs no other stop, only to be watched a little longer. TCP delivers what it
  // was given, or the connection is dead; and the firmware pauses its stream for a second after a mismatch on its own
  // UART: that is no reason to connect again.
  constexpr int on_their_way = 4;  // packets from before the stop
  const bool streams = standing_ && now < standing_since_ + 2.0 * stands_after;
  if (streams && changes_ <= on_their_way) return void(asked_at_ = now);
  repeat_stop(now);
  if (!heard_) reason_ += ", nor anything else on this connection: does another program drive the robot?";
}

}  // namespace skein::comms
