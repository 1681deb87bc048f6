#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "comms/emulator/epuck_firmware.h"
#include "comms/emulator/radio.h"
#include "comms/emulator/radio_faults.h"
#include "core/simulation/random.h"

namespace skein::comms {

/// An emulated e-puck behind a radio, with faults. Bytes and times in, bytes and the time of the next event out: no
/// I/O, no clock, no thread. Every `now` is in seconds on one clock that never goes back. Without faults every answer
/// is there at once. Not thread-safe.
class EmulatedEpuck {
 public:
  /// `faults`: this robot's, in the order in which they begin (faults_of()); their times count from `now`. `seed`:
  /// decides which messages are lost, which bytes change, and how long each message takes.
  EmulatedEpuck(core::MotorModel model, double now, std::vector<Fault> faults = {}, std::uint64_t seed = 0,
                EpuckProgram protocol = EpuckProgram::asercom);

  /// A robot other than an e-puck, with this firmware.
  EmulatedEpuck(std::unique_ptr<RobotFirmware> firmware, double now, std::vector<Fault> faults, std::uint64_t seed);

  /// Sends its messages through an adapter's radio, which other robots share. `adapter` must outlive the robot.
  void connect(RadioAdapter& adapter, std::size_t place) noexcept { adapter_ = &adapter, place_ = place; }

  void receive(std::span<const std::uint8_t> bytes, double now);  ///< the bytes of one write of the host
  void advance(double now);                                       ///< lets time pass: all events due by then happen
  /// The bytes that have reached the host and were not taken yet.
  std::vector<std::uint8_t> take();
  /// The time of the next event that the host does not cause; infinity: none.
  double deadline() const noexcept;

  core::WheelSpeeds wheels() const noexcept { return firmware_->wheels(); }  ///< [steps/s]
  /// The speeds that its firmware last sent to the motors [steps/s], and how often it has sent any.
  core::WheelSpeeds told() const noexcept { return firmware_->told(); }
  std::uint64_t times_told() const noexcept { return firmware_->times_told(); }
  bool connected() const noexcept { return active(FaultKind::disconnect) == nullptr; }  ///< a host can reach it
  /// A host may connect. The WiFi firmware never closes a socket: after ten hosts there is none left until it is
  /// switched off and on.
  bool admits() const noexcept { return connected() && hosts_ < most_hosts; }
  std::uint64_t breaks() const noexcept { return breaks_; }  ///< times that the connection broke
  /// True: a message sent now arrives whole, and within a tick. False: one of the faults may prevent that.
  bool carries() const noexcept;
  /// An answer is on its way that takes more than a tick: over TCP what was lost is sent again after the fault is over.
  bool answers_late() const noexcept;
  /// True: one of the faults may lose or change a message sent now, or over TCP, hold it up. False: it arrives whole,
  /// however late.
  bool loses() const noexcept;
  /// True: a `latency` fault holds up, or may hold up, what is sent to the robot now.
  bool delays() const noexcept { return active(FaultKind::latency) != nullptr || time_ < held_up_until_; }
  /// Switches the robot off and on again at once.
  void reboot();
  /// A host has connected: a partial command of the previous host is discarded if the protocol allows that (WiFi does,
  /// asercom keeps it).
  void accept();

 private:
  struct Message {
    double due;
    std::vector<std::uint8_t> bytes;
  };

  const Fault* active(FaultKind kind) const noexcept;
  bool off() const noexcept { return active(FaultKind::reboot) != nullptr; }
  double next_event() const noexcept;
  void run_event(double now);
  void change_faults(double now);
  void begin(const Fault& fault);
  void end(const Fault& fault);
  void deliver(std::span<const std::uint8_t> bytes, double now);
  void hear(std::span<const std::uint8_t> bytes, double now);
  bool over_tcp() const noexcept { return epuck_ && is_in_packets(epuck_->protocol()); }
  bool lost(std::size_t bytes, double at);
  double carried_at(std::size_t bytes, double now);
  void send(std::deque<Message>& way, std::span<const std::uint8_t> bytes, double now);
  void forget_messages();

  /// The firmware sends unsolicited packets (over WiFi).
  bool streams() const noexcept { return epuck_ && epuck_->streams(); }

  std::unique_ptr<RobotFirmware> firmware_;
  EpuckFirmware* epuck_ = nullptr;  // the same, if it is one
  std::vector<Fault> faults_;
  std::size_t next_fault_ = 0;  // the first fault that has not begun
  std::vector<Fault> active_;   // those under way, in the order in which they began
  RadioAdapter* adapter_ = nullptr;
  std::size_t place_ = 0;
  core::Random random_;
  double start_;
  double held_up_until_ = 0.0;  // by a latency fault, on the way to the robot
  double time_;                 // the time that the robot has reached
  std::uint64_t breaks_ = 0;

  std::deque<Message> to_robot_, to_host_;  // in the air
  std::vector<std::uint8_t> ring_;          // not yet read by the parser; an overflow overwrites it
  double stream_at_ = 0.0;                  // over WiFi: the next round of its loop
  static constexpr int most_hosts = 10;
  int hosts_ = 0;        // over WiFi: connections since it was switched on
  double ring_read_at_;  // when the parser reads it next
};

}  // namespace skein::comms
