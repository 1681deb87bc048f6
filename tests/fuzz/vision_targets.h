#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "vision/calibrate/floor_calibration.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/film.h"
#include "vision/frames/frame_source.h"

// What must hold of the readers of files, whatever is in the file; a broken promise ends the program, which is how a
// fuzzer learns of it.
namespace skein::fuzz {

inline void must_hold(bool holds) {
  if (!holds) std::abort();
}

using Opener = std::function<std::unique_ptr<vision::FrameSource>(const std::string& path)>;

inline void write_bytes(const std::string& path, std::span<const std::uint8_t> bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline std::vector<std::uint8_t> read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// `bytes` as changes to a file that is well: three for the place, one for the new value. The first says whether they
/// are the file itself instead; 254 and 255 of a new value cut the file there.
inline std::vector<std::uint8_t> changed(std::span<const std::uint8_t> well, std::span<const std::uint8_t> bytes) {
  if (bytes.empty() || bytes[0] % 4 == 0) return {bytes.begin(), bytes.end()};
  std::vector<std::uint8_t> file(well.begin(), well.end());
  for (std::size_t i = 1; i + 3 < bytes.size() && !file.empty(); i += 4) {
    const std::size_t place = (bytes[i] + 256U * bytes[i + 1] + 65536U * bytes[i + 2]) % file.size();
    if (bytes[i + 3] >= 254)
      file.resize(place);
    else
      file[place] = bytes[i + 3];
  }
  return file;
}

/// The frames of a small film: times that a container would round, indices with a gap.
inline std::vector<vision::Frame> small_film() {
  std::vector<vision::Frame> frames(4);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    vision::Frame& frame = frames[k];
    frame.resize(48, 32);
    for (std::size_t i = 0; i < frame.grey.size(); ++i)
      frame.grey[i] = static_cast<std::uint8_t>((i * 7 + (i / 48) * 13 + k * 31) ^ (i >> 3));
    frame.index = static_cast<std::int64_t>(k < 2 ? k : k + 3);
    frame.captured_at = 17.0 + 0.1 * static_cast<double>(k) / 3.0;
  }
  return frames;
}

/// Reads a file to its end. Frames are whole; what was passed over is said; of a recorded film, every frame is one that
/// was recorded, to the bit.
inline void frames(const std::string& path, const Opener& open, const std::vector<vision::Frame>& recorded) {
  const auto source = open(path);
  if (!source) return;
  vision::Frame frame;
  for (int k = 0; k < 1000; ++k) {
    const auto more = source->read(frame);
    if (!more || !*more) break;
    must_hold(frame.width > 0 && frame.height > 0);
    must_hold(frame.grey.size() == static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
    must_hold(std::isfinite(frame.captured_at));
    if (!source->recorded()) continue;
    bool known = false;
    for (const vision::Frame& one : recorded)
      known = known || (one.index == frame.index && one.captured_at == frame.captured_at && one.grey == frame.grey);
    must_hold(known);
  }
  for (const std::string& line : source->skipped()) must_hold(line.find(path) == 0);
}

/// `bytes` as a calibration, and as marks on the floor: what is accepted survives being written and read again.
inline void calibration(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto read = vision::parse_calibration(text, "fuzz.toml");
  if (read)
    must_hold(vision::parse_calibration(vision::format_calibration(*read), "again.toml") == read);
  else
    must_hold(read.error().find("fuzz.toml:") == 0);
  const auto marks = vision::parse_floor_marks(text, "fuzz.toml");
  must_hold(marks ? !marks->empty() : marks.error().find("fuzz.toml:") == 0);
}

}  // namespace skein::fuzz
