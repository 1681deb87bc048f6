#include "app/cli/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <variant>

#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_keys.h"
#include "app/experiment/known_robots.h"
#include "app/run/resources.h"
#include "app/runs/run_folder.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

/// The keys of a table that a reader of its own takes, as that reader names them when it meets an unknown one.
std::vector<std::string> keys_of_table(const std::string& table, const std::vector<std::string>& sets = {}) {
  std::vector<std::string> probe = sets;
  probe.push_back(table + ".unknown=0");
  const auto read = parse_experiment(paper_experiment().source, "", probe);
  const std::string allowed = " allowed in " + table + ": ";
  std::vector<std::string> keys;
  for (const Problem& problem : read ? std::vector<Problem>() : read.error()) {
    const auto at = problem.text.find(allowed);
    if (at == std::string::npos) continue;
    std::istringstream names(problem.text.substr(at + allowed.size()));
    for (std::string key; names >> key;) keys.push_back(key.substr(0, key.find(',')));
  }
  return keys;
}

/// Of robots, perturbations and the like, which are counted; of the one whose number is typed, else of the first.
void add_counted(std::vector<Candidate>& result, const std::string& typed) {
  for (const std::string table : {"robot", "perturb", "obstacle", "gain_change", "operator"}) {
    std::string number = "1";
    if (typed.starts_with(table + "."))
      if (const auto digits = typed.substr(table.size() + 1,
                                           typed.find_first_not_of("0123456789", table.size() + 1) - table.size() - 1);
          !digits.empty())
        number = digits;
    for (const std::string& key : keys_of_table(table + ".1"))
      result.push_back({fmt::format("{}.{}.{}=", table, number, key), {}});
  }
}

/// Which keys a path has depends on its shape.
void add_path(std::vector<Candidate>& result) {
  std::vector<std::string> all;
  for (const PathSpec::Shape shape : core::all_of<PathSpec::Shape>()) {
    result.push_back({fmt::format("reference.path.shape={}", word(shape)), {}});
    for (const std::string& key :
         keys_of_table("reference.path", {fmt::format("reference.path.shape=\"{}\"", word(shape))}))
      if (std::find(all.begin(), all.end(), key) == all.end()) all.push_back(key);
  }
  for (const std::string& key : all) result.push_back({"reference.path." + key + "=", {}});
}

std::vector<Candidate> keys(const std::string& typed) {
  std::vector<Candidate> result;
  for (const ExperimentKey& key : experiment_keys()) {
    result.push_back({key.name() + "=", key.help});
    if (const auto* const choice = std::get_if<ChoiceKey>(&key.value))
      for (const std::string_view word : choice->words()) result.push_back({key.name() + "=" + std::string(word), {}});
    if (std::holds_alternative<FlagKey>(key.value) || std::holds_alternative<OptionalFlagKey>(key.value))
      for (const char* word : {"true", "false"}) result.push_back({key.name() + "=" + word, {}});
  }
  for (const core::GainName gain : core::pair_names) {
    const bool strength = gain <= core::gain_names.back();
    result.push_back({fmt::format("controller.{}{}=", strength ? "gains." : "", word(gain)),
                      strength ? "coupling of all pairs" : "slope or weight of the coupling of all pairs"});
  }
  add_counted(result, typed);
  for (const std::string& key : keys_of_table("robot_defaults"))
    result.push_back({fmt::format("robot_defaults.{}=", key), {}});
  add_path(result);
  return result;
}

std::vector<Candidate> shipped(const std::string& folder) {
  std::vector<Candidate> result;
  for (const std::string& name : resource_names(folder)) result.push_back({name, {}});
  return result;
}

std::vector<Candidate> robots(const std::string& file) {
  std::vector<Candidate> result;
  if (const auto known = load_known_robots(known_robots_file(file)))
    for (const KnownRobot& robot : *known)
      if (!robot.spec.name.empty()) result.push_back({robot.spec.name, {}});
  return result;
}

std::vector<Candidate> kept_runs(const std::string& asked) {
  std::vector<Candidate> result{{"last", "the newest kept run"}};
  std::error_code error;
  const auto directory = runs_directory(asked);
  if (!directory) return result;
  for (fs::directory_iterator it(*directory, error), end; !error && it != end; it.increment(error))
    if (std::error_code none; fs::exists(it->path() / run_files::story, none))
      result.push_back({it->path().filename().string(), {}});
  return result;
}

std::vector<Candidate> cameras() {
  std::vector<Candidate> result;
  for (const vision::SourceKind& kind : vision::source_kinds()) {
    const std::string prefix = fmt::format("{}:", kind.name);
    switch (kind.connection) {
      case vision::Connection::file:
      case vision::Connection::network:  // their answers take a second, too long here
        result.push_back({prefix, std::string(kind.what)});
        break;
      case vision::Connection::device:
        if (const auto connected = kind.connected())
          for (const vision::ConnectedCamera& camera : *connected)
            result.push_back({prefix + camera.where, camera.what});
        break;
    }
  }
  return result;
}

}  // namespace

std::optional<std::vector<Candidate>> candidates(const std::string& name, const Typed& typed) {
  const auto option = [&](const char* of) {
    const auto given = typed.options.find(of);
    return given == typed.options.end() ? std::string() : given->second;
  };
  if (name == "--set") return keys(typed.word);
  if (name == "experiment") return shipped("experiments");
  if (name == "study") return shipped("studies");
  if (name == "robots") return robots(option("--file"));
  if (name == "run" || name == "other") return kept_runs(option("--runs-dir"));
  if (name == "source") return cameras();
  return {};
}

}  // namespace skein::app
