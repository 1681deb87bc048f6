#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// The SHA-256 of a file, as `sha256sum` prints it. The error says why the file cannot be read.
tl::expected<std::string, std::string> sha256_of_file(const std::string& path);

/// That of these bytes.
std::string sha256_of_text(std::string_view text);

}  // namespace skein::app
