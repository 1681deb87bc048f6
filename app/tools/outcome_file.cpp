#include "app/tools/outcome_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

#include "app/experiment/text_file.h"
#include "app/record/csv_columns.h"
#include "app/run/version.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t most_parts = 1'000'000;

// One cell: a number that may be missing, and what a yes or no looks like.
std::string cell(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}
std::string cell(std::int64_t value) {
  return fmt::format("{}", value);
}
std::string cell(std::uint64_t value) {
  return fmt::format("{}", value);
}
std::string cell(const std::optional<double>& value) {
  return cell(value.value_or(none));
}
std::string cell(const std::optional<bool>& value) {
  return value ? *value ? "true" : "false" : "";
}
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + '"';
}

template <typename Number>
bool read_number(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}
bool read(std::string_view text, double& value) {
  if (text.empty()) return value = none, true;
  return read_number(text, value);
}
bool read(std::string_view text, std::int64_t& value) {
  return read_number(text, value);
}
bool read(std::string_view text, std::uint64_t& value) {
  return read_number(text, value);
}
bool read(std::string_view text, std::optional<double>& value) {
  if (text.empty()) return value.reset(), true;
  return read_number(text, value.emplace());
}
bool read(std::string_view text, std::optional<bool>& value) {
  value.reset();
  if (!text.empty()) value = text == "true";
  return text.empty() || text == "true" || text == "false";
}
bool read(std::string_view text, std::string& value) {
  value.clear();
  if (!text.starts_with('"')) return value = text, true;
  if (text.size() < 2 || !text.ends_with('"')) return false;
  text = text.substr(1, text.size() - 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    value += text[i];
    if (text[i] == '"') ++i;  // doubled
  }
  return true;
}

/// use(name, value) for every column of a run, in their order.
template <typename Outcome, typename Use>
void for_columns(Outcome& o, Use&& use) {
  use("seed", o.seed);
  use("perturbation", o.perturbation);
  use("collisions", o.collisions);
  use("run_into", o.run_into);
  use("min_distance", o.min_distance);
  use("obstacle_gap", o.obstacle_gap);
  use("final_error", o.final_error);
  use("recovery", o.recovery);
  use("straight", o.straight);
  use("shortest", o.shortest);
  use("formation_first", o.formation_first);
  use("relative_first", o.relative_first);
  use("outside", o.outside);
  use("formation_settled", o.formation_settled);
  use("relative_settled", o.relative_settled);
  use("tracking_settled", o.tracking_settled);
  use("whole", o.whole);
  use("whole_after", o.whole_after);
  use("lag", o.lag);
  use("limited_share", o.limited_share);
  use("effort", o.effort);
  use("v_jumps", o.v_jumps);
  use("reversals", o.reversals);
  use("absent", o.absent);
  use("places_taken", o.places_taken);
  use("failure", o.failure);
  use("robots", o.robots);
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || line[i] != ',')) continue;
    cells.push_back(line.substr(begin, i - begin));
    begin = i + 1;
  }
  return cells;
}

std::string header() {
  std::string text = "variant";
  RunOutcome any;
  for_columns(any, [&](const char* name, const auto&) { text += fmt::format(",{}", name); });
  return text;
}

template <typename Runs, typename All>
std::vector<std::pair<std::string, Runs*>> variants_of(All& outcomes) {
  std::vector<std::pair<std::string, Runs*>> all{{"study", &outcomes.study}, {"control", &outcomes.control}};
  for (auto& other : outcomes.compared) all.emplace_back(other.name, &other.runs);
  return all;
}

/// With a list for everything that the study is compared with.
Outcomes no_outcomes(const Study& study) {
  Outcomes outcomes;
  for (const auto& [name, sets] : study.compare) outcomes.compared.push_back({name, {}});
  return outcomes;
}

tl::expected<Outcomes, std::string> read_rows(std::istream& in, const Study& study) {
  Outcomes outcomes = no_outcomes(study);
  const auto variants = outcomes.variants();
  std::string line;
  if (!std::getline(in, line) || line != header()) return tl::unexpected(std::string("it has other columns"));
  for (std::size_t row = 1; std::getline(in, line); ++row) {
    const std::vector<std::string_view> cells = cells_of(line);
    const bool whole = !in.eof();
    std::string name;
    if (!cells.empty()) read(cells[0], name);
    const auto variant = std::find_if(variants.begin(), variants.end(), [&](const auto& v) { return v.first == name; });
    RunOutcome outcome;
    bool good = whole && variant != variants.end();
    std::size_t k = 1;
    for_columns(outcome, [&](const char*, auto& value) {
      good = good && k < cells.size() && read(cells[k], value);
      ++k;
    });
    if (!good || k != cells.size()) return tl::unexpected(fmt::format("its row {} is torn", row));
    variant->second->push_back(std::move(outcome));
  }
  return outcomes;
}

