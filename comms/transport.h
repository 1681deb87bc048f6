#pragma once

#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "comms/crash_stop.h"
#include "comms/link_address.h"
#include "comms/watchdog.h"

namespace skein::comms {

/// Why a link could not be opened or was lost.
struct TransportError {
  std::string reason;      ///< a sentence for the operator
  bool permanent = false;  ///< retrying is useless without a change by the user (no such device, no permission)
};

/// The sentence for an errno value at `address`.
TransportError describe_transport_error(int error, const LinkAddress& address);

/// A byte stream to one robot on a non-blocking descriptor: serial line (raw, 115200 8N1), RFCOMM, TCP or UDP
/// socket (each read or write is one datagram).
/// Move-only; closes on destruction without sending anything. No call blocks. Not thread-safe.
class Transport {
 public:
  /// Opens a serial line, or begins to connect a socket: then connecting() is true until the descriptor is writable and
  /// finish_connecting() has returned the result. A serial line is locked (flock) against a second program. A tcp or
  /// udp address must be resolve()d. `name_holder`: search all programs for the one that has a serial line for itself,
  /// which takes the longer the more files they have open.
  static tl::expected<Transport, TransportError> open(const LinkAddress& address, bool name_holder = true);

  Transport(Transport&& other) noexcept;
  Transport& operator=(Transport&& other) noexcept;
  ~Transport();

  /// What poll() must wait for: input, and also room for output if there is something `to_write`.
  pollfd wanted(bool to_write) const noexcept;
  bool connecting() const noexcept { return connecting_; }
  tl::expected<void, TransportError> finish_connecting();

  /// Sets whether the robot is known to stand: for a crash, see crash_stop.h.
  void set_stands(bool stands) noexcept { crash_entry_.set_stands(stands); }

  /// Number of bytes read into `into`; 0: nothing there now. The error: the link is gone.
  tl::expected<std::size_t, TransportError> read(std::span<std::uint8_t> into);
  /// Number of bytes that the system accepted; 0: it is full now. The error: the link is gone.
  tl::expected<std::size_t, TransportError> write(std::span<const std::uint8_t> bytes);
  /// Of the bytes written, the number that the robot's end is not known to have received; 0 where the system cannot
  /// tell: only TCP can.
  std::size_t undelivered() const noexcept;

 private:
  Transport(int descriptor, bool connecting, LinkAddress address);
  void connected() noexcept;
  bool nothing_came() const noexcept;
  static tl::expected<Transport, TransportError> open_serial(const LinkAddress& address, bool name_holder);
  static tl::expected<Transport, TransportError> open_rfcomm(const LinkAddress& address);
  static tl::expected<Transport, TransportError> open_ip(const LinkAddress& address);

  int descriptor_ = -1;
  int input_ = -1;  // of a terminal: an epoll that is told of its input; -1: none
  bool connecting_ = false;
  LinkAddress address_;
  CrashEntry crash_entry_;    // once connected
  GuardedLine guarded_line_;  // likewise
};

}  // namespace skein::comms
