#pragma once

#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comms/asercom.h"
#include "comms/link_options.h"
#include "comms/link_status.h"
#include "comms/round_trips.h"

namespace skein::comms {

/// The unit in which a robot counts its wheels' motion.
struct WheelUnit {
  double metres_per_step = std::numbers::pi * 0.041 / 1000.0;  ///< of every e-puck, to a few per cent [m]
  int fastest = fastest_motor;                                 ///< largest command to any such robot [steps/s]
  /// The largest number of unconfirmed commands while a question is pending. Together with a question they stay below
  /// the 58 bytes that an e-puck1 can receive at once, in case the radio delays them all, and below the five commands
  /// at which an e-puck2 over WiFi discards all but the newest.
  int most_unconfirmed = 4;
  /// What it counts are the steps of its own motors, so that a robot whose count changes drives. Encoders also count
  /// wheels that coast, settle, or are turned by hand.
  bool counts_motor_steps = true;
};

/// The conversation with one robot over one link, as a state machine: bytes and times in, bytes and the time of the
/// next deadline out. No I/O, no clock, no thread; LinkSupervisor supplies them. Every `now` is in seconds on one clock
/// that never goes back. Not thread-safe.
///
///     opened --> synchronising --stopped--> up
///                 ^   ^    |                |
///                 |   +----+ stop repeated  |
///                 +-------------------------+
///
/// A missing answer, an answer that does not fit the request, unsolicited bytes, too long a distance on unconfirmed
/// commands, wheels that turn after the stop, and silence of the control thread lead from up back to the stop.
///
/// While the link is up, new speeds are written at once. A question (speeds taken, counters) is sent along unless an
/// older one is still unanswered; the answer confirms every command up to the question. This class is common to all
/// robots; the protocols define the bytes of stops, requests and answers: AsercomSession, WifiSession.
class LinkSession {
 public:
  explicit LinkSession(const LinkOptions& options, const WheelUnit& unit = {}) : options_(options), unit_(unit) {}
  virtual ~LinkSession() = default;
  LinkSession(const LinkSession&) = delete;
  LinkSession& operator=(const LinkSession&) = delete;

  // --- What happens to the link -------------------------------------------------------------------------------------
  void opened(double now);  ///< the link is open (again): stop sequence; commands from before are dropped
  void lost(std::string reason, double now);  ///< the link is gone
  void received(std::span<const std::uint8_t> bytes, double now);
  /// So many of the bytes that were sent are not known to have reached the robot, see Transport. To be called before
  /// the bytes are read that `received` gets.
  void undelivered(std::size_t bytes) noexcept { undelivered_ = bytes; }
  void advance(double now);  ///< lets time pass; call it at deadline() at the latest

  // --- What is asked of the robot -----------------------------------------------------------------------------------
  /// The newest wheel speeds. Written now, unless the system still holds bytes or `most_unconfirmed` commands have no
  /// answer: then a newer one may replace them. Unchanged speeds are not sent again (an e-puck1 loses part of a step
  /// with every speed command); the next question confirms them.
  void command(WheelCommand command, std::uint16_t ticket, double now);
  /// Sends the stop at once whatever is outstanding, repeats it until acknowledged; drops commands not yet answered.
  void stop(double now);

  // --- What is to be done -------------------------------------------------------------------------------------------
  std::span<const std::uint8_t> output() const noexcept { return output_; }  ///< bytes to write
  void sent(std::size_t bytes, double now);                                  ///< the first so many are written
  double deadline() const noexcept;                                          ///< infinity: none
  /// The input is invalid, and no further output can repair that: the link must be reopened. The reason is in status().
  bool garbled() const noexcept { return garbled_; }

