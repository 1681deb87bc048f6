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

// A stop is repeated at least so often: what a robot drives after its radio has come back. [s]
constexpr double longest_stop_wait = 0.2;

// Noise and restarts bring unasked bytes once or twice. An echo and a second robot bring them with every exchange.
constexpr int too_often_unasked = 4;
constexpr double unasked_within = 2.0;  // [s]
constexpr int stops_to_believe = 2;

// A motor may finish the step that it was in when the stop came. [steps]
constexpr int last_step = 1;

}  // namespace

double LinkSession::speed_of(WheelCommand command) const noexcept {
  return unit_.metres_per_step * std::max(std::abs(int{command.left}), std::abs(int{command.right}));
}

void LinkSession::opened(double now) {
  pending_.reset();
  unconfirmed_.reset();
  question_.reset();
  output_.clear();
  undelivered_ = 0;
  owes_reply_ = false;
  garbled_ = false;
  silent_since_ = now;
  stop_acknowledged_ = false;  // another robot may answer
  last_told_.reset();
  reported_.reset();
  counted_at_rest_ = turned_at_rest_ = false;
  begin();
  send_stop(now);
}

void LinkSession::lost(std::string reason, double now) {
  if (up()) down_since_ = now;
  phase_ = Phase::closed;
  pending_.reset();
  unconfirmed_.reset();
  question_.reset();
  output_.clear();
  moving_allowed_ = false;
  // A robot that has acknowledged its stop stands without its link too: it was sent no speed since.
  if (garbled_) stop_acknowledged_ = false;
  garbled_ = false;
  reason_ = std::move(reason);
}

void LinkSession::command(WheelCommand command, std::uint16_t ticket, double now) {
  commanded_at_ = now;
  if (phase_ == Phase::closed) return;
  pending_ = Pending{command, ticket, now};
  next(now);
}

void LinkSession::stop(double now) {
  pending_.reset();
  unconfirmed_.reset();
  // While synchronising a stop is on its way already, and nothing else is sent after it.
  if (phase_ == Phase::closed || phase_ == Phase::synchronising) return;
  stop_acknowledged_ = false;
  send_stop(now);
}

void LinkSession::send_stop(double now) {
  const bool again = phase_ == Phase::synchronising;
  stop_wait_ = again ? std::min({2.0 * stop_wait_, longest_stop_wait, options_.reply_timeout})
                     : std::min(options_.stop_repeat, options_.reply_timeout);
  if (!again) unanswered_since_ = now;
  if (phase_ == Phase::up && !question_) silent_since_ = now;
  if (up()) down_since_ = now;
  count_way(now);
  question_.reset();
  since_stop_ = {};
  put_stop();
  staged_ = {{}, told_ticket_, staged_.count + 1};
  told_.reset();
  phase_ = Phase::synchronising;
  moving_allowed_ = false;
  asked_at_ = now;
}

void LinkSession::repeat_stop(double now) {
  ++counters_.timeouts;
  owes_reply_ = true;
  stops_well_answered_ = 0;
  reason_ =
      since_stop_.echo ? why_doubted() : fmt::format("no answer to the stop within {:.1f} s", now - unanswered_since_);
  send_stop(now);
}

void LinkSession::resynchronise(std::string reason, double now) {
  // A command that was not confirmed is sent again once the robot listens, unless a newer one came, or comes with the
  // next tick anyway: a robot that never takes its commands would be sent the same as fast as it answers.
  if (unconfirmed_ && !pending_ && !options_.repeat_speeds) pending_ = unconfirmed_;
  unconfirmed_.reset();
  stop_acknowledged_ = false;
  owes_reply_ = true;
  reason_ = std::move(reason);
  ++counters_.resynchronisations;
  send_stop(now);
}

void LinkSession::unasked(double now) {
  if (now - unasked_since_ > unasked_within) {
    unasked_since_ = now;
    unasked_ = 0;
  }
  if (++unasked_ >= too_often_unasked) doubt();
  resynchronise("the robot sent unsolicited bytes", now);
}

