#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "vision/frames/film.h"
#include "vision/frames/frame.h"
#include "vision/frames/frame_source.h"

// The part of vision that needs codecs (OpenCV's for pictures, FFmpeg's for films), a module of its own: linking them
// costs every start of the program 90 ms (GDAL, FFmpeg and some sixty libraries more), also where no picture is ever
// read. Program and module are built together.

namespace skein::vision {

enum class MediaKind { images, video };

/// What a decoder makes of a JPEG.
enum class JpegState {
  whole,
  padded,   ///< a few bytes are left over before a marker: some cameras put them there in every frame, otherwise they
            ///< are what is left of a block that was lost
  damaged,  ///< pixels are missing, or elsewhere
};

struct Media {
  /// Opens a source of this kind; null on failure, with the reason in `error`.
  std::unique_ptr<FrameSource> (*open)(MediaKind kind, const std::string& path, std::string& error);

  /// A JPEG of a camera's MJPEG stream into frame.grey, width and height.
  JpegState (*decode_jpeg)(const std::uint8_t* bytes, std::size_t size, Frame& frame);

  /// Encodes a frame as a JPEG in colour, as cameras do: for measurements. quality: 1 to 100. false: the encoder
  /// refuses it.
  bool (*encode_jpeg)(const Frame& frame, int quality, std::vector<std::uint8_t>& bytes);

  /// Encodes a frame as a PNG. false: the encoder refuses it.
  bool (*encode_png)(const Frame& frame, std::vector<std::uint8_t>& bytes);

  /// See film.h.
  std::unique_ptr<FilmWriter> (*create_film)(const std::string& path, const FilmNotes& notes, FilmCoding coding,
                                             std::string& error);
};

/// The one name that is looked up in the module. It carries a number, to be raised whenever Media, Frame, FrameSource
/// or FilmWriter change, so that a module left over from another version is refused.
inline constexpr const char* media_symbol = "skein_media_10";

}  // namespace skein::vision
