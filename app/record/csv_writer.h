#pragma once

#include <memory>
#include <ostream>
#include <string>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// Whether the gains of pairs ever differ, according to the experiment.
bool pairs_differ(const Experiment& experiment);
/// Whether they differ at this tick.
bool pairs_differ(const TickRecord& record) noexcept;

/// Writes a run as CSV, exactly as docs/csv.md says: `#` lines, a header row, one row a tick, shortest text that reads
/// back to the same double, empty where there is no value. The `#` lines hold the whole experiment, so that the file
/// can be replayed.
class CsvWriter final : public RecordSink {
 public:
  /// Writes the head at once. The stream must outlive the writer. `pair_gains`: with columns for the gains of each
  /// pair, for runs in which they differ.
  CsvWriter(std::ostream& out, const Experiment& experiment, bool pair_gains);
  CsvWriter(std::ostream& out, const Experiment& experiment) : CsvWriter(out, experiment, pairs_differ(experiment)) {}
  ~CsvWriter() override;
  void record(const TickRecord& record) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace skein::app