void LinkSession::doubt() noexcept {
  if (!doubted_) stops_well_answered_ = asked_in_doubt_ = answers_in_doubt_ = 0;
  doubted_ = true;
}

bool LinkSession::stop_hears(std::string_view line, std::string_view answer, std::string_view itself) noexcept {
  const bool echo = !itself.empty() && line == itself;
  if (echo)
    since_stop_.echo = true, doubt();
  else if (!answer.empty() && line == answer)
    ++since_stop_.answers;
  else if (line != "$")  // a Khepera IV may say so of the empty line that a stop begins with
    since_stop_.other = true;
  return !echo;
}

std::string LinkSession::why_doubted() const {
  if (since_stop_.echo) return "the line returns what is sent to it (an echo in its cable, adapter or radio)";
  if (2 * answers_in_doubt_ > 3 * asked_in_doubt_)  // some may have been owed from before
    return "each stop is answered more than once (does another robot hear the same line?)";
  return "the robot sends unsolicited bytes again and again";
}

bool LinkSession::believed(double now) {
  if (!doubted_) return true;
  const bool once = since_stop_.answers == since_stop_.asked && !since_stop_.other && !since_stop_.echo;
  stops_well_answered_ = once ? stops_well_answered_ + 1 : 0;
  if (stops_well_answered_ >= stops_to_believe) {
    doubted_ = false;
    unasked_ = 0;
    return true;
  }
  asked_in_doubt_ += since_stop_.asked;
  answers_in_doubt_ += since_stop_.answers;
  if (!once) reason_ = why_doubted();
  owes_reply_ = true;
  send_stop(now);
  return false;
}

void LinkSession::received(std::span<const std::uint8_t> bytes, double now) {
  if (phase_ == Phase::closed || bytes.empty()) return;
  counters_.bytes_received += bytes.size();
  silent_since_ = now;
  hear(bytes, now);
  if (std::exchange(turned_at_rest_, false) && up())
    resynchronise("the wheels turned though the robot was stopped", now);
}

void LinkSession::restarted() {
  encoders_.reset();
  reason_ = "the robot restarted";
}

void LinkSession::synchronised() {
  phase_ = Phase::up;
  owes_reply_ = false;
}

void LinkSession::stands(double now) {
  stop_acknowledged_ = true;
  unanswered_since_ = now;
  count_way(now);
  confirmed_way_ = way_;
  fastest_ = fastest_since_question_ = 0.0;
}

bool LinkSession::send_pending(double now) {
  if (pending_ && !fresh(*pending_, now)) pending_.reset();
  if (!pending_) return false;
  next(now);
  return true;
}

bool LinkSession::fresh(const Pending& pending, double now) const noexcept {
  return options_.command_silence <= 0.0 || now - pending.given_at < options_.command_silence;
}

void LinkSession::read_counters(Encoders encoders, double since, double now) {
  const bool at_rest = up() && stop_acknowledged_;
  if (encoders_) {
    const int left = steps_between(encoders_->left, encoders.left);
    const int right = steps_between(encoders_->right, encoders.right);
    const double possible = unit_.fastest * (now - encoders_at_) + jump_margin;
    if (std::max(std::abs(left), std::abs(right)) <= possible) {
      counters_.left_steps += left;
      counters_.right_steps += right;
      turned_at_rest_ |= unit_.counts_motor_steps && at_rest && counted_at_rest_ &&
                         std::max(std::abs(left), std::abs(right)) > last_step;
    }
  }
  counted_at_rest_ = at_rest;
  encoders_ = encoders;
  encoders_at_ = now;
  counters_.counted_since = since;
  counters_.counted_by = now;
}

void LinkSession::read_battery(int raw, double now) {
  read_battery(battery_of(raw), now);
}

void LinkSession::read_battery(const Battery& battery, double now) {
  counters_.battery = battery;
  battery_at_ = now;
}

