#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// Shared by a run and its guard, so that the guard can stop the robots of a frozen run: heartbeats of the run's
/// threads in a page of shared memory, and duplicates of the descriptors of its lines, sent over a socket.
namespace skein::comms {

inline constexpr std::size_t most_hearts = 16, most_lines = 128, longest_stop = 64;

/// The page. All times are CLOCK_MONOTONIC [ns].
struct HeartbeatPage {
  struct Heart {
    std::atomic<std::int64_t> beat{0};   ///< the newest; 0: not used
    std::atomic<std::int64_t> limit{0};  ///< a longer silence stops the robots [ns]
  };
  std::array<Heart, most_hearts> hearts;
  std::atomic<std::int64_t> guard{0};          ///< the guard's own heartbeat; 0: it has not begun
  std::atomic<std::int32_t> guard_process{0};  ///< likewise
};

/// A message of the run to its guard, one datagram each; a page and a line carry a descriptor.
struct GuardMessage {
  enum class Kind : std::uint8_t {
    page,         ///< the memory of a HeartbeatPage
    line_opened,  ///< a line to a robot, and the bytes that stop it
    line_closed,  ///< close the duplicate: a robot accepts one connection at a time
    all_is_well,  ///< every robot is known to stand: the guard may end
  };
  Kind kind = Kind::all_is_well;
  std::uint8_t place = 0;  ///< of the line, below most_lines
  std::uint8_t size = 0;   ///< of the stop
  std::array<std::uint8_t, longest_stop> stop{};
  std::array<char, 256> address{};  ///< of the robot on the line, as to_text() writes it, ended by 0
};

/// Sends a message without blocking, with a descriptor unless it is -1. False: the other end is gone or does not read.
bool send_to_guard(int socket, const GuardMessage& message, int descriptor) noexcept;

/// CLOCK_MONOTONIC [ns]. Async-signal-safe.
std::int64_t monotonic_ns() noexcept;

/// Watches a thread during its lifetime: the thread must beat regularly. At most most_hearts at a time: others are not
/// watched.
class Heart {
 public:
  explicit Heart(double longest_silence_s) noexcept;
  ~Heart();
  Heart(const Heart&) = delete;
  Heart& operator=(const Heart&) = delete;
  void beat() noexcept;  ///< one atomic store and one read of the clock

 private:
  int place_ = -1;
};

/// Heartbeats go to this page, and every line that is open now or opened later is sent to the guard at the other end of
/// `socket`, until detach_guard(socket). One guard at a time: the newest. The caller keeps page and socket.
void attach_guard(int socket, HeartbeatPage& page);
void detach_guard(int socket) noexcept;

/// Registers an open line to a robot with the guard during its lifetime. Move-only. For Transport.
class GuardedLine {
 public:
  GuardedLine() noexcept = default;
  /// `stop`: the bytes that stop the robot, at most longest_stop.
  GuardedLine(int descriptor, std::span<const std::uint8_t> stop, std::string_view address) noexcept;
  GuardedLine(GuardedLine&& other) noexcept;
  GuardedLine& operator=(GuardedLine&& other) noexcept;
  ~GuardedLine();

 private:
  int place_ = -1;
};

}  // namespace skein::comms
