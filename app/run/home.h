#pragma once

#include <string>

namespace skein::app {

/// The user's home: $HOME, otherwise that of the user database; empty: there is none.
std::string home_folder();

}  // namespace skein::app
