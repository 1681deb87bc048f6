#include "comms/khepera_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <utility>
#include <vector>

namespace skein::comms {
namespace {

constexpr std::string_view the_stop = "\nD,0,0\n", the_line = "D,0,0";
constexpr std::size_t khepera_answer = 256;

/// The whole numbers behind "r,"; as far as they go.
std::vector<std::int64_t> numbers_in(std::string_view text) {
  std::vector<std::int64_t> numbers;
  for (std::size_t comma = text.find(','); comma != std::string_view::npos; comma = text.find(',', comma + 1)) {
    std::int64_t number = 0;
    const char* const end = text.data() + text.size();
    if (std::from_chars(text.data() + comma + 1, end, number).ec != std::errc{}) break;
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

std::int16_t khepera_steps(std::int64_t pulses) noexcept {
  constexpr std::int64_t pulses_a_step = 100;
  const std::int64_t whole = (pulses - (pulses < 0 ? pulses_a_step - 1 : 0)) / pulses_a_step;  // downwards
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(whole));
}

std::span<const std::uint8_t> khepera_stop() noexcept {
  static constexpr std::array<std::uint8_t, 7> bytes{'\n', 'D', ',', '0', ',', '0', '\n'};
  static_assert(bytes.size() == the_stop.size());
  return bytes;
}

bool khepera_acknowledged(std::span<const std::uint8_t> heard) noexcept {
  constexpr std::array<std::uint8_t, 2> end{'d', '\r'};
  return std::search(heard.begin(), heard.end(), end.begin(), end.end()) != heard.end();
}

void KheperaSession::begin() {
  heard_.clear();
  awaited_ = 0;
  version_asked_ = !options_.ask_version;
}

void KheperaSession::put_stop() {
  lines_.clear();
  // What may be answered with "d" before the stop is: a command that was sent, and a line that was broken off.
  stops_wanted_ = 2 + (awaited_ == 'd' ? 1 : 0);
  output_.assign(the_stop.begin(), the_stop.end());
  awaited_ = 'd';
}

void KheperaSession::say(std::string text) {
  awaited_ = static_cast<char>(std::tolower(static_cast<unsigned char>(text.front())));
  text += '\n';
  output_.assign(text.begin(), text.end());
}

void KheperaSession::put_request(std::optional<WheelCommand> speeds, Question question) {
  lines_.clear();
  if (speeds) lines_.push_back(fmt::format("D,{},{}", speeds->left, speeds->right));
  if (question != Question::none) lines_.emplace_back("R");
  if (question == Question::wheels_and_battery) lines_.emplace_back("V,0");
  if (lines_.empty()) return;
  say(std::exchange(lines_.front(), {}));
  lines_.pop_front();
}

void KheperaSession::hear(std::span<const std::uint8_t> bytes, double now) {
  for (const std::uint8_t byte : bytes) {
    if (byte != '\r' && byte != '\n') {
      if (heard_.size() < khepera_answer) heard_ += static_cast<char>(byte);
      continue;
    }
    const std::string text = std::exchange(heard_, {});
    if (!text.empty()) line(text, now);
  }
}

void KheperaSession::line(std::string_view text, double now) {
  if (phase_ == Phase::synchronising) return stop_answered(text, now);
  if (phase_ != Phase::up) return;
  if (!output_.empty() || awaited_ == 0 || text.front() != awaited_) {
    awaited_ = 0;
    return text == "$" ? resynchronise("the robot did not understand a command", now) : unasked(now);
  }
  const std::vector<std::int64_t> numbers = numbers_in(text);
  if (awaited_ == 'r' && numbers.size() == 2)
    read_counters({khepera_steps(numbers[0]), khepera_steps(numbers[1])}, std::max(asked_at_, answered_at_), now);
  if (awaited_ == 'v' && numbers.size() == 1) {
    const double volts = 1e-3 * static_cast<double>(numbers[0]);
    read_battery(Battery{.volts = volts, .low = volts < khepera_charge_below}, now);
  }
  awaited_ = 0, answered_at_ = now;
  if (!lines_.empty()) {
    say(std::exchange(lines_.front(), {}));
    lines_.pop_front();
    return;
  }
  if (asked() != Question::none) answered({}, now);
}

void KheperaSession::stop_answered(std::string_view text, double now) {
  if (!stop_hears(text, "d", the_line)) return;
  if (stop_acknowledged_ && !doubted() && text.starts_with("b,")) {
    read_version("Khepera IV " + std::string(text.substr(2)));
    return come_up(now);
  }
  if (stops_wanted_ == 0) return;  // the answer to a repetition
  // Whatever the line was, it has been carried out, and what came behind it was thrown away.
  if (text == "d" && --stops_wanted_ == 0) {
    stands(now);
    asked_at_ = now;
    return doubted() ? void() : come_up(now);
  }
  if (output_.empty()) stop_asks(), say(std::string(the_line));
  asked_at_ = now;
}

void KheperaSession::come_up(double now) {
  if (!std::exchange(version_asked_, true)) return asked_at_ = now, say("B");
  awaited_ = 0;
  synchronised();
  send_pending(now);
}

void KheperaSession::no_answer_to_stop(double now) {
  if (!stop_acknowledged_) return repeat_stop(now);
  if (believed(now)) come_up(now);  // perhaps it does not say its version
}

}  // namespace skein::comms
