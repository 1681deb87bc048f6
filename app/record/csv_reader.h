#pragma once

#include <cstdint>
#include <functional>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// The `#` lines of a run's CSV.
struct CsvHead {
  std::string version;  ///< of the program that wrote it
  std::string name;     ///< of the experiment
  std::string hash;     ///< of the experiment, as written
  bool intact = false;  ///< the embedded experiment still has that hash
  std::uint64_t seed = 0;
  std::string source;  ///< the embedded experiment: what parse_experiment reads
};

/// Reads a CSV that CsvWriter wrote, row by row, to the same doubles. Columns are found by name: their order does not
/// matter, unknown ones are skipped, and values of missing ones keep their defaults. Errors name file, line and
/// column.
class CsvReader {
 public:
  /// Reads the head and the header row. The stream must outlive the reader.
  static tl::expected<CsvReader, std::string> open(std::istream& in, std::string file);

  const CsvHead& head() const noexcept { return head_; }
  const std::vector<std::string>& columns() const noexcept { return columns_; }
  std::size_t robots() const noexcept { return robots_; }
  /// The embedded experiment. The error: it cannot be read, or is not the one that the columns belong to.
  tl::expected<Experiment, std::string> experiment() const;

  /// The next row. false: there is none, or the rest is torn: see torn(). `phase`, the margins and the tracking gains
  /// are not in the file.
  tl::expected<bool, std::string> next(TickRecord& record);

  /// If the file ends in an incomplete row, as after a power cut, a sentence about it, once `next` has reached it. A
  /// row is complete if its line ends.
  const std::optional<std::string>& torn() const noexcept { return torn_; }
  /// The offset of the first byte after the last complete row.
  std::uint64_t whole_bytes() const noexcept { return whole_bytes_; }

  /// The cells of the row that `next` read, as written, in the order of `columns`.
  const std::vector<std::string_view>& cells() const noexcept { return cells_; }
  /// A cell of the row that `next` read, by column name; empty if there is no such column.
  std::string_view cell(std::string_view column) const;

 private:
  CsvReader(std::istream& in, std::string file) : in_(&in), file_(std::move(file)) {}
  bool read_line();
  tl::unexpected<std::string> error(const std::string& what) const;
  void find_columns();

  /// Stores one cell in the record; false: it is not valid for the column.
  using Store = std::function<bool(TickRecord&, std::string_view)>;

  std::istream* in_;
  std::string file_;
  std::size_t line_ = 0;
  std::uint64_t whole_bytes_ = 0;
  bool of_windows_ = false;  // its lines end with CR LF
  std::optional<std::string> torn_;
  std::string text_;  // of that line
  CsvHead head_;
  std::vector<std::string> columns_;
  std::vector<Store> stores_;  // one a column, empty for an unknown one
  std::vector<std::string_view> cells_;
  std::size_t robots_ = 0, deltas_ = 0, cameras_ = 0;
};

/// `phase` of a row with which its run was stopped, or that was written after its end: a file tells only of those in
/// which robots drive.
inline void find_end(const Experiment& experiment, TickRecord& row) noexcept {
  if (row.phase != Phase::running) return;
  if (row.tick >= experiment.ticks())
    row.phase = Phase::finished;
  else if (row.events.contains<events::Stop>())
    row.phase = Phase::stopped;
}

}  // namespace skein::app
