#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vision/detector/detector.h"
#include "vision/frames/frame.h"
#include "vision/frames/frame_source.h"

namespace skein::vision {

/// One line of an examination.
struct CameraFinding {
  enum class State {
    well,
    note,  // it works, and could be better
    ill,   // robots are lost or measured wrongly
  };
  State state = State::well;
  std::string what{};    // "frame rate"
  std::string found{};   // in a few words
  std::string remedy{};  // empty where it is well
};

/// What is known of a camera without its frames.
struct CameraFacts {
  double needed_rate = 25.0;  // [frames/s]
  TimeStamps stamps = TimeStamps::film;
  double row_time = 0.0;  // of its calibration [s]; 0: not known, or no rolling shutter
};

/// What its frames show. NaN: not measurable.
struct CameraMeasurements {
  std::int64_t frames = 0;
  std::int64_t other_size = 0;  // frames that were left out: their size is not the first one's, or is a few pixels
  double rate = 0.0;            // real; missing frames count [frames/s]
  double stamp_jitter = 0.0;    // rms deviation of stamp intervals from multiples of the usual one [s]
  std::int64_t missing = 0;     // frames, by gaps between stamps
  std::int64_t backwards = 0;   // stamps that are not later than the previous one
  double latency = 0.0;         // from capture to arrival, median [s]
  double latency_p99 = 0.0;     // [s]
  double latency_jitter = 0.0;  // rms about the median [s]
  double flicker = 0.0;         // amplitude, as a part of the brightness: of rows and from frame to frame
  double drift = 0.0;           // largest difference between seconds, as a part of the brightness
  double saturated = 0.0;       // share of pixels at 250 and more
  int brightest = 0;            // 99 % of the pixels are not brighter [grey levels]
  double noise = 0.0;           // of a pixel from frame to frame [grey levels]
  double edge_width = 0.0;  // from dark to bright, at the tags if there are any: contrast through slope, median [px]
  int tags = 0;             // of 36h11, most in a frame
  std::string why_no_tag;   // where there are none: see vision::why_no_tag, of the last frame searched
  double contrast = 0.0;    // between ink and paper, of the faintest tag [grey levels]
  double tag_edge = 0.0;    // of the smallest [px]
};

/// Judges a camera by its frames: rate and regularity of stamps, latency, flicker, exposure, noise, sharpness, and
/// contrast of the tags it sees. The camera must hang still; robots may drive. Clocks are those of the frames.
class CameraExamination {
 public:
  explicit CameraExamination(const CameraFacts& facts) : facts_(facts) {}

  /// About a millisecond a megapixel; keeps a copy of one frame a second, at most ten.
  void add(const Frame& frame);

  /// Searches these copies for tags: up to some seconds.
  CameraMeasurements measure() const;

  /// In the order in which the operator should deal with them.
  std::vector<CameraFinding> judge(const CameraMeasurements& measured) const;

 private:
  CameraFacts facts_;
  std::vector<double> stamps_, latencies_;
  std::vector<std::vector<float>> bands_;  // of each frame: mean brightness of bands of rows
  std::vector<double> noises_;             // of each frame but the first
  std::vector<std::uint8_t> grid_, last_grid_;
  std::size_t grid_columns_ = 0;
  std::vector<Frame> samples_;
  std::int64_t other_size_ = 0;
};

}  // namespace skein::vision
