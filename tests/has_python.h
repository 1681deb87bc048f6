#pragma once

#include <cstdlib>

namespace skein::test {

/// Whether this machine has a python3 that the package skein.controller runs on.
inline bool has_python() {
  return std::system("python3 -c 'import sys; sys.exit(sys.version_info < (3, 9))' 2>/dev/null") == 0;
}

}  // namespace skein::test
