#pragma once

#include <deque>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/record/csv_writer.h"

namespace skein::app {

/// A CSV on disk that fails loudly: a row that could not be written is an error of the run, not a gap in the data.
/// Throws std::runtime_error with file and reason.
class CsvFile final : public RecordSink {
 public:
  /// `pair_gains` as for CsvWriter.
  CsvFile(const std::string& path, const Experiment& experiment, bool pair_gains);
  CsvFile(const std::string& path, const Experiment& experiment)
      : CsvFile(path, experiment, pairs_differ(experiment)) {}
  void record(const TickRecord& record) override;
  void finish();  ///< everything is with the system, or it throws

 private:
  void check();
  std::string path_, failure_;  // the first reason: later ones say nothing
  std::vector<char> buffer_;
  std::ofstream file_;
  std::optional<CsvWriter> writer_;
};

/// Records a run from any moment on, what was before it included. A sink that is always there, and writes while it is
/// asked to; once a second the file is complete, so that a crash or a full disk costs a second at most. `record`
/// belongs to the sinks' thread, the rest to the controlling one.
class CsvRecorder final : public RecordSink {
 public:
  using Rows = std::vector<std::shared_ptr<const TickRecord>>;

  /// `before`: the rows of the run so far that the caller knows of; later ones that it has not seen yet are known here.
  /// Throws as CsvFile does.
  void begin(const std::string& path, const Experiment& experiment, Rows before);
  /// Throws as CsvFile does. Nothing, if nothing is being recorded.
  void end();
  bool active() const;

  void record(const TickRecord& record) override;

 private:
  void write_before();

  mutable std::mutex mutex_;
  std::unique_ptr<CsvFile> file_;
  Rows before_;
  bool owes_before_ = false;                 // `before_` is not written yet
  double last_known_ = 0.0, flushed_ = 0.0;  // `now` of rows: the last that the caller knew of at the beginning [s]
  std::deque<TickRecord> recent_;            // longer than a window's channel: what it may not have seen yet
};

}  // namespace skein::app
