#pragma once

#include <memory>
#include <ostream>
#include <string>

#include "app/experiment.h"
#include "app/tick_record.h"

namespace skein::app {

/// Writes a run as CSV, exactly as docs/csv.md says: `#` lines, a header row, one row a tick, shortest text that reads
/// back to the same double, empty where there is no value. The `#` lines hold the whole experiment, so that the file
/// can be replayed.
class CsvWriter final : public RecordSink {
 public:
  /// Writes the head at once. The stream must outlive the writer.
  CsvWriter(std::ostream& out, const Experiment& experiment);
  ~CsvWriter() override;
  void record(const TickRecord& record) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skein::app
