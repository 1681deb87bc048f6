#include "app/runs/run_keeper.h"

#include <exception>
#include <utility>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_sets.h"
#include "app/experiment/text_file.h"

namespace skein::app {

namespace {

/// What the experiment has otherwise than its file; nothing, if the file no longer can be read. It is not checked once
/// more: of many robots that takes seconds, in which the window could not answer.
std::vector<std::string> changes(const KeepRequest& request, const Experiment& experiment) {
  const auto text = request.experiment.empty() ? tl::expected<std::string, std::vector<Problem>>(
                                                     request.text.empty() ? paper_experiment().source : request.text)
                                               : read_text(request.experiment);
  const std::string& file = request.experiment.empty() ? experiment.name : request.experiment;
  const auto as_written = text.and_then([&](const std::string& read) { return whole_text(read, file); });
  return as_written ? sets_between(*as_written, experiment.source) : std::vector<std::string>{};
}

}  // namespace

tl::expected<void, std::string> RunKeeper::begin(const KeepRequest& request, const Experiment& experiment) {
  KeepRequest with_changes = request;
  for (std::string& set : changes(request, experiment)) with_changes.sets.push_back(std::move(set));
  auto run = KeptRun::begin(with_changes, experiment);
  if (!run) return tl::unexpected(run.error());
  std::unique_ptr<CsvFile> file;
  try {  // the operator may yet change a gain of a pair
    file = std::make_unique<CsvFile>(run->csv(), experiment, CsvOptions{.pair_gains = true, .rules = {}});
    file->flush();  // the head: a disk that accepts nothing is reported at once
  } catch (const std::exception& error) {
    return tl::unexpected(std::string(error.what()));
  }
  crops_.begin({run->folder()});
  const std::lock_guard lock(mutex_);
  experiment_ = experiment;
  run_ = std::move(*run);
  statistics_.emplace(experiment);
  done_.emplace(experiment);
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
  done_->note(record);
  if (!problem_.empty()) return;
  try {
    file_->record(record);
  } catch (const std::exception& error) {
    problem_ = error.what();
  }
}

tl::expected<void, std::string> RunKeeper::end(const SessionFacts& facts, const std::string& film) {
  {
    const std::lock_guard lock(mutex_);
    if (!takes_rows_) return {};
    takes_rows_ = false;
  }
  try {  // no other thread uses them any more
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
  std::vector<std::string> sets;
  for (const OperatorAction& action : done_->all())
    sets.push_back(set_of(action, experiment_->actions.size() + sets.size() + 1));
  crops_.end_files();  // the session may go on
  return run_->end(summary, {verdict.exit_status, std::move(verdict.problems), film, std::move(sets), crops_.all()});
}

}  // namespace skein::app
