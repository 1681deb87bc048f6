#include "comms/asercom.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace skein::comms {
namespace {

// Binary commands are 256 minus the letter.
constexpr std::uint8_t binary(char letter) {
  return static_cast<std::uint8_t>(256 - letter);
}
constexpr std::uint8_t end_of_sequence = 0x00;
constexpr std::size_t bytes_of_speeds = 4;

constexpr std::uint8_t low(std::int16_t value) {
  return static_cast<std::uint8_t>(value & 0xFF);
}
constexpr std::uint8_t high(std::int16_t value) {
  return static_cast<std::uint8_t>((value >> 8) & 0xFF);
}
std::int16_t little_endian(const std::uint8_t* bytes) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[0] | (bytes[1] << 8)));
}

constexpr std::array<std::uint8_t, 43> make_stop_sequence() {
  std::array<std::uint8_t, 43> bytes{};  // 40 zeros: the longest binary command ('w') takes 35 arguments
  bytes[40] = '\r';
  bytes[41] = 'S';
  bytes[42] = '\r';
  return bytes;
}
constexpr auto the_stop_sequence = make_stop_sequence();

// Longest run of bytes without a line end that is kept; the longest line that a robot says has 63.
constexpr std::size_t longest_line = 4096;

// "s", or "s" behind a late binary answer, which has no line end of its own: some bytes, not all of them text. (Those
// that happen to be are passed over, and the repeated stop gets a line of its own.)
bool says_stopped(std::string_view line) {
  if (line.empty() || line.back() != 's') return false;
  line.remove_suffix(1);
  const auto is_text = [](char c) { return c >= ' ' && c <= '~'; };
  return line.empty() || (line.size() <= longest_answer && !std::all_of(line.begin(), line.end(), is_text));
}

}  // namespace

WheelCommand clamped(int left, int right) noexcept {
  const auto clamp = [](int speed) {
    return static_cast<std::int16_t>(std::clamp(speed, -fastest_motor, fastest_motor));
  };
  return {clamp(left), clamp(right)};
}

std::int16_t steps_between(std::int16_t earlier, std::int16_t later) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(later) - static_cast<std::uint16_t>(earlier));
}

std::vector<std::uint8_t> wheel_request(std::optional<WheelCommand> speeds, Question question) {
  std::vector<std::uint8_t> request;
  request.reserve(longest_request);
  request.assign(bytes_of_speeds, end_of_sequence);
  if (speeds)
    request.insert(request.end(),
                   {binary('D'), low(speeds->left), high(speeds->left), low(speeds->right), high(speeds->right)});
  if (question != Question::none) request.insert(request.end(), {binary('E'), binary('Q')});
  if (question == Question::wheels_and_battery) request.push_back(binary('b'));
  request.push_back(end_of_sequence);
  return request;
}

std::span<const std::uint8_t> stop_sequence() noexcept {
  return the_stop_sequence;
}

std::string ascii_request(char command, std::span<const int> arguments) {
  std::string line(1, command);
  for (const int argument : arguments) line += fmt::format(",{}", argument);
  return line + '\n';
}

ReplyLine parse_reply_line(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == '\n')) line.remove_suffix(1);
  ReplyLine reply;
  reply.text = std::string(line);
  if (line.empty()) return reply;
  reply.letter = line.front();
  line.remove_prefix(1);
  while (line.size() > 1 && line.front() == ',') {
    int value = 0;
    const auto [end, error] = std::from_chars(line.data() + 1, line.data() + line.size(), value);
    if (error != std::errc{}) break;
    reply.values.push_back(value);
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  }
  return reply;
}

bool is_greeting(std::string_view line) noexcept {
  return line.find("SerCom protocol") != std::string_view::npos ||
         line.find("education robot") != std::string_view::npos || line.find("Selector pos") != std::string_view::npos;
}

void ReplyParser::feed(std::span<const std::uint8_t> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

bool ReplyParser::skip_stopped() {
  constexpr std::string_view stopped = "s\r\n";
  if (!pending_text().starts_with(stopped)) return false;
  buffer_.erase(buffer_.begin(), buffer_.begin() + stopped.size());
  return true;
}

std::optional<Reply> ReplyParser::next() {
  switch (expected_) {
    case Expected::nothing:
      return std::nullopt;
    case Expected::lines:
      return next_line();
    case Expected::answer:
      if (buffer_.size() < answer_size_) return std::nullopt;
      Reply reply;
      reply.kind = Reply::Kind::wheels;
      reply.taken = {little_endian(&buffer_[0]), little_endian(&buffer_[2])};
      reply.encoders = {little_endian(&buffer_[4]), little_endian(&buffer_[6])};
      if (answer_size_ == longest_answer) reply.battery = little_endian(&buffer_[8]);
      buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(answer_size_));
      expected_ = Expected::nothing;
      return reply;
  }
  return std::nullopt;
}

std::optional<Reply> ReplyParser::next_line() {
  const auto is_end = [](std::uint8_t byte) { return byte == '\r' || byte == '\n'; };
  while (true) {
    const auto end = std::find_if(buffer_.begin(), buffer_.end(), is_end);
    if (end == buffer_.end()) {
      if (buffer_.size() > longest_line) buffer_.clear();  // nothing that a robot says; do not collect it for ever
      return std::nullopt;
    }
    // The robot ends lines with "\r\n" and nothing else. Insisting on both for the "s" keeps apart the line and a late
    // binary answer whose bytes happen to be 's' '\r'.
    if (*end == '\r' && end + 1 == buffer_.end()) return std::nullopt;  // the "\n" is still to come
    const std::string text(buffer_.begin(), end);
    const bool whole = *end == '\r' && *(end + 1) == '\n';
    buffer_.erase(buffer_.begin(), end + (whole ? 2 : 1));
    if (whole && says_stopped(text))
      return Reply{.kind = Reply::Kind::stopped, .taken = {}, .encoders = {}, .battery = 0, .text = {}};
    if (!text.empty()) return Reply{.kind = Reply::Kind::line, .taken = {}, .encoders = {}, .battery = 0, .text = text};
  }
}

}  // namespace skein::comms
