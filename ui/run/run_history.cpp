#include "ui/run/run_history.h"

#include <QSaveFile>
#include <algorithm>
#include <sstream>

#include "app/record/csv_writer.h"
#include "ui/base/tr.h"

namespace skein::ui {

void RunHistory::clear() {
  rows_.clear();
  dropped_ = 0;
  started_ = false;
}

void RunHistory::add(const app::TickRecord& record) {
  started_ = started_ || record.phase == app::Phase::running || record.phase == app::Phase::staging;
  const bool row = record.phase == app::Phase::running || record.phase == app::Phase::staging ||
                   (started_ && !record.events.empty());
  if (!row) return;
  rows_.push_back(std::make_shared<const app::TickRecord>(record));
  const std::size_t row_bytes = sizeof(app::TickRecord) + record.robots.size() * sizeof(app::RobotRecord);
  while (rows_.size() * row_bytes > bytes_) {
    rows_.pop_front();
    ++dropped_;
  }
}

QString write_csv(const RunHistory::Rows& rows, const app::Experiment& experiment, const QString& file) {
  std::ostringstream text;
  const bool pair_gains =
      std::any_of(rows.begin(), rows.end(), [](const auto& row) { return app::pairs_differ(*row); });
  app::CsvWriter writer(text, experiment, pair_gains);
  for (const auto& row : rows) writer.record(*row);
  // A half-written file never takes the place of a good one.
  QSaveFile out(file);
  const std::string bytes = text.str();
  if (!out.open(QIODevice::WriteOnly) || out.write(bytes.data(), static_cast<qint64>(bytes.size())) < 0 ||
      !out.commit())
    return tr("Could not write %1: %2.").arg(file, out.errorString());
  return {};
}

}  // namespace skein::ui
