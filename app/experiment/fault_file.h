#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/problem.h"
#include "comms/emulator/radio_faults.h"

namespace skein::app {

/// Reads the faults of emulated robots from TOML, `[[fault]]` tables as docs/emulator.md describes them, or returns all
/// problems: unknown keys, keys that a kind does not use, values out of range, robot numbers above `robots`. `file` is
/// for the messages.
tl::expected<std::vector<comms::Fault>, std::vector<Problem>> parse_faults(std::string_view text,
                                                                           const std::string& file, std::size_t robots);
/// The same from a file; a file that cannot be read is a problem as well.
tl::expected<std::vector<comms::Fault>, std::vector<Problem>> load_faults(const std::string& path, std::size_t robots);

}  // namespace skein::app
