#pragma once

#include <map>
#include <string>

#include "vision/frames/frame.h"

namespace skein::vision {

/// Metadata of a film: short names in capitals (PROGRAM, SOURCE, CALIBRATION), texts of any length.
using FilmNotes = std::map<std::string, std::string>;

/// A film as it is written, frame by frame: lossless (FFV1 in Matroska), every frame with its index and its capture
/// time to the bit.
class FilmWriter {
 public:
  virtual ~FilmWriter() = default;
  /// Appends a frame; the first one sets the size. Empty, or the error: then the film ends with the previous frame.
  virtual std::string write(const Frame& frame) = 0;
  /// Completes the file; the same answer.
  virtual std::string finish() = 0;
};

}  // namespace skein::vision
