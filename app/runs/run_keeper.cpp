#include "app/runs/run_keeper.h"

#include <exception>

namespace skein::app {

tl::expected<void, std::string> RunKeeper::begin(const KeepRequest& request, const Experiment& experiment) {
  auto run = KeptRun::begin(request, experiment);
  if (!run) return tl::unexpected(run.error());
  std::unique_ptr<CsvFile> file;
  try {  // the operator may yet change a gain of a pair
    file = std::make_unique<CsvFile>(run->csv(), experiment, CsvOptions{.pair_gains = true, .rules = {}});
    file->flush();  // the head: a disk that takes nothing is told of at once
  } catch (const std::exception& error) {
    return tl::unexpected(std::string(error.what()));
  }
  const std::lock_guard lock(mutex_);
  experiment_ = experiment;
  run_ = std::move(*run);
  statistics_.emplace(experiment);
  file_ = std::move(file);
  takes_rows_ = true;
  return {};
}

bool RunKeeper::keeps() const {
  const std::lock_guard lock(mutex_);
  return takes_rows_;
}

std::string RunKeeper::folder() const {
  const std::lock_guard lock(mutex_);
  return run_ ? run_->folder() : std::string();
}

std::string RunKeeper::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void RunKeeper::record(const TickRecord& record) {
  const std::lock_guard lock(mutex_);
  if (!takes_rows_) return;
  statistics_->record(record);
  if (!problem_.empty()) return;
  try {
    file_->record(record);
  } catch (const std::exception& error) {
    problem_ = error.what();
  }
}

tl::expected<void, std::string> RunKeeper::end(const SessionFacts& facts) {
  {
    const std::lock_guard lock(mutex_);
    if (!takes_rows_) return {};
    takes_rows_ = false;
  }
  try {  // nobody else touches them any more
    file_->finish();
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    if (problem_.empty()) problem_ = error.what();
  }
  file_.reset();
  Statistics::Summary summary = statistics_->summary();
  complete(summary, facts, *experiment_);
  summary.kept = run_->folder();
  RunVerdict verdict = verdict_of(summary, *experiment_);
  if (!problem_.empty()) verdict.problems.push_back("the record of the run is not complete: " + problem_);
  return run_->end(summary, {verdict.exit_status, std::move(verdict.problems), {}});
}

}  // namespace skein::app
