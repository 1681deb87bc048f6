#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/exchange/export_options.h"

namespace skein::app {

struct Exported {
  std::int64_t rows = 0;
  std::optional<std::string> torn;  ///< the last row was incomplete, and is omitted
};

/// Converts the CSV of a run to the format `to`. `file` is the stream's name in messages. The error names file, line
/// and column of invalid input, or why the other file cannot be written, or that the program was interrupted; then no
/// file remains.
tl::expected<Exported, std::string> export_run(std::istream& csv, const std::string& file, const std::string& to,
                                               const ExportOptions& options);

/// "run.mcap" for "run.csv"; a plain CSV is "run.plain.csv".
std::string export_name(const std::string& csv, ExportFormat format);

}  // namespace skein::app
