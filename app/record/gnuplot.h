#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// Runs gnuplot in a directory, with a script's name or an option, and waits for its end. The error is its output on
/// stderr, or the package that contains it.
tl::expected<void, std::string> gnuplot(const std::string& directory, const char* argument);

/// Writes a complete file; the error names it.
tl::expected<void, std::string> write_file(const std::string& path, std::string_view text);

}  // namespace skein::app
