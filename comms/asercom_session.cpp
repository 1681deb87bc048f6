#include "comms/asercom_session.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace skein::comms {
namespace {

/// Whether an answer's first number is no speed that any robot can have taken. That of two letters is above 1100.
bool begins_with_text(std::string_view bytes) noexcept {
  if (bytes.size() < 2) return false;
  const auto low = static_cast<std::uint8_t>(bytes[0]), high = static_cast<std::uint8_t>(bytes[1]);
  return std::abs(static_cast<std::int16_t>(low | high << 8)) > fastest_motor;
}

bool is_zeros(std::string_view line) noexcept {
  return !line.empty() && line.find_first_not_of('\0') == std::string_view::npos;
}

}  // namespace

void AsercomSession::begin() {
  parser_.clear();
  stops_unanswered_ = late_answers_ = 0;
  zeros_returned_ = false;
  version_asked_ = !options_.ask_version;
  version_asked_at_ = -never;
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

void AsercomSession::put_request(std::optional<WheelCommand> speeds, Question question) {
  output_ = wheel_request(speeds, question);
  if (question == Question::none) return;
  parser_.clear();
  parser_.expect_answer(question);
}

void AsercomSession::hear(std::span<const std::uint8_t> bytes, double now) {
  parser_.feed(bytes);
  if (phase_ == Phase::synchronising) return read_lines(now);
  while (stops_unanswered_ > 0 && parser_.skip_stopped()) --stops_unanswered_;
  if (parser_.pending() == 0) return;
  // An answer has exactly so many bytes, and comes after the question has gone out.
  if (!answer_due() || parser_.pending() > answer_size(asked())) return heard_unasked(now);
  const Question question = asked();
  const auto reply = parser_.next();
  if (!reply) {
    // The line "d" answers half a line "D,l,r" that a byte of ours has ended: the robot drives at speeds that were
    // never commanded.
    if (stops_unanswered_ == 0 && begins_with_text(parser_.pending_text())) heard_unasked(now);
    return;
  }
  stops_unanswered_ = 0;  // what has not come by now is lost
  read_counters(reply->encoders, asked_at_, now);
  if (question == Question::wheels_and_battery) read_battery(reply->battery, now);
  answered(reply->taken, now);
}

void AsercomSession::read_lines(double now) {
  while (phase_ == Phase::synchronising) {
    const auto reply = parser_.next();
    if (!reply) return;
    switch (reply->kind) {
      case Reply::Kind::stopped:
        stop_answered(now);
        break;
      case Reply::Kind::line:
        if (is_greeting(reply->text))
          restarted();
        else if (reply->text.starts_with("v,"))
          read_version(reply->text.substr(2));
        else if (reply->text == "S" && zeros_returned_)
          stop_hears("S", {}, "S");
        else
          stop_hears(reply->text, {}, {});
        zeros_returned_ = is_zeros(reply->text);
        break;
      case Reply::Kind::wheels:  // no binary request is sent before the stop is answered
        break;
    }
  }
  if (phase_ == Phase::up && parser_.pending() > 0 && !answer_due()) heard_unasked(now);
}

void AsercomSession::heard_unasked(double now) {
  // Noise, or the greeting of a robot that restarts; what is still to come of either ends before the answer to the
  // stop.
  const bool greeting = is_greeting(parser_.pending_text());
  parser_.clear();
  unasked(now);
  if (greeting) restarted();
}

void AsercomSession::stop_answered(double now) {
  stops_unanswered_ = std::max(0, stops_unanswered_ - 1);
  heard_since_stop_ = true;
  stop_hears("s", "s", {});
  // Answers come in the order of the requests: first those to stops from before the last speed command, which say
  // nothing about it. They must not put off the repetition of a stop that was lost either.
  if (late_answers_ > 0) {
    --late_answers_;
  } else {
    if (!doubted() || !stop_acknowledged_) asked_at_ = now;
    stands(now);
  }
  // Answers to the repetitions are still to come: wait for them, or they would be taken for answers to requests.
  if (!doubted() && stop_acknowledged_ && stops_unanswered_ == 0 && output_.empty()) all_answered(now);
}

void AsercomSession::all_answered(double now) {
  if (!version_asked_) {
    // Once on a link, while the robot stands: its lines end where the answer to the stop behind them begins, however
    // many there are, so that no firmware's version can be taken for an answer to something else.
    version_asked_ = true;
    version_asked_at_ = now;
    send_stop(now);
    const std::string question = ascii_request('V');
    output_.insert(output_.begin(), question.begin(), question.end());
    return;
  }
  synchronised();
  // Were the missing answers lost, or are they late? They would come before the answer to this.
  if (!send_pending(now) && stops_unanswered_ > 0) ask(now);
}

void AsercomSession::no_answer_to_stop(double now) {
  if (stop_acknowledged_ && output_.empty() && doubted()) {
    if (believed(now)) all_answered(now);
    return;
  }
  // Answers to repetitions are missing, over a slow radio perhaps only late: it stands, and may be asked what it is.
  if (stop_acknowledged_ && output_.empty()) {
    if (now >= version_asked_at_ + options_.reply_timeout) return all_answered(now);
    asked_at_ = now;  // what it is may take as long as any answer: later, it would be noise between two others
    return;
  }
  // The robot answers, so what it said to older stops would have come by now: it is lost. Waiting for each of them
  // would take as long as the robot was out of reach.
  if (heard_since_stop_) late_answers_ = 0;
  repeat_stop(now);
}

}  // namespace skein::comms
