#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/record/disk_writer.h"

namespace skein::app {

/// What a run's CSV can be turned into for other programs. docs/tools.md says what each file holds.
enum class ExportFormat {
  csv,   ///< without the lines before the header row
  mcap,  ///< for Foxglove and PlotJuggler
  mat,   ///< for MATLAB and Octave (level 5)
};
constexpr std::string_view word(ExportFormat format) noexcept {
  switch (format) {
    case ExportFormat::csv:
      return "csv";
    case ExportFormat::mcap:
      return "mcap";
    case ExportFormat::mat:
      return "mat";
  }
  return {};
}

struct ExportOptions {
  ExportFormat format = ExportFormat::csv;
  bool compressed = true;  ///< the chunks of MCAP, by zstd
  double epoch = 0.0;      ///< of MCAP: when the session's clock stood at 0 [s since 1970]
  WriteRules rules{};
};

struct Exported {
  std::int64_t rows = 0;
  std::optional<std::string> torn;  ///< the last row was not whole, and is left out
};

/// Turns the CSV of a run into `to`. `file` stands for the stream in messages. The error names file, line and column of
/// what cannot be read, or says why the other file cannot be written; then there is none.
tl::expected<Exported, std::string> export_run(std::istream& csv, const std::string& file, const std::string& to,
                                               const ExportOptions& options);

/// "run.mcap" for "run.csv"; a plain CSV is "run.plain.csv".
std::string export_name(const std::string& csv, ExportFormat format);

}  // namespace skein::app
