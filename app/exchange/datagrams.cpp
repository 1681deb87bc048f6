#include "app/exchange/datagrams.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/exchange/json_cell.h"
#include "app/record/csv_columns.h"

namespace skein::app {
namespace {

/// Calls `take` with each cell of a line and its number.
template <typename Take>
void each_cell(std::string_view line, Take&& take) {
  for (std::size_t i = 0;; ++i) {
    const std::size_t comma = std::min(line.find(','), line.size());
    take(line.substr(0, comma), i);
    if (comma == line.size()) return;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

Datagrams::Datagrams(const Experiment& experiment) : writer_(text_, experiment) {
  std::string_view header = text_.view();
  header.remove_suffix(1);
  header.remove_prefix(header.rfind('\n') + 1);
  each_cell(header, [&](std::string_view name, std::size_t) {
    Key key{std::string(name), 0, holds_words(name)};
    for (std::size_t i = 1; i <= experiment.robots.size(); ++i)
      if (const std::string prefix = fmt::format("r{}_", i); name.starts_with(prefix))
        key = {std::string(name.substr(prefix.size())), i, key.words};
    keys_.push_back(std::move(key));
  });
}

const std::vector<std::string>& Datagrams::of(const TickRecord& record) {
  text_.str({});
  writer_.record(record);
  std::string_view row = text_.view();
  row.remove_suffix(1);

  datagrams_.clear();
  const std::string begin = fmt::format("{{\"timestamp\":{}", record.now);
  std::string now = begin;
  std::size_t robot = 0;  // whose object is open
  const auto close = [&] {
    if (now.size() > begin.size()) datagrams_.push_back(now + (robot > 0 ? "}}" : "}"));
    now = begin;
    robot = 0;
  };
  each_cell(row, [&](std::string_view cell, std::size_t i) {
    if (cell.empty()) return;
    const Key& key = keys_[i];
    const std::string member = fmt::format("\"{}\":{}", key.name, json_cell(cell, key.words));
    constexpr std::size_t ends = 12;  // an object's name and the brackets
    if (key.robot != robot || now.size() + member.size() + ends > largest) close();
    const bool opens = key.robot > 0 && robot == 0;
    if (opens) now += fmt::format(",\"r{}\":{{", robot = key.robot);
    now += opens ? member : "," + member;
  });
  close();
  return datagrams_;
}

}  // namespace skein::app
