#pragma once

namespace skein::comms {

/// When links give up, try again and stop by themselves. The defaults suit e-pucks over Bluetooth at 25 Hz.
struct LinkOptions {
  /// How far a robot may drive, at the fastest speed commanded meanwhile, without an answer that confirms its commands
  /// [m]: then it is stopped. A slow robot may wait longer. 0.05 m are 0.5 s at 0.1 m/s. 0 or less: no limit (lock-step
  /// runs).
  double blind_distance = 0.05;
  /// A reply later than this is a lost reply [s]: the robot is stopped and asked again. Drivers in the field wait up to
  /// 10 s; over a radio that is only busy 99.9 % come within 0.25 s.
  double reply_timeout = 0.5;
  /// A stop that is not acknowledged is sent again after this long, then after twice that, and so on up to
  /// `reply_timeout` [s]: radios do not lose it, an e-puck1's receive ring may.
  double stop_repeat = 0.1;
  /// A connection that is not made after this long is begun anew [s]. Longer than Bluetooth's own page time-out of 5.12
  /// s, after which the kernel says what is wrong.
  double connect_timeout = 6.0;
  /// A link that hears no new command for this long stops its robot by itself [s]: e-pucks have no watchdog. 2.5 ticks,
  /// so one late tick does not stop the group. 0 or less: never (lock-step runs, where wall time means nothing).
  double command_silence = 0.1;
  /// When the program itself stood still for this long (Ctrl-Z, a suspended machine, a debugger) that is an emergency
  /// stop: nobody drives on by itself afterwards [s]. 0 or less: never.
  double standstill = 0.0;
  /// An idle link asks for the encoders this often [s], so a robot that dies between runs is noticed. 0 or less: never.
  double heartbeat = 1.0;
  /// Wait before the first new attempt to connect, doubled after every failure [s]. At once often meets EBUSY.
  double reconnect_first = 0.2;
  /// The longest wait between two attempts [s].
  double reconnect_longest = 2.0;
  /// A link that has said nothing for this long is closed and opened again [s]. Longer than the ~17 s after which Linux
  /// itself notices that a Bluetooth peer has lost power, because until then a new connection cannot be made.
  double silence_reconnect = 20.0;
  /// The battery is asked for this often [s], along with an exchange. 0 or less: never.
  double battery_period = 0.0;
  /// Send speeds in every tick, those that the robot has already as well: to measure the radio while robots stand.
  bool repeat_speeds = false;
  /// Ask for the firmware's version when the link comes up for the first time.
  bool ask_version = false;
  /// How long the destructor tries to stop the robots when close() was not called [s].
  double close_timeout = 2.0;
};

}  // namespace skein::comms
