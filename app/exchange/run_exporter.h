#pragma once

#include <memory>
#include <string>

#include "app/exchange/export_options.h"
#include "app/record/csv_reader.h"

namespace skein::app {

/// One format: gets every row, returns the bytes of the file in pieces. The reader outlives it.
class RunExporter {
 public:
  virtual ~RunExporter() = default;
  virtual void row(const TickRecord& record) = 0;  ///< just read by the reader
  virtual void finish() = 0;
  virtual std::string take() = 0;  ///< the next bytes of the file; empty: none so far, or after finish() none any more
};

std::unique_ptr<RunExporter> mcap_exporter(const CsvReader& reader, const ExportOptions& options);
std::unique_ptr<RunExporter> mat_exporter(const CsvReader& reader);

}  // namespace skein::app
