#pragma once

#include <string>

#include <tl/expected.hpp>

namespace skein::app {

/// The SHA-256 of a file, as `sha256sum` prints it. The error says why the file cannot be read.
tl::expected<std::string, std::string> sha256_of_file(const std::string& path);

}  // namespace skein::app
