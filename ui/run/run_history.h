#pragma once

#include <QString>
#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::ui {

/// The rows of a run as they came in, for saving: everything from Start to the end. Bounded, so that a window left open
/// over a weekend does not use up the memory; dropped rows are counted.
class RunHistory {
 public:
  using Rows = std::vector<std::shared_ptr<const app::TickRecord>>;

  /// `bytes` is the limit for all rows: by default 13 minutes of four robots at 25 Hz. A recording (CsvRecorder) has no
  /// such limit.
  explicit RunHistory(std::size_t bytes = std::size_t{48} << 20) : bytes_(bytes) {}

  void clear();
  /// Keeps the record if it is a row of the run: from the tick that starts it to the one that ends it.
  void add(const app::TickRecord& record);

  std::size_t size() const { return rows_.size(); }
  std::size_t dropped() const { return dropped_; }
  /// The present rows. Cheap, and safe to pass to another thread: rows never change.
  Rows rows() const { return {rows_.begin(), rows_.end()}; }

 private:
  std::size_t bytes_;
  std::deque<std::shared_ptr<const app::TickRecord>> rows_;
  std::size_t dropped_ = 0;
  bool started_ = false;
};

/// Writes rows as CSV. Returns the error; empty: none.
QString write_csv(const RunHistory::Rows& rows, const app::Experiment& experiment, const QString& file);

}  // namespace skein::ui