void LinkSession::read_version(std::string text) {
  std::erase_if(text, [](char c) { return c < ' ' || c > '~'; });
  text.resize(std::min(text.size(), longest_version));
  if (!counters_.version.empty() && counters_.version != text)
    reason_ = fmt::format("the robot says that it is \"{}\"; before, it was \"{}\"", text, counters_.version);
  counters_.version = std::move(text);
}

// --- Requests and answers -------------------------------------------------------------------------------------------

void LinkSession::next(double now) {
  if (!up() || !output_.empty()) return;
  if (pending_) {
    if (!question_ || sent_since_question_ < unit_.most_unconfirmed) send(now);
  } else if (!question_ && unconfirmed_) {
    ask(now);
  }
}

void LinkSession::send(double now) {
  const Pending sent = *std::exchange(pending_, std::nullopt);
  if (sent.command != WheelCommand{}) stop_acknowledged_ = false;
  moving_allowed_ = true;
  const bool changed = options_.repeat_speeds || told_ != sent.command;
  count_way(now);
  told_ = last_told_ = sent.command;
  told_ticket_ = sent.ticket;
  unconfirmed_ = sent;
  fastest_ = std::max(fastest_, speed_of(sent.command));
  fastest_since_question_ = std::max(fastest_since_question_, speed_of(sent.command));
  request(changed ? told_ : std::nullopt, !question_, now);
}

void LinkSession::ask(double now) {
  request(std::nullopt, true, now);
}

void LinkSession::request(std::optional<WheelCommand> speeds, bool with_question, double now) {
  const bool battery = options_.battery_period > 0.0 && now - battery_at_ >= options_.battery_period;
  const Question what = !with_question ? Question::none : battery ? Question::wheels_and_battery : Question::wheels;
  staged_ = {told_.value_or(WheelCommand{}), told_ticket_, staged_.count + (speeds ? 1u : 0u)};
  if (speeds || with_question) put_request(speeds, what);
  if (output_.empty()) written_ = staged_;  // nothing to say: the robot has these speeds already
  if (!with_question) {
    ++sent_since_question_;
    return;
  }
  count_way(now);
  question_ = Asked{what, told_, told_ticket_, way_, output_.size()};
  fastest_since_question_ = told_ ? speed_of(*told_) : 0.0;
  sent_since_question_ = 0;
  asked_at_ = silent_since_ = now;
}

void LinkSession::answered(std::optional<WheelCommand> taken, double now) {
  const Asked question = *std::exchange(question_, std::nullopt);
  round_trips_.add(now - asked_at_);
  stop_flight_ = 0.5 * round_trips_.quantile_since_start(0.999);
  ++counters_.exchanges;
  const std::optional<WheelCommand> reported = std::exchange(reported_, taken);
  if (taken && question.told && *taken != *question.told) {
    ++counters_.wrong_speeds;
    return resynchronise(fmt::format("the robot took the speeds {} {} for {} {}", taken->left, taken->right,
                                     question.told->left, question.told->right),
                         now);
  }
  // A robot that was stopped reports the speeds from before the stop, or has restarted.
  const bool known = taken == last_told_ || taken == reported || taken == WheelCommand{};
  if (taken && !question.told && (last_told_ || reported) && !known) {
    ++counters_.wrong_speeds;
    return resynchronise(
        fmt::format("the robot took the speeds {} {} though it was stopped", taken->left, taken->right), now);
  }
  count_way(now);
  confirmed_way_ = question.way;
  fastest_ = fastest_since_question_;
  answered_ticket_ = question.ticket;
  if (unconfirmed_ && unconfirmed_->ticket == answered_ticket_) unconfirmed_.reset();
  next(now);
}

// --- Way without confirmation ---------------------------------------------------------------------------------------

void LinkSession::count_way(double now) noexcept {
  way_ += fastest_ * std::max(0.0, now - way_at_);
  way_at_ = now;
}

double LinkSession::blind_way(double now) const noexcept {
  return way_ - confirmed_way_ + fastest_ * std::max(0.0, now - way_at_);
}

