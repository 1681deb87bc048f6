#include "comms/open_session.h"

#include <fmt/format.h>

#include <algorithm>

namespace skein::comms {
namespace {

constexpr std::uint8_t version = 1;
constexpr std::size_t head = 7, check = 2, most_payload = 31;
constexpr std::size_t status_size = 15;
constexpr int most_stops = 1000;  // of which any answer counts: a minute of them

/// CRC-16/CCITT-FALSE.
constexpr std::uint16_t check_sum(std::span<const std::uint8_t> bytes) noexcept {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= unsigned{byte} << 8;
    for (int bit = 0; bit < 8; ++bit) crc = ((crc & 0x8000u) != 0 ? crc << 1 ^ 0x1021u : crc << 1) & 0xFFFFu;
  }
  return static_cast<std::uint16_t>(crc);
}

constexpr std::uint16_t get(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}
constexpr std::int16_t get_signed(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<std::int16_t>(get(bytes, at));
}
constexpr std::uint8_t low_byte(unsigned value) noexcept {
  return static_cast<std::uint8_t>(value & 0xFFu);
}
constexpr std::uint8_t high_byte(unsigned value) noexcept {
  return static_cast<std::uint8_t>(value >> 8 & 0xFFu);
}

/// Two stops with the number 0.
constexpr auto two_stops = [] {
  std::array<std::uint8_t, 2 * (head + check)> bytes{};
  for (const std::size_t begin : {std::size_t{0}, head + check}) {
    std::uint8_t* const frame = bytes.data() + begin;
    frame[0] = 'S', frame[1] = 'k', frame[2] = version, frame[3] = 'X';
    const std::uint16_t sum = check_sum(std::span(frame + 2, head - 2));
    frame[head] = low_byte(sum), frame[head + 1] = high_byte(sum);
  }
  return bytes;
}();

/// The size of the frame that begins `bytes`; 0: none does. Needs `head` bytes to distinguish a frame from other bytes.
std::size_t frame_size(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes[0] != 'S' || bytes[1] != 'k' || bytes[6] > most_payload) return 0;
  return head + bytes[6] + check;
}
bool whole(std::span<const std::uint8_t> frame) noexcept {
  return check_sum(frame.subspan(2, frame.size() - 2 - check)) == get(frame, frame.size() - check);
}

}  // namespace

std::vector<std::uint8_t> open_frame(char kind, std::uint16_t number, std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> frame{'S',
                                  'k',
                                  version,
                                  static_cast<std::uint8_t>(kind),
                                  low_byte(number),
                                  high_byte(number),
                                  static_cast<std::uint8_t>(payload.size())};
  frame.insert(frame.end(), payload.begin(), payload.end());
  const std::uint16_t sum = check_sum(std::span(frame).subspan(2));
  frame.push_back(low_byte(sum));
  frame.push_back(high_byte(sum));
  return frame;
}

std::optional<OpenStatus> open_status(const OpenFrame& frame) {
  if (frame.version != version || frame.kind != 's' || frame.payload.size() < status_size) return {};
  const std::span<const std::uint8_t> p = frame.payload;
  return OpenStatus{.timed_out = (p[0] & 1) != 0,
                    .refused = (p[0] & 2) != 0,
                    .booted = (p[0] & 4) != 0,
                    .low = (p[0] & 8) != 0,
                    .taken = {get_signed(p, 1), get_signed(p, 3)},
                    .encoders = {get_signed(p, 5), get_signed(p, 9)},
                    .battery = get(p, 13)};
}

std::optional<OpenFrame> OpenParser::next() {
  std::size_t at = 0;
  std::optional<OpenFrame> found;
  while (!found && held_.size() - at >= head) {
    const auto rest = std::span<const std::uint8_t>(held_).subspan(at);
    const std::size_t size = frame_size(rest);
    if (size > rest.size()) break;
    if (size == 0 || !whole(rest.first(size))) {
      ++at, ++debris_;  // a frame may begin inside what looked like one
      continue;
    }
    found = OpenFrame{
        static_cast<char>(rest[3]), get(rest, 4), {rest.begin() + head, rest.begin() + head + rest[6]}, rest[2]};
    at += size;
  }
  held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(at));
  return found;
}

