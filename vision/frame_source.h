#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "vision/film.h"
#include "vision/frame.h"

namespace skein::vision {

/// Where frames come from.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// The next frame (a camera's newest one, waiting for it). true: here it is; false: the end of the stream.
  virtual tl::expected<bool, std::string> read(Frame& frame) = 0;

  /// For people: what is being read, its size and format where they are known.
  virtual std::string describe() const = 0;

  /// Single pictures, not frames of one film: neighbours need not resemble each other.
  virtual bool stills() const { return false; }

  /// A film that Skein has recorded: captured_at and index of its frames are the ones they had then, to the bit.
  /// Where an index is missing, the recorder dropped the frame.
  virtual bool recorded() const { return false; }

  /// What is said of the film as a whole; of a recorded one, what its Recorder was given.
  virtual const FilmNotes& notes() const {
    static const FilmNotes none;
    return none;
  }

  /// One line, file and reason, for each picture that could not be read and was passed over.
  virtual std::span<const std::string> skipped() const { return {}; }
};

struct SourceOptions {
  int width = 0;      // asked of a camera [px], as a rule the calibration's; 0: as the camera is set
  int height = 0;     // [px]
  double rate = 0.0;  // asked of a camera [frames/s]; 0: as the camera is set
};

/// "images:DIR" or "images:FILE"  png, jpg, pgm, ppm, bmp, tif, sorted by name; captured_at as if 25 were taken a
/// second, since
///                                pictures carry no better time. One that cannot be decoded is skipped (see skipped()).
/// "video:FILE"                   captured_at is the time in the film; of a recorded one, see recorded(). Frames that
/// are
///                                damaged are skipped.
/// "v4l2:DEVICE"                  a camera through the kernel: GREY, YUYV or MJPEG, newest frame only, captured_at is
/// the
///                                driver's CLOCK_MONOTONIC stamp. A camera that stops delivering is an error.
tl::expected<std::unique_ptr<FrameSource>, std::string> open_source(std::string_view source,
                                                                    const SourceOptions& options = {});

}  // namespace skein::vision
