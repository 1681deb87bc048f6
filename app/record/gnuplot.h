#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// Runs gnuplot in a directory, with a script's name or an option, and waits for its end. The error is what it wrote to
/// stderr, or which package has it.
tl::expected<void, std::string> gnuplot(const std::string& directory, const char* argument);

/// Writes a whole file anew; the error names it.
tl::expected<void, std::string> write_file(const std::string& path, std::string_view text);

}  // namespace skein::app