std::span<const std::uint8_t> open_stop() noexcept {
  return two_stops;
}

bool open_acknowledged(std::span<const std::uint8_t> heard) noexcept {
  for (std::size_t at = 0; at + head + status_size + check <= heard.size(); ++at) {
    const auto rest = heard.subspan(at);
    const std::size_t size = frame_size(rest);
    if (size != head + status_size + check || rest[2] != version || rest[3] != 's' || get(rest, 4) != 0) continue;
    if (!whole(rest.first(size))) continue;
    const auto p = rest.subspan(head);
    if (get(p, 1) == 0 && get(p, 3) == 0) return true;
  }
  return false;
}

void OpenSession::begin() {
  parser_.clear();
  other_version_ = 0;
  newest_ = {};
}

void OpenSession::put(char kind, std::span<const std::uint8_t> payload) {
  if (++number_ == 0) number_ = 1;  // 0 is that of open_stop()
  const std::vector<std::uint8_t> frame = open_frame(kind, number_, payload);
  output_.insert(output_.end(), frame.begin(), frame.end());
}

void OpenSession::put_stop() {
  output_.clear();  // a frame that is broken off ends in the stop, which comes twice
  newest_ = {};
  put('X');
  if (phase_ != Phase::synchronising || static_cast<std::uint16_t>(number_ - first_stop_) > most_stops)
    first_stop_ = number_;
  put('X');
  if (options_.ask_version && counters_.version.empty()) put('H');
}

void OpenSession::put_request(std::optional<WheelCommand> speeds, Question question) {
  newest_ = speeds.value_or(newest_);
  const auto left = static_cast<std::uint16_t>(newest_.left), right = static_cast<std::uint16_t>(newest_.right);
  // A robot that was sent no command since its stop is only asked.
  if (speeds || newest_ != WheelCommand{})
    put('W', std::array{low_byte(left), high_byte(left), low_byte(right), high_byte(right)});
  else
    put('Q');
  sent_[number_ % sent_.size()] = {number_, newest_};
  if (question != Question::none) question_number_ = number_;
}

void OpenSession::hear(std::span<const std::uint8_t> bytes, double now) {
  parser_.feed(bytes);
  while (const auto frame = parser_.next()) {
    if (frame->version != version) {
      other_version_ = frame->version;
    } else if (frame->kind == 'h' && frame->payload.size() >= 6) {
      read_version(std::string(frame->payload.begin() + 6, frame->payload.end()) + ", open protocol");
    } else if (const auto said = open_status(*frame)) {
      heard(*frame, *said, now);
    }
  }
}

void OpenSession::no_answer_to_stop(double now) {
  repeat_stop(now);
  if (other_version_ != 0)
    reason_ = fmt::format("the robot speaks version {} of the open protocol, allowed: {}", other_version_, version);
}

bool OpenSession::sent_since(std::uint16_t first, std::uint16_t number) const noexcept {
  return static_cast<std::uint16_t>(number - first) <= static_cast<std::uint16_t>(number_ - first);
}

void OpenSession::heard(const OpenFrame& frame, const OpenStatus& said, double now) {
  if (phase_ == Phase::synchronising) {
    // Answers to what was sent before the stop, or never, say nothing about it.
    if (!sent_since(first_stop_, frame.number) || said.taken != WheelCommand{}) return;
    stands(now);
    synchronised();
    send_pending(now);
    return;
  }
  if (phase_ != Phase::up) return;
  if (said.booted) {
    resynchronise("the robot restarted", now);
    return restarted();
  }
  const Sent& sent = sent_[frame.number % sent_.size()];
  if (!answer_due() || !sent_since(question_number_, frame.number) || sent.number != frame.number) return;
  read_counters(said.encoders, asked_at_, now);
  if (said.battery > 0) read_battery(Battery{.volts = 1e-3 * said.battery, .low = said.low}, now);
  if (said.taken != sent.speeds)
    answered(said.taken, now);
  else
    answered({}, now);
}

}  // namespace skein::comms
