#pragma once

#include <string>

namespace skein::app {

/// Whether both are names of one file, also through links; not if one of them is empty or names none.
bool same_file(const std::string& a, const std::string& b);

}  // namespace skein::app
