#include "app/runs/find_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "app/experiment/text_file.h"
#include "app/runs/run_folder.h"
#include "app/runs/run_index.h"

namespace skein::app {

namespace fs = std::filesystem;

tl::expected<std::string, std::string> find_run(const std::string& word, const std::string& directory) {
  const auto is_run = [](const fs::path& folder) {
    std::error_code ignored;
    return fs::is_regular_file(folder / run_files::story, ignored);
  };
  if (is_run(word)) return word;
  if (word.find('/') == std::string::npos && !word.empty() && is_run(fs::path(directory) / word))
    return (fs::path(directory) / word).string();
  if (word == "last")
    if (auto index = RunIndex::open(directory))
      if (const std::string newest = index->newest(); !newest.empty()) return (fs::path(directory) / newest).string();
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator one(directory, error), end; !error && one != end; one.increment(error))
    if (is_run(one->path())) names.push_back(one->path().filename().string());
  std::sort(names.begin(), names.end());
  const bool fits = std::any_of(names.begin(), names.end(), [&](const auto& name) { return name.starts_with(word); });
  if (!fits && fs::is_directory(word, error))
    return tl::unexpected(
        fmt::format("{}: is not the folder of a kept run: it has no file {}", word, run_files::story));
  if (names.empty()) return tl::unexpected(fmt::format("{}: there is no run; {} has none", word, directory));
  std::vector<std::string> fitting;
  for (const std::string& name : names)
    if (name.starts_with(word)) fitting.push_back(name);
  if (fitting.size() == 1) return (fs::path(directory) / fitting.front()).string();
  if (fitting.empty())
    return tl::unexpected(
        fmt::format("{}: there is no such run in {}, allowed: the name of a run (`skein runs list`), "
                    "its folder, or last",
                    word, directory));
  return tl::unexpected(fmt::format("{}: matches {} runs, from {} to {}, allowed: more of the name", word,
                                    fitting.size(), fitting.front(), fitting.back()));
}

tl::expected<RunRecord, std::string> record_of(const std::string& word, const std::string& asked_directory) {
  std::error_code ignored;
  const bool names_a_file = word.ends_with(".csv") || fs::is_regular_file(word, ignored);
  if (!names_a_file) {
    const auto folder = runs_directory(asked_directory).and_then([&](const std::string& directory) {
      return find_run(word, directory);
    });
    if (!folder) return tl::unexpected(folder.error());
    const fs::path path = fs::absolute(*folder, ignored).lexically_normal();
    const fs::path name = path.has_filename() ? path.filename() : path.parent_path().filename();
    return RunRecord{(path / run_files::record).string(), path.string(), name.string() + ".csv"};
  }
  if (auto is_file = check_is_file(word); !is_file) return tl::unexpected(is_file.error());
  return RunRecord{word, {}, word};
}

}  // namespace skein::app
