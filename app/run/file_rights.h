#pragma once

#include <string>

namespace skein::app {

/// A file that a lab shares stays one, and a private one private: a draft, an open descriptor, gets owner, group and
/// mode of the file that it will replace, as far as this user may give them. Nothing happens where there is none.
void keep_rights(const std::string& replaced, int draft) noexcept;

}  // namespace skein::app
