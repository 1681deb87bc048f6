#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/problem.h"

namespace skein::app {

/// Checks that this is a file and not a directory, device or FIFO, which might never end. The error is a sentence.
tl::expected<void, std::string> check_is_file(const std::string& path);

/// Of what people write. [bytes]
inline constexpr std::uintmax_t largest_text = std::uintmax_t{64} << 20;

/// The contents of a text file of at most `largest` bytes; the problem says why it cannot be read.
tl::expected<std::string, std::vector<Problem>> read_text(const std::string& path,
                                                          std::uintmax_t largest = largest_text);

/// Writes a whole file, or leaves what was there; the error names it.
tl::expected<void, std::string> write_file(const std::string& path, std::string_view text);

/// Whether a file could be written there; what is there stays as it is.
tl::expected<void, std::string> check_can_write(const std::string& path);

}  // namespace skein::app
