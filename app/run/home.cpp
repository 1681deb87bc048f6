#include "app/run/home.h"

#include <pwd.h>
#include <unistd.h>

#include <cstdlib>
#include <vector>

namespace skein::app {

std::string home_folder() {
  if (const char* const home = std::getenv("HOME"); home && *home) return home;
  constexpr std::size_t room = 1 << 16;
  std::vector<char> bytes(room);
  passwd entry{}, *found = nullptr;
  if (::getpwuid_r(::getuid(), &entry, bytes.data(), bytes.size(), &found) != 0 || !found) return {};
  const std::string home = entry.pw_dir ? entry.pw_dir : "";
  return home.starts_with('/') ? home : std::string();
}

}  // namespace skein::app
