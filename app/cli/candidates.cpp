#include "app/cli/candidates.h"

#include <fmt/format.h>

#include <filesystem>
#include <variant>

#include "app/experiment/experiment_keys.h"
#include "app/experiment/known_robots.h"
#include "app/run/resources.h"
#include "app/runs/run_folder.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

std::vector<Candidate> keys() {
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
  return result;
}

std::vector<Candidate> shipped(const std::string& folder) {
  std::vector<Candidate> result;
  for (const std::string& name : resource_names(folder)) result.push_back({name, {}});
  return result;
}

std::vector<Candidate> robots() {
  std::vector<Candidate> result;
  if (const auto known = load_known_robots(known_robots_file("")))
    for (const KnownRobot& robot : *known)
      if (!robot.spec.name.empty()) result.push_back({robot.spec.name, {}});
  return result;
}

std::vector<Candidate> kept_runs() {
  std::vector<Candidate> result{{"last", "the newest kept run"}};
  std::error_code error;
  const auto directory = runs_directory("");
  if (!directory) return result;
  for (fs::directory_iterator it(*directory, error), end; !error && it != end; it.increment(error))
    if (std::error_code none; fs::exists(it->path() / run_files::story, none))
      result.push_back({it->path().filename().string(), {}});
  return result;
}

std::vector<Candidate> cameras() {
  std::vector<Candidate> result{{"images:", "a folder of pictures"}, {"video:", "a film"}};
  std::error_code error;
  for (fs::directory_iterator it("/dev", error), end; !error && it != end; it.increment(error))
    if (const std::string name = it->path().filename().string(); name.starts_with("video"))
      result.push_back({"v4l2:/dev/" + name, "a camera"});
  return result;
}

}  // namespace

std::optional<std::vector<Candidate>> candidates(const std::string& name) {
  if (name == "--set") return keys();
  if (name == "experiment") return shipped("experiments");
  if (name == "study") return shipped("studies");
  if (name == "robots") return robots();
  if (name == "run" || name == "other") return kept_runs();
  if (name == "source") return cameras();
  return {};
}

}  // namespace skein::app
