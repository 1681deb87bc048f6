#pragma once

#include <string>

namespace skein::app {

/// Whether both are names of one file, also through links; not if one of them is empty or names none.
bool same_file(const std::string& a, const std::string& b);

/// The same for files of which neither need be there yet.
bool same_place(const std::string& a, const std::string& b);

/// Whether it is what this program prints to, such as /dev/stdout: then nothing else is to be printed there.
bool is_stdout(const std::string& path);

/// Whether a film or pictures ("video:FILE", "images:DIR") are read from this file; not if it is a calibration among
/// the pictures, nor of a camera.
bool belongs_to_source(const std::string& path, const std::string& source);

}  // namespace skein::app