  // --- What is known ------------------------------------------------------------------------------------------------
  bool open() const noexcept { return phase_ != Phase::closed; }
  bool up() const noexcept { return phase_ == Phase::up; }
  bool stop_acknowledged() const noexcept { return stop_acknowledged_; }
  double silent_since() const noexcept;  ///< since when an answer is due and nothing came; infinity: none is due
  /// Since when it has not been up; if it fell silent, since the unanswered request; infinity: it is up.
  double out_since() const noexcept;
  std::uint16_t answered_ticket() const noexcept { return answered_ticket_; }  ///< of the newest command answered
  /// The bytes last written to the system. A stop counts as speeds of 0.
  struct Written {
    WheelCommand speeds;
    std::uint16_t ticket = 0;  ///< of the newest command contained in it
    std::uint64_t count = 0;   ///< how many writes there were
  };
  const Written& written() const noexcept { return written_; }
  /// How far the faster wheel may have rolled since the newest answered question was sent: at the fastest of the speeds
  /// commanded since then. 0 for a robot that is known to stand. [m]
  double blind_way(double now) const noexcept;
  LinkStatus status(double now) const;
  const RoundTrips& round_trips() const noexcept { return round_trips_; }

  static constexpr int most_unconfirmed = WheelUnit{}.most_unconfirmed;

 protected:
  enum class Phase { closed, synchronising, up };
  static constexpr double never = std::numeric_limits<double>::infinity();

  // --- What a protocol defines ---------------------------------------------------------------------------------------
  virtual void begin() = 0;     ///< discard input from the old link
  virtual void put_stop() = 0;  ///< puts a stop into the output
  /// Puts speeds, if any, and a question, if any, into the output, which is empty before.
  virtual void put_request(std::optional<WheelCommand> speeds, Question question) = 0;
  virtual void hear(std::span<const std::uint8_t> bytes, double now) = 0;
  virtual void no_answer_to_stop(double now) = 0;  ///< the time-out while synchronising has expired

  // --- What it does with it -----------------------------------------------------------------------------------------
  void send_stop(double now);
  void repeat_stop(double now);  ///< counts the time-out
  /// Bytes came that nobody had asked for. Again and again: it is doubted whether the line says what the robot says.
  void unasked(double now);
  /// While that is doubted, the link does not come up: a robot would be told by turns to drive and to stop. It comes up
  /// when two stops in a row, and all that is sent with them, were answered exactly once.
  bool doubted() const noexcept { return doubted_; }
  void doubt() noexcept;
  /// With the stop another line is sent that is answered once.
  void stop_asks() noexcept { ++since_stop_.asked; }
  /// A line came. False: it is what was sent, `itself`, which no robot says.
  bool stop_hears(std::string_view line, std::string_view answer, std::string_view itself) noexcept;
  /// For the time-out of a stop that is acknowledged. False: the line is doubted further, and the stop is sent again.
  bool believed(double now);
  void ask(double now);  ///< a question, no speeds
  void resynchronise(std::string reason, double now);
  void restarted();
  /// The robot has read them between `since`, when it was asked, and now.
  void read_counters(Encoders encoders, double since, double now);
  void read_battery(int raw, double now);
  void read_battery(const Battery& battery, double now);
  /// Of what the robot says, what can be printed in a line that files and tables have room for.
  void read_version(std::string text);
  /// The question is answered. `taken`: the speeds reported by the robot; a difference leads to the stop.
  void answered(std::optional<WheelCommand> taken, double now);
  void stands(double now);        ///< the newest stop is acknowledged
  void synchronised();            ///< up: the robot stands and listens
  bool send_pending(double now);  ///< the newest command, if there is one and it is still fresh
  void garble(std::string reason) { reason_ = std::move(reason), garbled_ = true; }
  /// A question is completely written and not answered.
  bool answer_due() const noexcept { return question_ && question_->unsent == 0; }
  Question asked() const noexcept { return question_ ? question_->what : Question::none; }
  /// The end of all output so far, and whether the robot may have got everything up to there. [bytes]
  std::uint64_t output_end() const noexcept { return counters_.bytes_sent + output_.size(); }
  bool delivered(std::uint64_t end) const noexcept { return counters_.bytes_sent >= end + undelivered_; }

