#include "comms/link_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace skein::comms {
namespace {

// More steps than the motors can have made since the last reading mean that the counters were set anew (a restart). The
// margin lets runs through whose own clock goes faster than ours.
constexpr double jump_margin = 2000;  // [steps]

}  // namespace

void LinkSession::opened(double now) {
  pending_.reset();
  in_flight_.reset();
  output_.clear();
  owes_reply_ = false;
  garbled_ = false;
  silent_since_ = now;
  stop_acknowledged_ = false;
  begin();
  send_stop(now);
}

void LinkSession::lost(std::string reason, double now) {
  if (up()) down_since_ = now;
  phase_ = Phase::closed;
  pending_.reset();
  in_flight_.reset();
  output_.clear();
  moving_allowed_ = false;
  garbled_ = false;
  stop_acknowledged_ = false;  // it may have moved on: whoever was last heard need not be who answers next
  reason_ = std::move(reason);
}

void LinkSession::command(WheelCommand command, std::uint16_t ticket, double now) {
  commanded_at_ = now;
  if (phase_ == Phase::closed) return;
  pending_ = Pending{command, ticket, now};
  if (phase_ == Phase::idle) send_next(now);
}

void LinkSession::stop(double now) {
  pending_.reset();
  in_flight_.reset();
  // While synchronising a stop is on its way already, and nothing else is sent after it.
  if (phase_ == Phase::closed || phase_ == Phase::synchronising) return;
  stop_acknowledged_ = false;
  send_stop(now);
}

void LinkSession::send_stop(double now) {
  if (phase_ == Phase::idle) silent_since_ = now;
  if (up()) down_since_ = now;
  put_stop();
  phase_ = Phase::synchronising;
  moving_allowed_ = false;
  asked_at_ = now;
}

void LinkSession::repeat_stop(double now) {
  ++counters_.timeouts;
  owes_reply_ = true;
  reason_ = fmt::format("no answer to the stop within {:g} s", options_.reply_timeout);
  send_stop(now);
}

void LinkSession::resynchronise(std::string reason, double now) {
  // A command that got no answer is sent again once the robot listens, unless a newer one came.
  if (in_flight_ && !pending_) pending_ = in_flight_;
  in_flight_.reset();
  stop_acknowledged_ = false;
  owes_reply_ = true;
  reason_ = std::move(reason);
  ++counters_.resynchronisations;
  send_stop(now);
}

void LinkSession::received(std::span<const std::uint8_t> bytes, double now) {
  if (phase_ == Phase::closed || bytes.empty()) return;
  counters_.bytes_received += bytes.size();
  silent_since_ = now;
  hear(bytes, now);
}

void LinkSession::restarted() {
  encoders_.reset();
  reason_ = "the robot restarted";
}

void LinkSession::synchronised() {
  phase_ = Phase::idle;
  owes_reply_ = false;
}

bool LinkSession::send_pending(double now) {
  if (pending_ && fresh(*pending_, now)) {
    send_next(now);
    return true;
  }
  pending_.reset();
  return false;
}

bool LinkSession::fresh(const Pending& pending, double now) const noexcept {
  return options_.command_silence <= 0.0 || now - pending.given_at < options_.command_silence;
}

void LinkSession::read_counters(Encoders encoders, double now) {
  if (encoders_) {
    const int left = steps_between(encoders_->left, encoders.left);
    const int right = steps_between(encoders_->right, encoders.right);
    const double possible = fastest_motor * (now - encoders_at_) + jump_margin;
    if (std::max(std::abs(left), std::abs(right)) <= possible) {
      counters_.left_steps += left;
      counters_.right_steps += right;
    }
  }
  encoders_ = encoders;
  encoders_at_ = now;
}

void LinkSession::read_battery(int raw, double now) {
  counters_.battery = battery_of(raw);
  battery_at_ = now;
}

void LinkSession::exchange_answered(double now) {
  round_trips_.add(now - asked_at_);
  ++counters_.exchanges;
  if (in_flight_) answered_ticket_ = in_flight_->ticket;
  in_flight_.reset();
  phase_ = Phase::idle;
  if (pending_) send_next(now);
}

void LinkSession::send_next(double now) {
  if (pending_->command != WheelCommand{}) stop_acknowledged_ = false;
  moving_allowed_ = true;
  in_flight_ = std::exchange(pending_, std::nullopt);
  begin_exchange(in_flight_->command, now);
}

void LinkSession::begin_exchange(std::optional<WheelCommand> speeds, double now) {
  const bool battery = options_.battery_period > 0.0 && now - battery_at_ >= options_.battery_period;
  put_request(speeds, battery);
  phase_ = Phase::waiting;
  asked_at_ = now;
  silent_since_ = now;
}

void LinkSession::advance(double now) {
  if (now < deadline()) return;
  switch (phase_) {
    case Phase::closed:
      return;
    case Phase::synchronising:
      return no_answer_to_stop(now);
    case Phase::waiting:
      ++counters_.timeouts;
      resynchronise(fmt::format("no reply within {:g} s", options_.reply_timeout), now);
      down_since_ = silent_since_;  // it was lost when it fell silent, not when that was noticed
      return;
    case Phase::idle: {
      if (silence_counts()) {
        // Nobody commands any more: the robot must not run on. The stop, not a speed of 0: its answer says that the
        // robot has understood it, that to a speed damaged on the way looks like any other.
        reason_ = fmt::format("no command for {:g} s: stopped", options_.command_silence);
        stop_acknowledged_ = false;
        return send_stop(now);
      }
      return send_heartbeat(now);
    }
  }
}

double LinkSession::deadline() const noexcept {
  switch (phase_) {
    case Phase::closed:
      return never;
    case Phase::synchronising:
    case Phase::waiting:
      return asked_at_ + options_.reply_timeout;
    case Phase::idle:
      if (silence_counts()) return commanded_at_ + options_.command_silence;
      return options_.heartbeat > 0.0 ? asked_at_ + options_.heartbeat : never;
  }
  return never;
}

double LinkSession::silent_since() const noexcept {
  const bool owes = phase_ == Phase::synchronising || phase_ == Phase::waiting;
  return owes ? silent_since_ : never;
}

double LinkSession::out_since() const noexcept {
  return up() ? never : down_since_;
}

void LinkSession::sent(std::size_t bytes) {
  counters_.bytes_sent += bytes;
  output_.erase(output_.begin(), output_.begin() + static_cast<std::ptrdiff_t>(bytes));
}

LinkStatus LinkSession::status() const {
  LinkStatus status = counters_;
  status.state = phase_ == Phase::closed ? LinkState::down
                 : up()                  ? LinkState::up
                 : owes_reply_           ? LinkState::stale
                                         : LinkState::synchronising;
  status.reason = reason_;
  status.rtt_median = round_trips_.quantile(0.5);
  status.rtt_p99 = round_trips_.quantile(0.99);
  status.stop_acknowledged = stop_acknowledged_;
  return status;
}

}  // namespace skein::comms
