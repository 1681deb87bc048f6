#include "app/exchange/export.h"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <utility>

#include "app/exchange/run_exporter.h"
#include "app/run/interrupted.h"

namespace skein::app {
namespace {

constexpr double patience = 60.0;  // [s] no robot waits for this file

/// The header row and the rows, as they are.
class PlainExporter final : public RunExporter {
 public:
  explicit PlainExporter(const CsvReader& reader) : reader_(reader) { line(reader.columns()); }
  void row(const TickRecord& /*record*/) override { line(reader_.cells()); }
  void finish() override {}
  std::string take() override { return std::exchange(text_, {}); }

 private:
  template <typename Cells>
  void line(const Cells& cells) {
    for (const auto& cell : cells) text_.append(cell) += ',';
    text_.back() = '\n';
  }
  const CsvReader& reader_;
  std::string text_;
};

std::unique_ptr<RunExporter> exporter(const CsvReader& reader, const ExportOptions& options) {
  switch (options.format) {
    case ExportFormat::csv:
      return std::make_unique<PlainExporter>(reader);
    case ExportFormat::mcap:
      return mcap_exporter(reader, options);
    case ExportFormat::mat:
      return mat_exporter(reader);
  }
  throw std::logic_error("no such format");
}

}  // namespace

std::string export_name(const std::string& csv, ExportFormat format) {
  const auto extension = [&]() -> std::string {
    switch (format) {
      case ExportFormat::csv:
        return "plain.csv";
      case ExportFormat::mcap:
      case ExportFormat::mat:
        break;
    }
    return std::string(word(format));
  };
  return std::filesystem::path(csv).replace_extension(extension()).string();
}

tl::expected<Exported, std::string> export_run(std::istream& csv, const std::string& file, const std::string& to,
                                               const ExportOptions& options) {
  auto reader = CsvReader::open(csv, file);
  if (!reader) return tl::unexpected(reader.error());
  auto disk = DiskWriter::open(to, {.force = options.rules.force, .whole = true});
  if (!disk) return tl::unexpected(disk.error());
  const auto stopped = tl::unexpected(to + ": is not written: interrupted");  // nor does its draft stay
  const auto out = exporter(*reader, options);
  Exported result;
  TickRecord row;
  try {
    while (true) {
      const auto more = reader->next(row);
      if (!more) return tl::unexpected(more.error());
      if (!*more) break;
      if (interrupted()) return stopped;
      out->row(row);
      ++result.rows;
      if (!disk->write(out->take())) return tl::unexpected(disk->failure());
    }
    out->finish();
    for (std::string piece = out->take(); !piece.empty(); piece = out->take()) {
      if (interrupted()) return stopped;
      if (!disk->write(piece)) return tl::unexpected(disk->failure());
    }
  } catch (const std::exception& error) {
    return tl::unexpected(fmt::format("{}: cannot be written: {}", to, error.what()));
  }
  result.torn = reader->torn();
  disk->publish();
  if (const auto written = disk->finish(patience); !written) return tl::unexpected(written.error());
  return result;
}

}  // namespace skein::app
