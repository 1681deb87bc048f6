#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/run/tick_record.h"
#include "core/estimation/not_seen.h"

namespace skein::app {

/// The camera's newest frame, for the window.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> grey;  ///< row by row, 0 black
  double captured_at = none;       ///< as the frame's [s]
};

/// A robot's wheel counters, read by it between two times of the session's clock: usually the question and the answer.
struct WheelCount {
  double since = none, by = none;                   ///< [s]; none: never read
  double left = none, right = none;                 ///< [steps]
  double at() const { return 0.5 * (since + by); }  ///< the middle [s]
};

/// The status of one robot's link for the window and the summary.
struct RobotStatus {
  LinkState link = LinkState::simulated;
  std::string reason;                               ///< the newest error
  double round_trip = none, round_trip_p99 = none;  ///< median and 99th percentile of the last 256 [s]
  std::uint64_t exchanges = 0, timeouts = 0, resynchronisations = 0, reconnects = 0;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  double battery = none;           ///< [V]; none: not known, or an old e-puck1, which reports only whether it is low
  bool battery_low = false;        ///< charge it
  std::string battery_text{};      ///< the same in words: "3.90 V", "good", "unknown"
  std::string version{};           ///< of its firmware, as reported; empty: not reported
  WheelCount count{};              ///< newest reading
  bool stop_acknowledged = false;  ///< after close()
};

/// What the marks on the floor show about the cameras that were calibrated with them, and the size of the robots' tags.
struct MarksStatus {
  bool watched = false;  ///< there are marks that can be looked for
  bool known = true;     ///< whether a camera moved; false: not looked at yet, or too few marks are seen
  std::optional<events::CameraMoved> moved{};  ///< a camera has moved
  std::string exchanged{};  ///< two of several cameras have each other's calibration, in words; empty: it does not show
  std::string sentence{};   ///< in words; empty: there is nothing to say
};

/// What a camera sees of a tag that has no pose.
struct UnseenTag {
  int tag = -1;  ///< none: the sentence is about the camera
  core::NotSeen why = core::NotSeen::not_found;
  std::string sentence{};  ///< see vision::sentence; empty: not looked for yet
  double size = none;      ///< its edge on the plane of the tags [m]; none: it was not found
  std::shared_ptr<const Picture>
      picture{};       ///< the part of the frame that shows it, or where it was last seen; or null
  std::string file{};  ///< the same as a PNG; empty: none was written

  /// The sentence, and where its picture is.
  std::string text() const { return file.empty() ? sentence : sentence + " (picture: " + file + ")"; }
};

/// Two cameras that look at one floor.
struct CameraPair {
  std::size_t first = 0, second = 1;  ///< from 0
  bool compared = false;              ///< both have seen a robot at once, since they were opened or since the start
  bool undecided = false;             ///< both see a robot, and whether they go on to see it apart is not known yet
  std::size_t robot = 0;              ///< whom they see `apart`
  double apart = 0.0;                 ///< if they go on to see it more than 5 mm apart; 0: they do not [m]
};

/// What is known about the cameras before a start.
struct CameraStatus {
  std::string down{};                     ///< why they, or some, do not deliver frames; empty: all do
  bool partly = false;                    ///< some do
  MarksStatus marks{};                    ///< on the floor
  std::vector<std::string> automatics{};  ///< "exposure", "gain", "focus": what they set by themselves, unasked
  std::vector<CameraPair> pairs{};        ///< any two of several
  std::vector<std::string> unguarded{};   ///< of several: by what it does not show yet whose a calibration is, and why
  std::vector<UnseenTag> why_lost{};      ///< by robot: why its tag was not seen when that was last looked for
};

/// The result of a check of one robot's wheels.
struct WheelCheck {
  std::size_t robot = 0;
  std::string version{};  ///< of its firmware; empty: not reported
  double battery = none;  ///< [V]; none: not known
  bool battery_low = false;
  int left_steps = 0, right_steps = 0;  ///< of each wheel's counter when only that wheel was commanded
  std::vector<std::string> faults{};    ///< a sentence each; empty: the robot executes its commands
};

/// The film that a session records of its camera's frames.
struct VideoStatus {
  std::int64_t frames = 0;   ///< kept
  std::int64_t dropped = 0;  ///< dropped because the disk or the encoder was too slow, or after the problem
  std::string problem;       ///< why the film ends early; the run goes on
};

}  // namespace skein::app
