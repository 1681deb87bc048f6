#pragma once

#include "vision/modules/media.h"

namespace skein::vision::media {

/// 16 bits hold what a sensor measured with 10, 12 or 14, and only some formats of files tell how many. As many count
/// as the brightest pixel needs: read as 16, such a picture would be almost black.
constexpr int bits_used(int brightest) {
  for (const int bits : {10, 12, 14})
    if (brightest < 1 << bits) return bits;
  return 16;
}

/// The pictures of a folder by name, or one picture. A folder without any is an error.
std::unique_ptr<FrameSource> open_images(const std::string& path, std::string& error);

/// A film.
std::unique_ptr<FrameSource> open_video(const std::string& path, std::string& error);

/// Creates a film.
std::unique_ptr<FilmWriter> create_film(const std::string& path, const FilmNotes& notes, FilmCoding coding,
                                        std::string& error);

}  // namespace skein::vision::media
