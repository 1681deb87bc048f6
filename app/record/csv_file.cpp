#include "app/record/csv_file.h"

#include <fmt/format.h>

#include <limits>
#include <stdexcept>
#include <utility>

namespace skein::app {
namespace {

constexpr std::size_t most_recent = 1000;               // twice a session's channel
constexpr double flush_patience = 1.0, patience = 5.0;  // [s]

DiskWriter open(const std::string& path, WriteRules rules) {
  auto disk = DiskWriter::open(path, rules);
  if (!disk) throw std::runtime_error(disk.error());
  return std::move(*disk);
}

void check(const tl::expected<void, std::string>& written) {
  if (!written) throw std::runtime_error(written.error());
}

}  // namespace

CsvFile::CsvFile(const std::string& path, const Experiment& experiment, CsvOptions options)
    : disk_(open(path, options.rules)), writer_(text_, experiment, options.pair_gains || pairs_differ(experiment)) {
  hand_over();
}

void CsvFile::record(const TickRecord& record) {
  writer_.record(record);
  hand_over();
  if (!std::exchange(published_, true)) disk_.publish();
}

void CsvFile::hand_over() {
  const bool taken = disk_.write(text_.view());
  text_.str({});
  if (!taken) throw std::runtime_error(disk_.failure());
}

void CsvFile::flush() {
  check(disk_.flush(flush_patience));
}

void CsvFile::finish() {
  check(disk_.finish(patience));
}

void CsvRecorder::begin(const std::string& path, const Experiment& experiment, Rows before) {
  // The operator may yet change a gain; and has been asked whether a file there may go.
  auto file = std::make_unique<CsvFile>(path, experiment, CsvOptions{.pair_gains = true, .rules = {.force = true}});
  file->flush();  // the head: a disk that accepts nothing is reported at once
  const std::lock_guard lock(mutex_);
  file_ = std::move(file);
  last_known_ = before.empty() ? -std::numeric_limits<double>::infinity() : before.back()->now;
  before_ = std::move(before);
  owes_before_ = true;
}

/// Once: the rows from before the beginning, those that the caller knew of and the newest ones.
void CsvRecorder::write_before() {
  if (!std::exchange(owes_before_, false)) return;
  for (const auto& row : before_) file_->record(*row);
  before_.clear();
  for (const TickRecord& row : recent_)
    if (row.now > last_known_) file_->record(row);
}

void CsvRecorder::end() {
  const std::lock_guard lock(mutex_);
  if (!file_) return;
  struct Close {
    std::unique_ptr<CsvFile>& file;
    ~Close() { file = nullptr; }
  } const close{file_};
  write_before();
  file_->finish();
}

bool CsvRecorder::active() const {
  const std::lock_guard lock(mutex_);
  return file_ != nullptr;
}

void CsvRecorder::record(const TickRecord& record) {
  const std::lock_guard lock(mutex_);
  if (file_) {
    write_before();
    if (record.now > last_known_) file_->record(record);  // otherwise the caller got it before this sink did
  }
  recent_.push_back(record);
  if (recent_.size() > most_recent) recent_.pop_front();
}

}  // namespace skein::app
