#pragma once

#include <map>
#include <memory>
#include <string>

#include "vision/frame.h"

namespace skein::vision {

/// What is said of a film as a whole: short names in capitals (PROGRAM, SOURCE, CALIBRATION), texts of any length.
using FilmNotes = std::map<std::string, std::string>;

/// A film as it is written, frame by frame: lossless (FFV1 in Matroska), every frame with its index and its capture
/// time to the bit.
class FilmWriter {
 public:
  virtual ~FilmWriter() = default;
  /// Appends a frame; the first one sets the size. Empty, or what went wrong: then the film ends with the frame before.
  virtual std::string write(const Frame& frame) = 0;
  /// Completes the file; the same answer.
  virtual std::string finish() = 0;
};

/// Begins a film, over whatever `path` held before. None: why not is in `error`.
std::unique_ptr<FilmWriter> create_film(const std::string& path, const FilmNotes& notes, std::string& error);

}  // namespace skein::vision
