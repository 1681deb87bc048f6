#include "comms/link_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
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
  parser_.clear();
  owes_reply_ = false;
  stops_unanswered_ = late_answers_ = 0;
  silent_since_ = now;
  stop_acknowledged_ = false;
  send_stop(now);
}

void LinkSession::lost(std::string reason) {
  phase_ = Phase::closed;
  pending_.reset();
  in_flight_.reset();
  output_.clear();
  moving_allowed_ = false;
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
  if (phase_ != Phase::synchronising) late_answers_ = stops_unanswered_;
  phase_ = Phase::synchronising;
  moving_allowed_ = false;
  // What was not written yet need not be: the stop sequence cuts through a request broken off anywhere. So the output
  // never holds more than one stop, however long the robot takes nothing.
  const auto stop = stop_sequence();
  output_.assign(stop.begin(), stop.end());
  parser_.expect_lines();
  ++stops_unanswered_;
  heard_since_stop_ = false;
  asked_at_ = now;
}

void LinkSession::resynchronise(std::string reason, double now) {
  // A command that got no answer is sent again once the robot listens, unless a newer one came.
  if (in_flight_ && !pending_) pending_ = in_flight_;
  in_flight_.reset();
  stop_acknowledged_ = false;
  owes_reply_ = true;
  reason_ = std::move(reason);
  send_stop(now);
}

void LinkSession::received(std::span<const std::uint8_t> bytes, double now) {
  if (phase_ == Phase::closed || bytes.empty()) return;
  counters_.bytes_received += bytes.size();
  silent_since_ = now;
  parser_.feed(bytes);
  if (phase_ == Phase::synchronising) return read_lines(now);
  while (stops_unanswered_ > 0 && parser_.skip_stopped()) --stops_unanswered_;
  if (parser_.pending() == 0) return;
  // An answer has exactly 4 bytes and comes after the request has gone out.
  if (phase_ == Phase::idle || !output_.empty() || parser_.pending() > encoder_reply_size) return unasked(now);
  if (const auto reply = parser_.next()) exchange_answered(reply->encoders, now);
}

void LinkSession::read_lines(double now) {
  while (phase_ == Phase::synchronising) {
    const auto reply = parser_.next();
    if (!reply) return;
    if (reply->kind == Reply::Kind::stopped)
      stop_answered(now);
    else if (is_greeting(reply->text))
      restarted();
  }
  if (phase_ == Phase::idle && parser_.pending() > 0) unasked(now);
}

void LinkSession::unasked(double now) {
  // Noise, or the greeting of a robot that restarts; what is still to come of either ends before the answer to the
  // stop.
  const bool greeting = is_greeting(parser_.pending_text());
  parser_.clear();
  resynchronise("the robot sent bytes that nobody asked for", now);
  if (greeting) restarted();
}

void LinkSession::restarted() {
  encoders_.reset();
  reason_ = "the robot restarted";
}

void LinkSession::stop_answered(double now) {
  stops_unanswered_ = std::max(0, stops_unanswered_ - 1);
  heard_since_stop_ = true;
  // Answers come in the order of the requests: first those to stops from before the last speed command, which say
  // nothing about it. They must not put off the repetition of a stop that was lost either.
  if (late_answers_ > 0) {
    --late_answers_;
  } else {
    stop_acknowledged_ = true;
    asked_at_ = now;
  }
  // Answers to the repetitions are still to come: wait for them, or they would be taken for answers to requests.
  if (stop_acknowledged_ && stops_unanswered_ == 0 && output_.empty()) synchronised(now);
}

void LinkSession::synchronised(double now) {
  phase_ = Phase::idle;
  owes_reply_ = false;
  if (pending_ && fresh(*pending_, now)) return send_next(now);
  pending_.reset();
  // Were the missing answers lost, or are they late? They would come before the answer to this.
  if (stops_unanswered_ > 0) send_heartbeat(now);
}

bool LinkSession::fresh(const Pending& pending, double now) const noexcept {
  return options_.command_silence <= 0.0 || now - pending.given_at < options_.command_silence;
}

void LinkSession::exchange_answered(Encoders encoders, double now) {
  round_trips_.add(now - asked_at_);
  ++counters_.exchanges;
  stops_unanswered_ = 0;  // what has not come by now is lost
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
  if (in_flight_) answered_ticket_ = in_flight_->ticket;
  in_flight_.reset();
  phase_ = Phase::idle;
  if (pending_) send_next(now);
}

void LinkSession::send_next(double now) {
  if (pending_->command != WheelCommand{}) stop_acknowledged_ = false;
  moving_allowed_ = true;
  in_flight_ = std::exchange(pending_, std::nullopt);
  begin_exchange(set_speeds_read_encoders(in_flight_->command), now);
}

void LinkSession::send_heartbeat(double now) {
  begin_exchange(read_encoders(), now);
}

void LinkSession::begin_exchange(std::span<const std::uint8_t> request, double now) {
  output_.assign(request.begin(), request.end());
  phase_ = Phase::waiting;
  parser_.clear();
  parser_.expect_encoders();
  asked_at_ = now;
  silent_since_ = now;
}

void LinkSession::advance(double now) {
  if (now < deadline()) return;
  switch (phase_) {
    case Phase::closed:
      return;
    case Phase::synchronising:
      // Answers to repetitions are missing.
      if (stop_acknowledged_ && output_.empty()) return synchronised(now);
      // The robot answers, so what it said to older stops would have come by now: it is lost. Waiting for each of them
      // would take as long as the robot was out of reach.
      if (heard_since_stop_) late_answers_ = 0;
      ++counters_.timeouts;
      owes_reply_ = true;
      reason_ = fmt::format("no answer to the stop within {:g} s", options_.reply_timeout);
      return send_stop(now);
    case Phase::waiting:
      ++counters_.timeouts;
      return resynchronise(fmt::format("no reply within {:g} s", options_.reply_timeout), now);
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
  constexpr double never = std::numeric_limits<double>::infinity();
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
  return owes ? silent_since_ : std::numeric_limits<double>::infinity();
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