/// Everything that decides what comes of a study's runs.
std::string fingerprint(const Study& study) {
  std::string all =
      fmt::format("{}\n{}\n{}\n{}\n{}\n", version_and_commit(), study.runs, study.seed, study.definition, study.text);
  for (const auto* sets : {&study.sets, &study.control}) {
    for (const std::string& set : *sets) all += set + '\n';
    all += '\n';
  }
  return fmt::format("{:016x}", fnv1a(all));
}

std::string head(const Study& study, const Part& part) {
  return fmt::format("# skein {}\n# study: {}\n# fingerprint: {}\n# part {} of {}\n", version_and_commit(), study.name,
                     fingerprint(study), part.index, part.of);
}

/// Why a part with another head is not this one.
std::string foreign(const std::string& text, const Study& study, const std::string& expected) {
  if (text.empty()) return "it is empty";
  if (expected.starts_with(text)) return "it is torn within its first lines";
  const auto line = [](const std::string& of, std::size_t number) {
    std::istringstream lines(of);
    std::string found;
    for (std::size_t k = 0; k <= number; ++k) std::getline(lines, found);
    return found;
  };
  constexpr std::size_t program = 0, print = 2, place = 3;
  if (line(text, program).starts_with("# skein ") && line(text, program) != line(expected, program))
    return fmt::format("it was computed by {}, allowed: {}", line(text, program).substr(2),
                       line(expected, program).substr(2));
  if (line(text, print) == line(expected, print) && line(text, place).starts_with("# part "))
    return fmt::format("it is {} of \"{}\"", line(text, place).substr(2), study.name);
  return "it belongs to another study, other --runs, --seed or --set, or another program";
}

constexpr std::string_view last_line = "# hash: ";

/// A part's last line, of all that stands before it.
std::string foot(std::string_view text) {
  return fmt::format("{}{:016x}\n", last_line, fnv1a(text));
}

std::optional<std::int64_t> environment_number(const char* name) {
  const char* const text = std::getenv(name);
  std::int64_t value = 0;
  if (!text || !read_number(std::string_view(text), value)) return {};
  return value;
}

tl::expected<Part, std::string> part_of_job() {
  std::int64_t array = 0, arrays = 1, rank = 0, ranks = 1;
  bool found = false;
  if (const auto id = environment_number("SLURM_ARRAY_TASK_ID")) {
    const auto first = environment_number("SLURM_ARRAY_TASK_MIN"), last = environment_number("SLURM_ARRAY_TASK_MAX"),
               count = environment_number("SLURM_ARRAY_TASK_COUNT");
    if (!first || !last || !count || (*first != 0 && *first != 1) || *last - *first + 1 != *count)
      return tl::unexpected(
          std::string("--part auto: this Slurm array is incomplete (complete: such as --array=1-16), so that the "
                      "number of parts is not known; allowed here: i/n"));
    array = *id - *first, arrays = *count;
    found = true;
  }
  for (const auto& [rank_name, size_name] : {std::pair("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"),
                                             {"PMI_RANK", "PMI_SIZE"},
                                             {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}})
    if (const auto k = environment_number(rank_name), n = environment_number(size_name); k && n) {
      rank = *k, ranks = *n;
      found = true;
      break;
    }
  const Part part{array * ranks + rank + 1, arrays * ranks};
  if (!found)
    return tl::unexpected(
        std::string("--part auto: this is not a task of a Slurm array, of a Slurm step or of an MPI job; allowed here: "
                    "i/n, as in 3/16"));
  if (array < 0 || rank < 0 || rank >= ranks || array >= arrays)
    return tl::unexpected(fmt::format("--part auto: according to the job this is part {} of {}", part.index, part.of));
  return part;
}

}  // namespace

std::vector<std::pair<std::string, std::vector<RunOutcome>*>> Outcomes::variants() {
  return variants_of<std::vector<RunOutcome>>(*this);
}

std::vector<std::pair<std::string, const std::vector<RunOutcome>*>> Outcomes::variants() const {
  return variants_of<const std::vector<RunOutcome>>(*this);
}

std::vector<std::pair<std::string, SweepSummary>> summaries_of_compared(const Study& study, const Outcomes& outcomes) {
  std::vector<std::pair<std::string, SweepSummary>> summaries;
  summaries.reserve(outcomes.compared.size());
  for (const Outcomes::Compared& other : outcomes.compared)
    summaries.emplace_back(other.name, summarise(compared_study(study, other.name), other.runs));
  return summaries;
}

void write_outcomes(std::ostream& out, const Outcomes& outcomes) {
  out << header() << '\n';
  for (const auto& [variant, rows] : outcomes.variants())
    for (const RunOutcome& outcome : *rows) {
      out << cell(variant);
      for_columns(outcome, [&](const char*, const auto& value) { out << ',' << cell(value); });
      out << '\n';
    }
}

tl::expected<Part, std::string> parse_part(const std::string& text) {
  if (text == "auto") return part_of_job();
  const std::size_t slash = text.find('/');
  Part part;
  const std::string_view all(text);
  if (slash == std::string::npos || !read_number(all.substr(0, slash), part.index) ||
      !read_number(all.substr(slash + 1), part.of) || part.of < 1 || part.of > most_parts || part.index < 1 ||
      part.index > part.of)
    return tl::unexpected(
        fmt::format("--part: found \"{}\", allowed: auto, or i/n with i from 1 to n and n up to {}", text, most_parts));
  return part;
}

