#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include "app/record/csv_writer.h"
#include "app/record/disk_writer.h"

namespace skein::app {

struct CsvOptions {
  bool pair_gains = false;  ///< as for CsvWriter; also where those of the experiment differ
  WriteRules rules{};
};

/// A CSV on disk whose errors are reported: a row that could not be written is an error of the run, not a gap in the
/// data. Rows are on the disk within a second; the caller does not wait (disk_writer.h). The file has its name from the
/// first row on. Throws std::runtime_error with file and reason.
class CsvFile final : public RecordSink {
 public:
  CsvFile(const std::string& path, const Experiment& experiment, CsvOptions options = {});
  void record(const TickRecord& record) override;
  void flush();   ///< everything is on the disk, or it throws, after a second at most
  void finish();  ///< the same after 5 s at most, and the file is closed: no more rows

 private:
  void hand_over();
  std::ostringstream text_;
  DiskWriter disk_;
  CsvWriter writer_;
  bool published_ = false;
};

/// Records a run from any moment on, including the part before it. A permanent sink that writes on request. `record`
/// belongs to the sinks' thread, the rest to the controlling one.
class CsvRecorder final : public RecordSink {
 public:
  using Rows = std::vector<std::shared_ptr<const TickRecord>>;

  /// `before`: the rows of the run that the caller has so far; the recorder itself has the later ones. Throws as
  /// CsvFile does.
  void begin(const std::string& path, const Experiment& experiment, Rows before);
  /// Throws as CsvFile does. Does nothing if nothing is being recorded.
  void end();
  bool active() const;

  void record(const TickRecord& record) override;

 private:
  void write_before();

  mutable std::mutex mutex_;
  std::unique_ptr<CsvFile> file_;
  Rows before_;
  bool owes_before_ = false;       // `before_` is not written yet
  double last_known_ = 0.0;        // `now` of the last row that the caller had at the beginning [s]
  std::deque<TickRecord> recent_;  // longer than a window's channel: rows that it may not have seen yet
};

}  // namespace skein::app
