#include "app/experiment/sample_file.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <sstream>

#include "app/experiment/text_file.h"

namespace skein::app {
namespace {

constexpr std::size_t most_samples = 100000;

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t begin = text.find_first_not_of(blanks);
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

/// The numbers of one line; empty where a cell is none.
toml::array numbers(std::string_view line) {
  toml::array row;
  while (true) {
    const std::size_t comma = line.find(',');
    const std::string_view cell = trimmed(line.substr(0, comma));
    double value = 0.0;
    const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || stop != cell.data() + cell.size()) return {};
    row.push_back(value);
    if (comma == std::string_view::npos) return row;
    line.remove_prefix(comma + 1);
  }
}

/// Reads one file; adds what is wrong with it, the first thing only.
toml::array read(const std::string& path, std::vector<Problem>& problems) {
  const auto refuse = [&](int line, const std::string& text) {
    problems.push_back({path, line, 0, text});
    return toml::array{};
  };
  const auto whole = read_text(path);
  if (!whole) {
    problems.push_back(whole.error().front());
    return {};
  }
  std::istringstream in(*whole);
  toml::array rows;
  std::size_t columns = 0;
  double last = 0.0;
  int number = 0;
  for (std::string text; std::getline(in, text);) {
    ++number;
    const std::string_view line = trimmed(text);
    if (line.empty() || line.front() == '#') continue;
    if (rows.empty() && columns == 0 && (line == "t,x,y" || line == "t,x,y,theta")) {
      columns = line == "t,x,y" ? 3 : 4;
      continue;
    }
    toml::array row = numbers(line);
    if ((row.size() != 3 && row.size() != 4) || (columns != 0 && row.size() != columns))
      return refuse(number, fmt::format("found \"{}\", allowed: {} numbers, t,x,y{}", line.substr(0, 60),
                                        columns == 0   ? "3 or 4"
                                        : columns == 3 ? "3"
                                                       : "4",
                                        columns == 3   ? ""
                                        : columns == 4 ? ",theta"
                                                       : " or t,x,y,theta"));
    columns = row.size();
    const double t = *row[0].value<double>();
    if (!rows.empty() && !(t > last))
      return refuse(number, fmt::format("found t = {} after {}, allowed: times that increase", t, last));
    last = t;
    rows.push_back(std::move(row));
    if (rows.size() > most_samples) return refuse(number, fmt::format("allowed: up to {} lines", most_samples));
  }
  if (rows.size() < 2) return refuse(0, fmt::format("found {} lines of numbers, allowed: at least 2", rows.size()));
  return rows;
}

}  // namespace

bool embed_samples(toml::table& document, const std::string& directory, std::vector<Problem>& problems) {
  toml::array* const robots = document["robot"].as_array();
  bool any = false;
  for (std::size_t i = 0; robots && i < robots->size(); ++i) {
    toml::table* const robot = (*robots)[i].as_table();
    toml::table* const trajectory = robot ? (*robot)["trajectory"].as_table() : nullptr;
    if (!trajectory) continue;
    const auto name = (*trajectory)["csv"].value_exact<std::string>();
    if (!name || trajectory->contains("samples")) continue;
    toml::array rows = read((std::filesystem::path(directory) / *name).string(), problems);
    if (rows.empty()) continue;
    trajectory->insert_or_assign("samples", std::move(rows));
    trajectory->erase("csv");
    any = true;
  }
  return any;
}

}  // namespace skein::app
