#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace skein::test {

/// The words of a process, each with a 0 byte after it. `process`: its folder in /proc. Empty: it has gone, which may
/// happen while it is read.
inline std::string words_of_process(const std::filesystem::path& process) {
  std::ifstream file(process / "cmdline");
  std::ostringstream words;
  words << file.rdbuf();
  return words.str();
}

}  // namespace skein::test
