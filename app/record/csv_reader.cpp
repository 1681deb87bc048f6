#include "app/record/csv_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>
#include <unordered_map>

#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_robots.h"
#include "app/record/csv_columns.h"
#include "app/run/shell_word.h"
#include "core/words.h"

namespace skein::app {
namespace {

constexpr std::size_t longest_line = std::size_t{4} << 20;  // 64 robots with all gains of pairs take 200 kB
constexpr double largest = 1e9;  // of any unit that is recorded: what is more is no measurement

template <typename Number>
bool read_number(std::string_view cell, Number& value) {
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  const bool read = error == std::errc{} && stop == cell.data() + cell.size();
  if constexpr (std::is_floating_point_v<Number>) return read && std::abs(value) <= largest;  // nor inf and nan
  return read;
}

bool read_cell(std::string_view cell, double& value) {
  value = none;
  return cell.empty() || read_number(cell, value);
}

/// Words joined by +, each of them a bit.
template <typename Bit>
bool read_words(std::string_view cell, std::uint8_t& bits) {
  bits = 0;
  while (!cell.empty()) {
    const std::size_t plus = std::min(cell.find('+'), cell.size());
    std::uint8_t found = 0;
    for (const Bit bit : core::all_bits_of<Bit>())
      if (word(bit) == cell.substr(0, plus)) found = bit;
    if (found == 0) return false;
    bits |= found;
    cell.remove_prefix(std::min(plus + 1, cell.size()));
  }
  return true;
}

bool read_how(std::string_view cell, core::How& how) {
  const auto found = core::from_word<core::How>(cell);
  if (found) how = *found;
  return found.has_value();
}

bool read_events(std::string_view cell, EventList& events) {
  constexpr std::string_view joint = "; ";
  events.clear();
  while (!cell.empty()) {
    const std::size_t end = std::min(cell.find(joint), cell.size());
    if (const std::optional<Event> event = parse_event(cell.substr(0, end)))
      events.add(*event);
    else if (!cell.starts_with('+'))  // "+2 more": unknown which
      return false;
    cell.remove_prefix(std::min(end + joint.size(), cell.size()));
  }
  return true;
}

void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

bool CsvReader::read_line() {
  if (!std::getline(*in_, text_)) return false;
  ++line_;
  if (!in_->eof()) whole_bytes_ += text_.size() + 1;
  // Other programs save it with a byte order mark and the line ends of Windows. An experiment may have such line ends
  // of its own: then only some lines do.
  if (line_ == 1) {
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    if (text_.starts_with(mark)) text_.erase(0, mark.size());
    of_windows_ = text_.ends_with('\r');
  }
  if (of_windows_ && text_.ends_with('\r')) text_.pop_back();
  return true;
}

tl::unexpected<std::string> CsvReader::error(const std::string& what) const {
  return tl::unexpected(fmt::format("{}:{}: {}", file_, line_, what));
}

tl::expected<CsvReader, std::string> CsvReader::open(std::istream& in, std::string file) {
  CsvReader reader(in, std::move(file));
  CsvHead& head = reader.head_;
  std::string& text = reader.text_;
  const auto after = [&](std::string_view prefix, std::string& value) {
    if (text.starts_with(prefix)) value = text.substr(prefix.size());
  };
  bool found = false;
  while (!found && reader.read_line()) {
    found = !text.starts_with('#');
    if (text.starts_with(source_line)) head.source += text.substr(source_line.size()) + '\n';
    after(version_line, head.version);
    after(experiment_line, head.name);
    after(hash_line, head.hash);
    if (text.starts_with(seed_line) && !read_number(std::string_view(text).substr(seed_line.size()), head.seed))
      return reader.error("the seed is not a whole number");
  }
  if (reader.line_ == 0)
    return tl::unexpected(reader.file_ + ": it is empty, allowed: a CSV written by `skein run --csv`");
  if (!found) return reader.error("ends before a header row, allowed: a CSV written by `skein run --csv`");
  head.intact = head.hash == fmt::format("{:016x}", fnv1a(head.source));
  if (text.ends_with('\r')) text.pop_back();
  split(text, reader.cells_);
  reader.columns_.assign(reader.cells_.begin(), reader.cells_.end());
  for (const char* needed : {"t", "tick", "r1_x"})
    if (std::find(reader.columns_.begin(), reader.columns_.end(), needed) == reader.columns_.end())
      return reader.error(
          fmt::format("the header row has no column {}, allowed: a CSV written by `skein run --csv`", needed));
  reader.find_columns();
  if (reader.robots_ > most_robots)
    return reader.error(fmt::format("the header row has more than {0} robots, allowed: 1 to {0}", most_robots));
  reader.cells_.clear();  // they lie in text_, which moves
  return reader;
}

void CsvReader::find_columns() {
  std::unordered_map<std::string, Store> known;
  const auto store = [&](const std::string& name, auto where) {
    known[name] = [where](TickRecord& record, std::string_view cell) { return read_cell(cell, where(record)); };
  };
  const auto has = [&](const std::string& name) {
    return std::find(columns_.begin(), columns_.end(), name) != columns_.end();
  };
  while (robots_ <= most_robots && has(fmt::format("r{}_x", robots_ + 1))) ++robots_;
  if (robots_ > most_robots) return;  // open() refuses it
  while (has(fmt::format("delta_{}_{}", deltas_ + 1, deltas_ + 2))) ++deltas_;
  while (cameras_ < most_cameras && has(fmt::format("r1_c{}_x_meas", cameras_ + 1))) ++cameras_;

  store("t", [](TickRecord& r) -> double& { return r.t; });
  store("now", [](TickRecord& r) -> double& { return r.now; });
  store("lag", [](TickRecord& r) -> double& { return r.lag; });
  known["tick"] = [](TickRecord& r, std::string_view cell) { return read_number(cell, r.tick); };
  known["event"] = [room = EventList::room_for(robots_)](TickRecord& r, std::string_view cell) {
    r.events.limit_to(room);
    return read_events(cell, r.events);
  };
  for (const auto& column : gain_columns) store(column.name, column.at);
  for (const auto& column : group_columns) store(column.name, column.at);
  for (const auto& column : latency_columns) store(column.name, column.at);
  for (const core::GainName gain : core::gain_names)
    for (std::size_t i = 0; i < robots_; ++i)
      for (std::size_t j = i + 1; j < robots_; ++j)
        known[pair_column(gain, i + 1, j + 1)] = [gain, i, j](TickRecord& r, std::string_view cell) {
          double value = none;
          if (!read_cell(cell, value)) return false;
          r.pair_gains[static_cast<std::size_t>(gain)].set(i, j, value);
          return true;
        };
  for (std::size_t i = 0; i < deltas_; ++i)
    store(fmt::format("delta_{}_{}", i + 1, i + 2), [i](TickRecord& r) -> double& { return r.delta[i]; });
  for (std::size_t i = 0; i < robots_; ++i) {
    const std::string prefix = fmt::format("r{}_", i + 1);
    const auto of_robot = [&](const NumberColumn<RobotRecord>& column) {
      store(prefix + column.name, [i, at = column.at](TickRecord& r) -> double& { return at(r.robots[i]); });
    };
    for (const auto& column : robot_columns) of_robot(column);
    for (const auto& column : measurement_columns) of_robot(column);
    known[prefix + "how"] = [i](TickRecord& r, std::string_view cell) {
      return read_how(cell, r.robots[i].measurement.how);
    };
    for (const auto& column : link_columns) of_robot(column);
    for (const auto& column : link_health_columns) of_robot(column);
    for (const auto& column : link_input_columns) of_robot(column);
    for (std::size_t k = 0; k < cameras_; ++k)
      for (const auto& column : camera_columns)
        store(fmt::format("{}c{}_{}", prefix, k + 1, column.name),
              [seen = k * robots_ + i, at = column.at](TickRecord& r) -> double& { return at(r.by_camera[seen]); });
    known[prefix + "link"] = [i](TickRecord& r, std::string_view cell) {
      r.robots[i].link.state = core::from_word<LinkState>(cell);
      return cell.empty() || r.robots[i].link.state.has_value();
    };
    known[prefix + "mode"] = [i](TickRecord& r, std::string_view cell) {
      return read_words<Mode>(cell, r.robots[i].mode);
    };
    known[prefix + "limit"] = [i](TickRecord& r, std::string_view cell) {
      return read_words<Limit>(cell, r.robots[i].limits);
    };
  }
  for (const std::string& column : columns_) {
    const auto found = known.find(column);
    stores_.push_back(found == known.end() ? Store{} : found->second);
  }
}

tl::expected<Experiment, std::string> CsvReader::experiment() const {
  // Without one the text is empty, and that of the paper's experiment: all that the file says would be about others.
  if (head_.source.empty() && head_.hash.empty())
    return tl::unexpected(
        fmt::format("{}: there is no experiment before the header row, as in a copy by `skein export --to csv`, "
                    "allowed: the CSV that `skein run --csv` wrote",
                    file_));
  auto experiment = parse_experiment(head_.source, file_ + " (experiment)");
  if (!experiment) return tl::unexpected(experiment.error().front().message());
  if (experiment->robots.size() != robots_)
    return tl::unexpected(fmt::format("{}: {} robots in its experiment, but {} in its columns", file_,
                                      experiment->robots.size(), robots_));
  if (const std::size_t several = experiment->cameras() > 1 ? experiment->cameras() : 0; several != cameras_)
    return tl::unexpected(fmt::format("{}: {} cameras in its experiment, but {} in its columns", file_,
                                      experiment->cameras(), std::max<std::size_t>(1, cameras_)));
  return *std::move(experiment);
}

tl::expected<bool, std::string> CsvReader::next(TickRecord& record) {
  do {
    if (!read_line()) return in_->bad() ? error("reading failed") : tl::expected<bool, std::string>(false);
    if (text_.ends_with('\r')) text_.pop_back();
    if (text_.size() > longest_line)
      return error(fmt::format("a line of {} bytes, allowed: at most {}", text_.size(), longest_line));
    // A power cut leaves part of a row, or a block of zeros where one should be. A writer ends every line, and half a
    // number reads as another one.
    if ((in_->eof() && !text_.empty()) || text_.find('\0') != std::string::npos) {
      torn_ = fmt::format(
          "{}:{}: the file is torn here, as by a power cut: read up to this row; `skein replay {} --repair` keeps the "
          "complete rows",
          file_, line_, shell_word_if_needed(file_));
      return false;
    }
  } while (text_.empty() || text_.starts_with('#'));

  split(text_, cells_);
  if (cells_.size() != columns_.size())
    return error(fmt::format("found {} cells, allowed: {} as in the header row", cells_.size(), columns_.size()));
  record = {};
  record.phase = Phase::running;
  record.delta.assign(deltas_, none);
  record.robots.assign(robots_, {});
  record.by_camera.assign(cameras_ * robots_, {});
  record.pair_gains.fill(core::PairTable(robots_, none));
  for (std::size_t i = 0; i < cells_.size(); ++i)
    if (stores_[i] && !stores_[i](record, cells_[i]))
      return error(fmt::format("column {}: found \"{}\", allowed: {}", columns_[i], cells_[i],
                               columns_[i].ends_with("mode")    ? "modes joined by +"
                               : columns_[i].ends_with("_how")  ? "detected, tracked, recovered or nothing"
                               : columns_[i].ends_with("_link") ? "a link's state"
                               : columns_[i].ends_with("limit") ? "v, omega, wheels and link, joined by +"
                               : columns_[i] == "event"         ? "events joined by \"; \""
                               : columns_[i] == "tick"          ? "a whole number"
                                                                : "a number from -1e9 to 1e9, or nothing"));
  for (const core::GainName gain : core::gain_names)  // an empty cell, or no column: as all pairs
    for (std::size_t i = 0; i < robots_; ++i)
      for (std::size_t j = i + 1; j < robots_; ++j)
        if (std::isnan(record.pair_gain(gain, i, j)))
          record.pair_gains[static_cast<std::size_t>(gain)].set(i, j, record.gain(gain));
  for (const RobotRecord& robot : record.robots)
    if (robot.is(staging)) record.phase = Phase::staging;
  for (RobotRecord& robot : record.robots)
    if (std::isnan(robot.measurement.captured_at)) robot.measurement = {};  // never seen
  for (core::Measurement& seen : record.by_camera)
    if (std::isnan(seen.captured_at)) seen = {};
  return true;
}

std::string_view CsvReader::cell(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  const auto index = static_cast<std::size_t>(found - columns_.begin());
  return index < cells_.size() ? cells_[index] : std::string_view{};
}

}  // namespace skein::app