std::string part_file(const std::string& directory, const Part& part) {
  return (fs::path(directory) / fmt::format("part-{}-of-{}.csv", part.index, part.of)).string();
}

tl::expected<void, std::string> save_part(const std::string& directory, const Study& study, const Part& part,
                                          const Outcomes& outcomes) {
  const std::string path = part_file(directory, part);
  // Of its own for each process: the same part may be made twice at once.
  const std::string draft = fmt::format("{}.{}.draft", path, ::getpid());
  const auto failed = [&] {
    const std::string why = std::strerror(errno);
    std::remove(draft.c_str());
    return tl::unexpected(fmt::format("{}: cannot be written: {}", path, why));
  };
  std::error_code error;
  fs::create_directories(directory, error);
  std::ofstream file(draft, std::ios::binary | std::ios::trunc);
  std::ostringstream text;
  text << head(study, part);
  write_outcomes(text, outcomes);
  file << text.view() << foot(text.view());
  file.close();
  if (!file || std::rename(draft.c_str(), path.c_str()) != 0) return failed();
  return {};
}

tl::expected<Outcomes, std::string> load_part(const std::string& directory, const Study& study, const Part& part) {
  const std::string path = part_file(directory, part);
  // Of any size: a part of a million runs takes hours, and has hundreds of megabytes.
  const auto text = read_text(path, std::numeric_limits<std::uintmax_t>::max());
  std::error_code unknown;  // neither there nor not there, such as a name that is too long
  if (!text)
    return tl::unexpected(fs::exists(path, unknown) || unknown ? text.error().front().message()
                                                               : std::string("it is not there"));
  const std::string expected = head(study, part);
  if (!text->starts_with(expected)) return tl::unexpected(fmt::format("{}: {}", path, foreign(*text, study, expected)));
  const std::size_t end = text->rfind(last_line);
  if (end == std::string::npos || end == 0 || (*text)[end - 1] != '\n')
    return tl::unexpected(fmt::format("{}: it is torn: its last line, {}..., is missing", path, last_line));
  if (text->substr(end) != foot(std::string_view(*text).substr(0, end)))
    return tl::unexpected(fmt::format("{}: it has been changed since it was computed", path));
  std::istringstream in(text->substr(expected.size(), end - expected.size()));
  auto outcomes = read_rows(in, study);
  if (!outcomes) return tl::unexpected(fmt::format("{}: {}", path, outcomes.error()));
  const auto whole = [&](const std::vector<RunOutcome>& rows) {
    std::size_t k = 0;
    for (std::int64_t run = part.index - 1; run < study.runs; run += part.of, ++k)
      if (k >= rows.size() || rows[k].seed != study.seed + static_cast<std::uint64_t>(run)) return false;
    return k == rows.size();
  };
  bool complete =
      whole(outcomes->study) && (study.control.empty() ? outcomes->control.empty() : whole(outcomes->control));
  for (const Outcomes::Compared& other : outcomes->compared) complete = complete && whole(other.runs);
  if (!complete) return tl::unexpected(fmt::format("{}: some of its runs are missing", path));
  return outcomes;
}

tl::expected<Merged, std::string> merge_parts(const std::string& directory, const Study& study) {
  std::set<std::int64_t> cuts;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    Part part;
    const std::string name = entry.path().filename().string();
    if (std::sscanf(name.c_str(), "part-%ld-of-%ld.csv", &part.index, &part.of) == 2 && part.of >= 1 &&
        part.of <= most_parts && fs::path(part_file("", part)).filename() == name)
      cuts.insert(part.of);
  }
  if (error) return tl::unexpected(fmt::format("{}: cannot be read: {}", directory, error.message()));
  if (cuts.empty())
    return tl::unexpected(fmt::format("{}: there are no parts of a study (part-1-of-16.csv, ...)", directory));
  if (cuts.size() > 1)
    return tl::unexpected(fmt::format("{}: there are parts of studies with {} and with {} parts: use a folder for each",
                                      directory, *cuts.begin(), *cuts.rbegin()));
  Merged merged;
  merged.outcomes = no_outcomes(study);
  merged.parts = *cuts.begin();
  const auto variants = merged.outcomes.variants();
  for (std::int64_t i = 1; i <= merged.parts; ++i) {
    auto part = load_part(directory, study, {i, merged.parts});
    if (!part) {
      merged.missing.push_back({{i, merged.parts}, part.error()});
      continue;
    }
    const auto parts = part->variants();
    for (std::size_t v = 0; v < variants.size(); ++v)
      std::move(parts[v].second->begin(), parts[v].second->end(), std::back_inserter(*variants[v].second));
  }
  for (const auto& [name, rows] : variants)
    std::sort(rows->begin(), rows->end(), [](const auto& a, const auto& b) { return a.seed < b.seed; });
  return merged;
}

}  // namespace skein::app
