#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "vision/frames/film.h"
#include "vision/frames/frame.h"

namespace skein::vision {

/// The status of a source, mainly of a camera.
struct SourceStatus {
  bool up = true;                         // false: the camera does not deliver, and is opened again and again
  std::int64_t outages = 0;               // times that it stopped delivering: unplugged, stalled
  std::int64_t damaged = 0;               // frames that were skipped because they were damaged
  std::int64_t passed_over = 0;           // intact frames that were skipped because a newer one was there
  std::string reason{};                   // of the last outage
  std::vector<std::string> notices{};     // what it did not do as requested, a sentence each
  std::vector<std::string> remarks{};     // on how a film's pictures are read, where players show them otherwise
  std::vector<std::string> automatics{};  // which of "exposure", "gain", "focus" it sets by itself, unasked
};

/// The origin of a source's time stamps. From a camera's stamp its source computes captured_at, the middle of the first
/// row's exposure, as far as exposure and read-out are known.
enum class TimeStamps {
  exposure_start,  // CLOCK_MONOTONIC, the camera's driver, when the shutter opened
  first_packet,    // CLOCK_MONOTONIC, the driver, when the frame began to arrive: later than its first row's exposure
  frame_end,       // CLOCK_MONOTONIC, the driver, when the frame was complete: later than its exposure and read-out
  arrival,         // CLOCK_MONOTONIC, when the frame was handed over: later still, by a time that varies
  film,            // the time in a film
  nominal,         // pictures have no times: counted at 25 per second
};

/// Where frames come from.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// How its frames are stamped. For a camera this may be known only once a frame has come.
  virtual TimeStamps stamps() const = 0;

  /// The next frame (a camera's newest one, waiting for it). true: here it is; false: the end of the stream.
  virtual tl::expected<bool, std::string> read(Frame& frame) = 0;

  /// A description for the operator: what is being read, its size and format where they are known.
  virtual std::string describe() const = 0;

  /// Single pictures, not frames of one film: neighbours need not resemble each other.
  virtual bool stills() const { return false; }

  /// A film that Skein has recorded: captured_at and index of its frames are the ones they had then, to the bit.
  /// Where an index is missing, the recorder dropped the frame.
  virtual bool recorded() const { return false; }

  /// Metadata of the film; of a recorded one, those given to its Recorder.
  virtual const FilmNotes& notes() const {
    static const FilmNotes none;
    return none;
  }

  /// Any thread, at any time.
  virtual SourceStatus status() const { return {}; }

  /// One line, file and reason, for each picture that could not be read and was passed over.
  virtual std::span<const std::string> skipped() const { return {}; }
};

/// Names and values, as in "exposure=0.005".
using ControlSettings = std::vector<std::pair<std::string, double>>;

struct SourceOptions {
  int width = 0;          // requested from a camera [px], usually the calibration's; 0: as the camera is set
  int height = 0;         // [px]
  double rate = 0.0;      // requested from a camera [frames/s]; 0: as the camera is set
  std::string format{};   // requested from a camera: "MJPG", "BayerRG8"; empty: the cheapest that gives size and rate
  std::string trigger{};  // what makes a camera take a frame: "software" (`rate` times a second, by the source), or
                          // one of its lines ("Line1"); empty: its own clock
  ControlSettings controls{};  // of a camera, see set_controls; set again whenever it is opened again
  double readout = 0.0;        // of a rolling shutter, from its first row to its last [s]
  double reopen_for = 10.0;    // how long a camera that stops delivering is reopened before that is an error [s]
  std::function<bool()> keep_waiting{};  // asked while a camera does not deliver: false ends the stream
};

}  // namespace skein::vision
