#pragma once

#include <fstream>
#include <ios>
#include <string>

#include "vision/frames/frame.h"

namespace skein::test {

/// The simplest picture format there is.
inline void write_pgm(const std::string& path, const vision::Frame& frame) {
  std::ofstream out(path, std::ios::binary);
  out << "P5\n" << frame.width << " " << frame.height << "\n255\n";
  out.write(reinterpret_cast<const char*>(frame.grey.data()), static_cast<std::streamsize>(frame.grey.size()));
}

}  // namespace skein::test
