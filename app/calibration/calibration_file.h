#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "vision/calibration/calibration.h"

namespace skein::app {

/// Reads a calibration file (TOML, the tables that format_calibration writes). The error has a line for each problem:
/// file:line:column, the key, what was found and what is allowed. Unknown keys are refused.
tl::expected<vision::Calibration, std::string> load_calibration(const std::filesystem::path& path);

/// The same for text already in memory; `name` stands for the file in messages.
tl::expected<vision::Calibration, std::string> parse_calibration(std::string_view text, const std::string& name);

/// The file's text. Numbers are the shortest that read back to the same double: parse_calibration returns an equal
/// value.
std::string format_calibration(const vision::Calibration& calibration);

/// Whether a calibration can be written there: before a camera is measured for it. The error is a sentence.
tl::expected<void, std::string> check_calibration_target(const std::filesystem::path& path);

/// Writes format_calibration to a file, all of it or nothing; the error names the file and the reason.
tl::expected<void, std::string> save_calibration(const vision::Calibration& calibration,
                                                 const std::filesystem::path& path);

/// The same over a file that may exist: its old content is kept beside it, as `path` with ".old" appended, over an
/// older one, or with ".old-2" if that is a link or one of the files to `leave`. Returns the name of that copy; empty:
/// there was no file, or its content was the same.
tl::expected<std::filesystem::path, std::string> replace_calibration(const vision::Calibration& calibration,
                                                                     const std::filesystem::path& path,
                                                                     std::span<const std::string> leave = {});

}  // namespace skein::app
