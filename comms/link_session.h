#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "comms/asercom.h"
#include "comms/link_options.h"
#include "comms/link_status.h"
#include "comms/round_trips.h"

namespace skein::comms {

/// The conversation with one robot over one link, as a state machine: bytes and times in, bytes and the time of the
/// next deadline out. No I/O, no clock, no thread; LinkSupervisor supplies them. Every `now` is in seconds on one clock
/// that never goes back. Not thread-safe.
///
///     opened --> synchronising --stopped--> idle <--> waiting (one exchange)   a reply that does not come, or
///                     ^ stop,                 |        |                       bytes that nobody asked for, lead back
///                     | repeated              +--------+                       to the stop
///                     +------------------------+
///
/// Here is what all robots have in common; how a stop, an exchange and their answers look, the protocols say:
/// AsercomSession, WifiSession.
class LinkSession {
 public:
  explicit LinkSession(const LinkOptions& options) : options_(options) {}
  virtual ~LinkSession() = default;
  LinkSession(const LinkSession&) = delete;
  LinkSession& operator=(const LinkSession&) = delete;

  // --- What happens to the link -------------------------------------------------------------------------------------
  void opened(double now);  ///< the link is open (again): stop sequence; commands from before are dropped
  void lost(std::string reason, double now);  ///< the link is gone
  void received(std::span<const std::uint8_t> bytes, double now);
  void advance(double now);  ///< lets time pass; call it at deadline() at the latest

  // --- What is asked of the robot -----------------------------------------------------------------------------------
  /// The newest wheel speeds: sent now, or as soon as the outstanding reply is in; a newer one replaces it meanwhile.
  void command(WheelCommand command, std::uint16_t ticket, double now);
  /// The stop, at once whatever is outstanding, repeated until acknowledged; drops commands not yet answered.
  void stop(double now);

  // --- What is to be done -------------------------------------------------------------------------------------------
  std::span<const std::uint8_t> output() const noexcept { return output_; }  ///< bytes to write
  void sent(std::size_t bytes);                                              ///< the first so many are written
  double deadline() const noexcept;                                          ///< infinity: none
  /// What came cannot be understood, and no byte sent can mend that: the link must be opened anew. The reason is in
  /// status().
  bool garbled() const noexcept { return garbled_; }

  // --- What is known ------------------------------------------------------------------------------------------------
  bool open() const noexcept { return phase_ != Phase::closed; }
  bool up() const noexcept { return phase_ == Phase::idle || phase_ == Phase::waiting; }
  bool stop_acknowledged() const noexcept { return stop_acknowledged_; }
  double silent_since() const noexcept;  ///< since when it has owed an answer and said nothing; infinity: it owes none
  /// Since when it has not been up: where it fell silent, since it was asked; infinity: it is.
  double out_since() const noexcept;
  std::uint16_t answered_ticket() const noexcept { return answered_ticket_; }  ///< of the newest command answered
  /// Of the command whose answer is awaited; 0: none is.
  std::uint16_t sent_ticket() const noexcept { return in_flight_ ? in_flight_->ticket : std::uint16_t{0}; }
  LinkStatus status() const;

 protected:
  enum class Phase { closed, synchronising, idle, waiting };
  static constexpr double never = std::numeric_limits<double>::infinity();

  // --- What a protocol says -----------------------------------------------------------------------------------------
  virtual void begin() = 0;     ///< forget what came over the old link
  virtual void put_stop() = 0;  ///< a stop into the output
  virtual void put_request(std::optional<WheelCommand> speeds, bool battery) = 0;  ///< speeds, if any, and counters
  virtual void hear(std::span<const std::uint8_t> bytes, double now) = 0;
  virtual void no_answer_to_stop(double now) = 0;  ///< the time-out while synchronising is over

  // --- What it does with it -----------------------------------------------------------------------------------------
  void send_stop(double now);
  void repeat_stop(double now);  ///< counts the time-out
  void send_heartbeat(double now) { begin_exchange({}, now); }
  void resynchronise(std::string reason, double now);
  void restarted();
  void read_counters(Encoders encoders, double now);
  void read_battery(int raw, double now);
  void exchange_answered(double now);
  void synchronised();            ///< up: the robot stands and listens
  bool send_pending(double now);  ///< the newest command, if there is one and it is still fresh
  void garble(std::string reason) { reason_ = std::move(reason), garbled_ = true; }

  LinkOptions options_;
  Phase phase_ = Phase::closed;
  std::vector<std::uint8_t> output_;
  double asked_at_ = 0.0;  // when the outstanding request or stop was sent
  bool stop_acknowledged_ = false;
  std::string reason_;
  LinkStatus counters_;

 private:
  struct Pending {
    WheelCommand command;
    std::uint16_t ticket = 0;
    double given_at = 0.0;
  };

  void begin_exchange(std::optional<WheelCommand> speeds, double now);
  void send_next(double now);
  bool fresh(const Pending& pending, double now) const noexcept;
  bool silence_counts() const noexcept { return options_.command_silence > 0.0 && moving_allowed_; }

  std::optional<Pending> pending_;    // newest command, not sent yet
  std::optional<Pending> in_flight_;  // the command whose answer is awaited
  double silent_since_ = 0.0;         // the robot was asked then, or said something
  double down_since_ = -never;        // not up since then
  double commanded_at_ = 0.0;         // when the newest command came
  bool moving_allowed_ = false;       // a command was sent and no stop since: command silence must stop the robot
  bool garbled_ = false;
  std::uint16_t answered_ticket_ = 0;

  std::optional<Encoders> encoders_;  // the reading that the next is compared with
  double encoders_at_ = 0.0;
  double battery_at_ = -never;  // when it was read last
  RoundTrips round_trips_;
  bool owes_reply_ = false;  // synchronising because of a reply that did not come
};

}  // namespace skein::comms