double LinkSession::blind_deadline(double share) const noexcept {
  if (options_.blind_distance <= 0.0 || !moving_allowed_ || fastest_ <= 0.0) return never;
  const double used_up = way_at_ + (share * options_.blind_distance - (way_ - confirmed_way_)) / fastest_;
  // A stop may take as long as the answer that has not come yet.
  const bool answers_known = question_ && stop_flight_ > 0.0;
  return std::min(used_up - stop_flight_, answers_known ? 0.5 * (used_up + asked_at_) : never);
}

// --- Time -----------------------------------------------------------------------------------------------------------

void LinkSession::advance(double now) {
  if (now < deadline()) return;
  switch (phase_) {
    case Phase::closed:
      return;
    case Phase::synchronising:
      return no_answer_to_stop(now);
    case Phase::up:
      break;
  }
  if (question_ && now >= asked_at_ + options_.reply_timeout) {
    ++counters_.timeouts;
    const double asked_at = asked_at_;
    resynchronise(fmt::format("no reply within {:g} s", options_.reply_timeout), now);
    down_since_ = asked_at;  // it was lost when it fell silent, not when that was noticed
  } else if (now >= blind_deadline()) {
    ++counters_.blind_stops;
    resynchronise(
        fmt::format("no reply for {:.3f} s, {:.0f} mm driven: stopped", now - asked_at_, 1e3 * options_.blind_distance),
        now);
  } else if (silence_counts() && now >= commanded_at_ + options_.command_silence) {
    // No commands come any more: the robot must not run on. The stop, not a speed of 0: it is repeated until the robot
    // has acknowledged it.
    reason_ = fmt::format("no command for {:g} s: stopped", options_.command_silence);
    stop_acknowledged_ = false;
    pending_.reset();
    unconfirmed_.reset();
    send_stop(now);
  } else if (!question_ && output_.empty()) {
    ask(now);
  }
}

double LinkSession::deadline() const noexcept {
  switch (phase_) {
    case Phase::closed:
      return never;
    case Phase::synchronising:
      return asked_at_ + stop_wait_;
    case Phase::up: {
      double first = blind_deadline();
      if (silence_counts()) first = std::min(first, commanded_at_ + options_.command_silence);
      if (question_) return std::min(first, asked_at_ + options_.reply_timeout);
      // While the system takes nothing there is nothing to ask; the other deadlines stay. A robot that moves is asked
      // while half of its blind distance is left.
      if (!output_.empty()) return first;
      if (options_.heartbeat > 0.0) first = std::min(first, asked_at_ + options_.heartbeat);
      return std::min(first, blind_deadline(0.5));
    }
  }
  return never;
}

double LinkSession::silent_since() const noexcept {
  return phase_ == Phase::synchronising || question_ ? silent_since_ : never;
}

double LinkSession::out_since() const noexcept {
  return up() ? never : down_since_;
}

void LinkSession::sent(std::size_t bytes, double now) {
  counters_.bytes_sent += bytes;
  output_.erase(output_.begin(), output_.begin() + static_cast<std::ptrdiff_t>(bytes));
  if (question_) question_->unsent -= std::min(question_->unsent, bytes);
  if (!output_.empty()) return;
  written_ = staged_;
  next(now);
}

LinkStatus LinkSession::status(double now) const {
  LinkStatus status = counters_;
  const bool closed = phase_ == Phase::closed;
  status.state = closed        ? LinkState::down
                 : up()        ? LinkState::up
                 : owes_reply_ ? LinkState::stale
                               : LinkState::synchronising;
  status.reason = reason_;
  status.rtt_median = round_trips_.quantile(0.5);
  status.rtt_p99 = round_trips_.quantile(0.99);
  status.rtt_p999 = round_trips_.quantile_since_start(0.999);
  status.blind_way = blind_way(now);
  status.stop_acknowledged = stop_acknowledged_;
  return status;
}

}  // namespace skein::comms
