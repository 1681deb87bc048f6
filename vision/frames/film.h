#pragma once

#include <map>
#include <string>
#include <string_view>

#include "vision/frames/frame.h"

namespace skein::vision {

/// Metadata of a film: short names in capitals (PROGRAM, SOURCE, CALIBRATION), texts of any length.
using FilmNotes = std::map<std::string, std::string>;

/// How a film keeps the pixels.
enum class FilmCoding {
  lossless,  ///< FFV1: every pixel to the bit
  small,     ///< H.264: a tenth of it or less; poses found in it differ a little from those of the frames themselves
};

constexpr std::string_view word(FilmCoding coding) noexcept {
  switch (coding) {
    case FilmCoding::lossless:
      return "lossless";
    case FilmCoding::small:
      return "small";
  }
  return {};
}

/// The note of a film that says how it keeps the pixels; films without it are lossless.
inline constexpr const char* coding_note = "CODING";

/// A film as it is written, frame by frame (Matroska): every frame with its index and its capture time to the bit.
class FilmWriter {
 public:
  virtual ~FilmWriter() = default;
  /// Appends a frame; the first one sets the size. Empty, or the error: then the film ends with the previous frame.
  virtual std::string write(const Frame& frame) = 0;
  /// Completes the file; the same answer.
  virtual std::string finish() = 0;
};

}  // namespace skein::vision
