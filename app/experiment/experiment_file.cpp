#include "app/experiment/experiment_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/embedded/embedded.h"
#include "app/experiment/experiment_checks.h"
#include "app/experiment/experiment_sets.h"
#include "app/experiment/experiment_tables.h"
#include "app/experiment/known_robots.h"
#include "app/experiment/sample_file.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_rewrite.h"
#include "app/experiment/toml_table.h"

namespace skein::app {
namespace {

template <typename Timed>
void sort_by_time(std::vector<Timed>& list) {
  std::stable_sort(list.begin(), list.end(), [](const Timed& a, const Timed& b) { return a.t < b.t; });
}

/// "rate" of a problem of --set rate=fast, which has no place in a file.
std::string key_of_set(const Problem& problem) {
  constexpr std::string_view prefix = "--set ";
  return problem.file.substr(prefix.size(), problem.file.find('=') - prefix.size());
}

}  // namespace

tl::expected<Experiment, std::vector<Problem>> parse_experiment(std::string_view text, const std::string& file,
                                                                const std::vector<std::string>& sets) {
  auto parsed = parse_toml(text, file, FileKind::experiment);
  if (!parsed) return tl::unexpected(parsed.error());
  toml::table& document = *parsed;
  std::vector<Problem> refused;
  apply_sets(document, sets, refused);
  const std::string directory = std::filesystem::path(file).parent_path().string();
  const std::size_t of_sets = refused.size();
  bool embedded = embed_known_robots(document, directory, refused);
  embedded = embed_samples(document, directory, refused) || embedded;

  Experiment experiment;
  Problems problems(document, file);
  for (std::size_t k = 0; k < of_sets; ++k) problems.doubt(key_of_set(refused[k]));
  if (refused.size() > of_sets) problems.doubt("robot");  // what other files say of them is missing
  read_tables(document, experiment, problems);
  check_together(experiment, problems);
  if (!problems.empty() || !refused.empty()) {
    std::vector<Problem> all = std::move(problems).sorted();
    all.insert(all.end(), refused.begin(), refused.end());
    return tl::unexpected(std::move(all));
  }
  sort_by_time(experiment.gain_changes);  // only now: places in the file are found by number
  sort_by_time(experiment.perturbations);
  sort_by_time(experiment.actions);
  experiment.source = sets.empty() && !embedded ? std::string(text) : with_document(text, document);
  if (!experiment.source.empty() && !experiment.source.ends_with('\n')) experiment.source += '\n';
  experiment.directory = directory;
  return experiment;
}

tl::expected<std::string, std::vector<Problem>> whole_text(std::string_view text, const std::string& file) {
  auto document = parse_toml(text, file);
  if (!document) return tl::unexpected(document.error());
  std::vector<Problem> refused;
  const std::string directory = std::filesystem::path(file).parent_path().string();
  bool embedded = embed_known_robots(*document, directory, refused);
  embedded = embed_samples(*document, directory, refused) || embedded;
  if (!refused.empty()) return tl::unexpected(refused);
  return embedded ? with_document(text, *document) : std::string(text);
}

tl::expected<Experiment, std::vector<Problem>> load_experiment(const std::string& path,
                                                               const std::vector<std::string>& sets) {
  const auto read = read_text(path);
  if (!read) return tl::unexpected(read.error());
  const std::string& text = *read;
  return parse_experiment(text, path, sets);
}

Experiment paper_experiment() {
  return parse_experiment(embedded::platoon_toml, "platoon.toml").value();
}

}  // namespace skein::app
