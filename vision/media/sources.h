#pragma once

#include "vision/modules/media.h"

namespace skein::vision::media {

/// The pictures of a folder by name, or one picture. A folder without any is an error.
std::unique_ptr<FrameSource> open_images(const std::string& path, std::string& error);

/// A film.
std::unique_ptr<FrameSource> open_video(const std::string& path, std::string& error);

/// Creates a film.
std::unique_ptr<FilmWriter> create_film(const std::string& path, const FilmNotes& notes, FilmCoding coding,
                                        std::string& error);

}  // namespace skein::vision::media
