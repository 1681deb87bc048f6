#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/experiment/run_text.h"
#include "app/record/csv_file.h"
#include "app/record/statistics.h"
#include "app/runs/kept_run.h"
#include "app/runs/run_end.h"
#include "app/session/tag_crops.h"

namespace skein::app {

/// Keeps a run while a session goes on: a permanent sink that does nothing until `begin`. A disk that accepts no more
/// data ends the record, not the run. `record` belongs to the sinks' thread; everything else may be called from any
/// other thread.
class RunKeeper final : public RecordSink {
 public:
  /// Makes the run's folder; rows follow. Differences between the experiment and its file are added to the request's
  /// sets, and at the end the operator's changes. The error says what cannot be written or read.
  tl::expected<void, std::string> begin(const KeepRequest& request, const Experiment& experiment);
  bool keeps() const;           ///< begun, and not ended
  std::string folder() const;   ///< empty: not begun
  std::string problem() const;  ///< why the record ends early; empty: it does not
  /// The tags that are not seen; of a session that gives them, the folder gets those of the run.
  TagCrops& crops() noexcept { return crops_; }

  void record(const TickRecord& record) override;

  /// No more rows; completes the folder with figures, summary and hashes, which takes seconds. `film`: of the run,
  /// which is complete, and of which the folder gets one; empty: none. The error says what is missing.
  tl::expected<void, std::string> end(const SessionFacts& facts, const std::string& film = {});

 private:
  mutable std::mutex mutex_;
  std::optional<Experiment> experiment_;
  std::optional<KeptRun> run_;
  std::optional<Statistics> statistics_;
  std::optional<ActionsDone> done_;
  std::unique_ptr<CsvFile> file_;
  TagCrops crops_;
  std::string problem_;
  bool takes_rows_ = false;
};

}  // namespace skein::app
