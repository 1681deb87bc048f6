#pragma once

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

// Damaged files, and what must hold of those who read them: a broken promise ends the program, which is how a fuzzer
// learns of it.
namespace skein::fuzz {

inline void must_hold(bool holds) {
  if (!holds) std::abort();
}

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

/// Changes at random for `changed`. `random.below(n)` gives a number below n.
template <typename Random>
std::vector<std::uint8_t> random_changes(Random& random, std::size_t file_size) {
  std::vector<std::uint8_t> bytes{1};
  for (std::size_t k = 0; k < 1 + random.below(3); ++k) {
    const std::size_t place = random.below(file_size);
    for (const std::size_t byte : {place % 256, place / 256 % 256, place / 65536, random.below(256)})
      bytes.push_back(static_cast<std::uint8_t>(byte));
  }
  return bytes;
}

}  // namespace skein::fuzz
