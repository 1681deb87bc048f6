#include "comms/asercom_session.h"

#include <algorithm>
#include <string_view>

namespace skein::comms {

void AsercomSession::begin() {
  parser_.clear();
  stops_unanswered_ = late_answers_ = 0;
  version_asked_ = !options_.ask_version || !counters_.version.empty();
}

void AsercomSession::put_stop() {
  if (phase_ != Phase::synchronising) late_answers_ = stops_unanswered_;
  // What was not written yet need not be: the stop sequence cuts through a request broken off anywhere. So the output
  // never holds more than one stop, however long the robot takes nothing.
  const auto stop = stop_sequence();
  output_.assign(stop.begin(), stop.end());
  parser_.expect_lines();
  ++stops_unanswered_;
  heard_since_stop_ = false;
}

void AsercomSession::put_request(std::optional<WheelCommand> speeds, bool battery) {
  if (speeds) {
    const auto request = set_speeds_read_encoders(*speeds);
    output_.assign(request.begin(), request.end());
  } else {
    const auto request = read_encoders();
    output_.assign(request.begin(), request.end());
  }
  if (battery) add_battery(output_);
  with_battery_ = battery;
  parser_.clear();
  parser_.expect_encoders(battery);
}

void AsercomSession::hear(std::span<const std::uint8_t> bytes, double now) {
  parser_.feed(bytes);
  if (phase_ == Phase::synchronising) return read_lines(now);
  while (stops_unanswered_ > 0 && parser_.skip_stopped()) --stops_unanswered_;
  if (parser_.pending() == 0) return;
  // An answer has exactly 4 or 6 bytes and comes after the request has gone out.
  if (phase_ == Phase::idle || !output_.empty() ||
      parser_.pending() > encoder_reply_size + (with_battery_ ? battery_reply_size : 0))
    return unasked(now);
  const auto reply = parser_.next();
  if (!reply) return;
  stops_unanswered_ = 0;  // what has not come by now is lost
  read_counters(reply->encoders, now);
  if (with_battery_) read_battery(reply->battery, now);
  exchange_answered(now);
}

void AsercomSession::read_lines(double now) {
  while (phase_ == Phase::synchronising) {
    const auto reply = parser_.next();
    if (!reply) return;
    if (reply->kind == Reply::Kind::stopped)
      stop_answered(now);
    else if (is_greeting(reply->text))
      restarted();
    else if (reply->text.starts_with("v,"))
      counters_.version = reply->text.substr(2);
  }
  if (phase_ == Phase::idle && parser_.pending() > 0) unasked(now);
}

void AsercomSession::unasked(double now) {
  // Noise, or the greeting of a robot that restarts; what is still to come of either ends before the answer to the
  // stop.
  const bool greeting = is_greeting(parser_.pending_text());
  parser_.clear();
  resynchronise("the robot sent bytes that nobody asked for", now);
  if (greeting) restarted();
}

void AsercomSession::stop_answered(double now) {
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
  if (stop_acknowledged_ && stops_unanswered_ == 0 && output_.empty()) all_answered(now);
}

void AsercomSession::all_answered(double now) {
  if (!version_asked_) {
    // Once on a link, while the robot stands: its lines end where the answer to the stop behind them begins, however
    // many there are, so that no firmware's version can be taken for an answer to something else.
    version_asked_ = true;
    send_stop(now);
    const std::string question = ascii_request('V');
    output_.insert(output_.begin(), question.begin(), question.end());
    return;
  }
  synchronised();
  // Were the missing answers lost, or are they late? They would come before the answer to this.
  if (!send_pending(now) && stops_unanswered_ > 0) send_heartbeat(now);
}

void AsercomSession::no_answer_to_stop(double now) {
  // Answers to repetitions are missing.
  if (stop_acknowledged_ && output_.empty()) {
    version_asked_ = true;  // it does not say, and has been asked
    return all_answered(now);
  }
  // The robot answers, so what it said to older stops would have come by now: it is lost. Waiting for each of them
  // would take as long as the robot was out of reach.
  if (heard_since_stop_) late_answers_ = 0;
  repeat_stop(now);
}

}  // namespace skein::comms
