// A run as one variable `run`: a field a column, named as in the CSV, and the experiment as a text.
#include <charconv>
#include <utility>
#include <vector>

#include "app/exchange/mat_writer.h"
#include "app/exchange/run_exporter.h"
#include "app/record/csv_columns.h"

namespace skein::app {
namespace {

class MatExporter final : public RunExporter {
 public:
  explicit MatExporter(const CsvReader& reader) : reader_(reader) {
    for (const std::string& name : reader.columns()) columns_.push_back({name, holds_words(name), {}, {}});
  }

  void row(const TickRecord& /*record*/) override {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const std::string_view cell = reader_.cells()[i];
      if (columns_[i].words) {
        columns_[i].texts.emplace_back(cell);
        continue;
      }
      double value = none;
      std::from_chars(cell.data(), cell.data() + cell.size(), value);
      columns_[i].numbers.push_back(value);
    }
  }

  void finish() override {
    for (Column& column : columns_) {
      fields_.emplace_back(column.name, column.words ? mat_cells(column.texts) : mat_column(column.numbers));
      column = {};
    }
    fields_.emplace_back("experiment", mat_text(reader_.head().source));
    fields_.emplace_back("skein", mat_text(reader_.head().version));
    head_ = mat_file_head("run", fields_);
  }

  /// Field by field: a run of many hours would not fit into memory several times.
  std::string take() override {
    if (!head_.empty()) return std::exchange(head_, {});
    return taken_ < fields_.size() ? std::exchange(fields_[taken_++].second, {}) : std::string();
  }

 private:
  struct Column {
    std::string name;
    bool words = false;
    std::vector<double> numbers;
    std::vector<std::string> texts;
  };
  const CsvReader& reader_;
  std::vector<Column> columns_;
  std::string head_;
  std::vector<std::pair<std::string, std::string>> fields_;
  std::size_t taken_ = 0;  // of the fields
};

}  // namespace

std::unique_ptr<RunExporter> mat_exporter(const CsvReader& reader) {
  return std::make_unique<MatExporter>(reader);
}

}  // namespace skein::app
