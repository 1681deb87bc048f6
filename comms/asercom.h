#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The e-puck's serial protocol, "advanced sercom" (asercom): bytes from values and values from bytes, nothing else.
/// Source: the firmware's own parsers (e-puck1 Asercom.c, e-puck2 Asercom2.c). Pure functions; any thread; no
/// exceptions except bad_alloc.
namespace skein::comms {

/// A pair of wheel speeds as the robot takes them. [steps/s], positive drives forward
struct WheelCommand {
  std::int16_t left = 0;
  std::int16_t right = 0;

  friend bool operator==(const WheelCommand&, const WheelCommand&) = default;
};

/// The largest speed of any e-puck: 1100 steps/s, an e-puck2. (An e-puck1's own firmware clamps at 1000.)
inline constexpr int fastest_motor = 1100;

/// The nearest command that a robot can execute; a value outside int16 would otherwise wrap and drive backwards.
WheelCommand clamped(int left, int right) noexcept;

/// A reading of the step counters. They count commanded steps (without slip) and an e-puck1's are 16 bits wide, so only
/// the difference of two readings is meaningful.
struct Encoders {
  std::int16_t left = 0;   ///< [steps]
  std::int16_t right = 0;  ///< [steps]

  friend bool operator==(const Encoders&, const Encoders&) = default;
};

/// Steps from one reading to a later one, correct if less than 32768 steps lie between them.
std::int16_t steps_between(std::int16_t earlier, std::int16_t later) noexcept;

// --- Requests: binary -----------------------------------------------------------------------------------------------

/// What a request asks the robot for.
enum class Question {
  none,               ///< nothing: the robot does not answer
  wheels,             ///< the speeds taken, and the step counters
  wheels_and_battery  ///< the raw battery value (battery_of()) as well
};

/// One binary request: `BC l l r r` sets the speeds as soon as the arguments are in, `BB AF` asks for the speeds taken
/// and for the counters, `9E` for the battery, `00` ends the request. A request with a question is acknowledgement,
/// heartbeat and round-trip probe in one. Four zeros come first, which an idle parser skips: a truncated speed command
/// (the host died, a byte was lost) takes these zeros as its missing speeds. Otherwise it would take the bytes that
/// follow, which could mean full speed.
std::vector<std::uint8_t> wheel_request(std::optional<WheelCommand> speeds, Question question);

inline constexpr std::size_t longest_request = 13;  ///< of wheel_request() [bytes]

/// Bytes in the answer: the speeds (left, right), the counters (left, right), the battery; little-endian int16.
constexpr std::size_t answer_size(Question question) noexcept {
  switch (question) {
    case Question::none:
      return 0;
    case Question::wheels:
      return 8;
    case Question::wheels_and_battery:
      return 10;
  }
  return 0;
}
inline constexpr std::size_t longest_answer = answer_size(Question::wheels_and_battery);

/// The bytes that stop an e-puck whatever partial command its parser is stuck in: 40 x 0x00 end any binary sequence and
/// supply any arguments still awaited, "\r" ends a partial line, "S\r" is the stop. Its answer ends with a line "s";
/// "d", "z,..." and greeting lines may come before. 43 bytes: fits the e-puck1's 64-byte ring behind one exchange.
std::span<const std::uint8_t> stop_sequence() noexcept;

// --- Requests: ASCII ------------------------------------------------------------------------------------------------

/// One line "X\n" or "X,a,b\n". One "\n", never "\r\n": a second line end swallows the first byte of what follows.
std::string ascii_request(char command, std::span<const int> arguments = {});

// --- Replies --------------------------------------------------------------------------------------------------------

/// A parsed reply line: "q,12,-7" is letter 'q', values 12, -7.
struct ReplyLine {
  char letter = 0;          ///< the first character; 0 for an empty line
  std::vector<int> values;  ///< the whole numbers after it, up to other text; "b,3195 (62%)" gives 3195
  std::string text;         ///< the whole line without its end
};
ReplyLine parse_reply_line(std::string_view line);

/// True for a line that a robot sends only when it boots. The start of the line may be missing.
bool is_greeting(std::string_view line) noexcept;

/// One reply, classified.
struct Reply {
  enum class Kind {
    wheels,   ///< the answer to a binary question
    stopped,  ///< the line "s": the robot has executed a stop
    line      ///< any other line: "d", "z,Command not found", a greeting, or debris
  };
  Kind kind = Kind::line;
  WheelCommand taken;  ///< for Kind::wheels: the last speeds that the robot received, as it parsed them
  Encoders encoders;   ///< for Kind::wheels
  int battery = 0;     ///< raw, for Kind::wheels where it was asked for
  std::string text;    ///< for Kind::line, without its end
};

/// Splits the bytes from a robot into replies, whatever chunks they arrive in. The protocol does not mark an answer as
/// binary or text; the sender of the request knows.
class ReplyParser {
 public:
  /// Sets what the next bytes are: text by default, or one binary answer and then nothing.
  void expect_lines() noexcept { expected_ = Expected::lines; }
  void expect_answer(Question question) noexcept {
    answer_size_ = answer_size(question);
    expected_ = answer_size_ == 0 ? Expected::nothing : Expected::answer;
  }

  void feed(std::span<const std::uint8_t> bytes);

  /// The next complete reply. A line "s" is also found after a late binary answer.
  std::optional<Reply> next();

  /// Removes a line "s" from the front, whatever is expected: the late answer to a stop before a binary answer. False:
  /// there is none.
  bool skip_stopped();

  /// Bytes received that are not yet part of a reply; unsolicited if nothing is expected. [bytes]
  std::size_t pending() const noexcept { return buffer_.size(); }
  std::string_view pending_text() const noexcept {
    return {reinterpret_cast<const char*>(buffer_.data()), buffer_.size()};
  }
  void clear() noexcept { buffer_.clear(); }

 private:
  enum class Expected { nothing, lines, answer };
  std::optional<Reply> next_line();

  Expected expected_ = Expected::lines;
  std::size_t answer_size_ = 0;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace skein::comms
