#include "app/cli/same_file.h"

#include <filesystem>

namespace skein::app {

bool same_file(const std::string& a, const std::string& b) {
  std::error_code not_there;
  return !a.empty() && !b.empty() && std::filesystem::equivalent(a, b, not_there);
}

}  // namespace skein::app
