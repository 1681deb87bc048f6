#pragma once

#include <poll.h>

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "comms/command_slot.h"
#include "comms/link_address.h"
#include "comms/link_options.h"
#include "comms/link_session.h"
#include "comms/link_status.h"
#include "comms/transport.h"

namespace skein::comms {

/// One robot's link inside LinkSupervisor: opens the transport, reopens it when it is lost, and carries bytes between
/// it and the session. All calls except those on `slot` come from the link thread, or while it is blocked.
class Link {
 public:
  Link(LinkAddress address, const LinkOptions& options);

  CommandSlot slot;  ///< filled by the control thread
  /// The nearest command that such a robot can execute; any thread.
  WheelCommand clamped(int left, int right) const noexcept;

  // --- Link thread --------------------------------------------------------------------------------------------------
  pollfd wanted() const noexcept;    ///< what to wait for
  double deadline() const noexcept;  ///< latest time of the next call of turn() [s]
  /// Does all pending work. `events`: reported by poll(); `emergency`: see LinkSupervisor::Loop.
  void turn(short events, std::uint32_t emergency, double now);
  /// For `times`: input was read at `read_at`, output was written by `written_at`.
  void note_times(double read_at, double written_at) noexcept;
  /// Writes nothing until then, but goes on reading; a stop ends it. Tests how a robot behaves without
  /// commands.
  void hush(double until) noexcept { hushed_until_ = until; }
  void stop(double now);                      ///< stop at once; earlier commands are void
  void begin_closing(double now);             ///< stop, accept no more commands, reconnect quickly if necessary
  void fail(std::string reason, double now);  ///< gives up the link
  void end();                                 ///< closes the transport, whatever the robot does

  // --- What is known ------------------------------------------------------------------------------------------------
  const LinkAddress& address() const noexcept { return address_; }
  bool up() const noexcept { return session_->up(); }
  bool failed() const noexcept { return failed_; }
  bool settled() const noexcept;  ///< the newest command is answered or void
  bool may_end() const noexcept;  ///< the robot has acknowledged its stop, or was never reached
  /// While closing: until when to wait for a connection attempt that is under way [s]; 0: none is.
  double worth_waiting_until() const noexcept;
  LinkStatus status(double now) const;
  const RoundTrips& round_trips() const noexcept { return session_->round_trips(); }
  CommandTimes times() const noexcept;  ///< any thread

 private:
  void open(double now);
  void finish_connecting(double now);
  void opened(double now);
  void read(double now);
  void take_command(std::uint32_t emergency, double now);
  void write(double now);
  void lose(const TransportError& error, double now);
  /// The reason for a timed-out attempt: the error of an earlier attempt tells more than the time-out.
  std::string no_connection() const;

  static constexpr double never = std::numeric_limits<double>::infinity();

  LinkAddress address_;
  LinkOptions options_;
  std::optional<Transport> transport_;
  int fastest_;                           // [steps/s]
  std::unique_ptr<LinkSession> session_;  // in the protocol of the address

  double try_at_ = 0.0;  // when to open the transport next
  double wait_;          // time before the attempt after that
  double connecting_until_ = 0.0;
  double opened_at_ = -never;
  std::string refusal_;  // why the newest attempt was refused; empty: none was since the robot last answered
  double hushed_until_ = -never;
  bool reached_ = false;   // was up at least once
  bool reopened_ = false;  // open, and not up since
  bool failed_ = false;
  bool closing_ = false;
  bool ended_ = false;
  std::uint16_t taken_ = 0;   // ticket of the newest command taken from the slot
  std::uint16_t voided_ = 0;  // ticket of the newest command that an emergency stop made void
  std::uint64_t reconnects_ = 0;
  // The inputs of `times`.
  LinkSession::Written written_;
  std::uint16_t answered_ = 0;  // ticket
  std::atomic<double> written_at_{0.0}, answered_at_{0.0}, blind_way_{0.0};
  std::atomic<std::uint32_t> written_speeds_{0};
};

}  // namespace skein::comms