  LinkOptions options_;
  WheelUnit unit_;
  Phase phase_ = Phase::closed;
  std::vector<std::uint8_t> output_;
  std::size_t undelivered_ = 0;  // of the bytes sent
  double asked_at_ = 0.0;        // when the newest question or stop was sent
  bool stop_acknowledged_ = false;
  std::string reason_;
  LinkStatus counters_;

 private:
  struct Pending {
    WheelCommand command;
    std::uint16_t ticket = 0;
    double given_at = 0.0;
  };
  struct Asked {
    Question what = Question::none;
    std::optional<WheelCommand> told;  // speeds that the robot should have taken by then
    std::uint16_t ticket = 0;          // of the newest command sent before it or with it
    double way = 0.0;                  // way_ at that moment
    std::size_t unsent = 0;            // bytes of it in the output
  };

  void next(double now);
  void send(double now);
  void request(std::optional<WheelCommand> speeds, bool with_question, double now);
  void count_way(double now) noexcept;
  /// Of the faster wheel [m/s].
  double speed_of(WheelCommand command) const noexcept;
  /// The time at which a stop must be written so that it arrives when this share of the blind distance is used up.
  double blind_deadline(double share = 1.0) const noexcept;
  bool fresh(const Pending& pending, double now) const noexcept;
  bool silence_counts() const noexcept { return options_.command_silence > 0.0 && moving_allowed_; }

  std::optional<Pending> pending_;         // newest command, not sent yet
  std::optional<Pending> unconfirmed_;     // newest command that was sent and is not confirmed
  std::optional<WheelCommand> told_;       // the last command sent; none: a stop was sent since, or no command yet
  std::optional<WheelCommand> last_told_;  // on this link: as told_, but a stop leaves it as it is
  std::optional<WheelCommand> reported_;   // the speeds that the robot last said it had taken
  std::uint16_t told_ticket_ = 0;
  std::optional<Asked> question_;
  int sent_since_question_ = 0;
  double silent_since_ = 0.0;      // time of the last request or input
  double down_since_ = -never;     // not up since then
  double commanded_at_ = 0.0;      // time of the newest command
  bool moving_allowed_ = false;    // a command was sent and no stop since: command silence must stop the robot
  double stop_wait_ = 0.0;         // until the stop is sent again [s]
  double unanswered_since_ = 0.0;  // the first stop after which none was answered
  bool garbled_ = false;
  std::uint16_t answered_ticket_ = 0;
  Written staged_, written_;  // in the output; gone

  double way_ = 0.0, confirmed_way_ = 0.0;  // of the faster wheel, as commanded [m]
  double way_at_ = 0.0;                     // until when way_ is counted
  double fastest_ = 0.0;                    // since the last confirmed question [m/s]
  double fastest_since_question_ = 0.0;     // since the newest question [m/s]
  double stop_flight_ = 0.0;                // time that a stop needs to arrive, from the round trips so far [s]

  struct SinceStop {
    int asked = 1, answers = 0;  // how many
    bool other = false;          // lines that are none
    bool echo = false;
  };
  std::string why_doubted() const;

  SinceStop since_stop_;  // the newest
  bool doubted_ = false;
  int asked_in_doubt_ = 0, answers_in_doubt_ = 0;
  int stops_well_answered_ = 0;  // in a row, while doubted
  int unasked_ = 0;              // times, since
  double unasked_since_ = -never;

  std::optional<Encoders> encoders_;  // the previous reading
  bool counted_at_rest_ = false;      // it was of a robot that had acknowledged its stop
  bool turned_at_rest_ = false;       // the newest differs from it all the same
  double encoders_at_ = 0.0;
  double battery_at_ = -never;  // when it was read last
  RoundTrips round_trips_;
  bool owes_reply_ = false;  // synchronising because of a missing reply
};

}  // namespace skein::comms
