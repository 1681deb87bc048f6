#pragma once

namespace skein::comms {

/// Time and distance limits of links. The defaults suit e-pucks over Bluetooth at 25 Hz.
struct LinkOptions {
  /// How far a robot may drive without an answer that confirms its commands, computed with the fastest speed commanded
  /// meanwhile [m]; then it is stopped. For a slow robot this is a longer time. 0.05 m are 0.5 s at 0.1 m/s. 0 or less:
  /// no limit (lock-step runs).
  double blind_distance = 0.05;
  /// A reply later than this counts as lost [s]: the robot is stopped, and the request is repeated. Other drivers wait
  /// up to 10 s; over a busy radio 99.9 % come within 0.25 s.
  double reply_timeout = 0.5;
  /// A stop that is not acknowledged is sent again after this long, then after twice that, and so on up to
  /// `reply_timeout` [s]: radios do not lose it, an e-puck1's receive ring may.
  double stop_repeat = 0.1;
  /// A connection attempt that takes longer than this is restarted [s]. Longer than Bluetooth's own page time-out of
  /// 5.12 s, after which the kernel reports the error.
  double connect_timeout = 6.0;
  /// A link that gets no new command for this long stops its robot by itself [s]: e-pucks have no watchdog. 2.5 ticks,
  /// so one late tick does not stop the group. 0 or less: never (lock-step runs, where wall time means nothing).
  double command_silence = 0.1;
  /// When the program itself stalls for this long (Ctrl-Z, a suspended machine, a debugger), an emergency stop follows:
  /// no robot drives on by itself afterwards [s]. 0 or less: never.
  double standstill = 0.0;
  /// An idle link asks for the encoders this often [s], to detect a robot that dies between runs. 0 or less: never.
  double heartbeat = 1.0;
  /// Wait before the first new attempt to connect, doubled after every failure [s]: EBUSY is frequent at once.
  double reconnect_first = 0.2;
  /// The longest wait between two attempts [s].
  double reconnect_longest = 2.0;
  /// A link that has sent nothing for this long is closed and reopened [s]. Longer than the ~17 s after which Linux
  /// itself detects that a Bluetooth peer has lost power, because until then a new connection cannot be made.
  double silence_reconnect = 20.0;
  /// The battery is requested with this period [s], along with an exchange. 0 or less: never.
  double battery_period = 0.0;
  /// Send speeds in every tick, even unchanged ones: to measure the radio while robots stand.
  bool repeat_speeds = false;
  /// Ask for the firmware's version on each new connection: another robot may answer there.
  bool ask_version = false;
  /// How long the destructor tries to stop the robots when close() was not called [s].
  double close_timeout = 2.0;
};

}  // namespace skein::comms
