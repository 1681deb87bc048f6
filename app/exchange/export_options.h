#pragma once

#include <string_view>

#include "app/record/disk_writer.h"

namespace skein::app {

/// The export formats of a run's CSV. docs/tools.md describes the files.
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
  double epoch = 0.0;      ///< of MCAP: time at which the session's clock was 0 [s since 1970]
  WriteRules rules{};
};

}  // namespace skein::app
