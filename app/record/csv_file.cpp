#include "app/record/csv_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

namespace skein::app {
namespace {

constexpr std::size_t most_recent = 1000;  // twice a session's channel
constexpr double flush_period = 1.0;       // [s]

}  // namespace

CsvFile::CsvFile(const std::string& path, const Experiment& experiment, bool pair_gains)
    : path_(path), buffer_(1 << 20) {
  file_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  file_.open(path, std::ios::binary | std::ios::trunc);
  if (file_) writer_.emplace(file_, experiment, pair_gains);
  check();
}

void CsvFile::record(const TickRecord& record) {
  writer_->record(record);
  check();
}

void CsvFile::finish() {
  file_.flush();
  check();
}

void CsvFile::check() {
  if (file_) return;
  if (failure_.empty()) failure_ = fmt::format("{}: cannot be written: {}", path_, std::strerror(errno));
  throw std::runtime_error(failure_);
}

void CsvRecorder::begin(const std::string& path, const Experiment& experiment, Rows before) {
  constexpr bool pair_gains = true;  // the operator may yet change one
  auto file = std::make_unique<CsvFile>(path, experiment, pair_gains);
  file->finish();  // the head: a disk that takes nothing is told of at once
  const std::lock_guard lock(mutex_);
  file_ = std::move(file);
  last_known_ = before.empty() ? -std::numeric_limits<double>::infinity() : before.back()->now;
  before_ = std::move(before);
  owes_before_ = true;
  flushed_ = 0.0;
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
    if (record.now > last_known_) file_->record(record);  // else the caller was told of it before this sink was
    if (record.now - flushed_ >= flush_period) {
      file_->finish();
      flushed_ = record.now;
    }
  }
  recent_.push_back(record);
  if (recent_.size() > most_recent) recent_.pop_front();
}

}  // namespace skein::app
