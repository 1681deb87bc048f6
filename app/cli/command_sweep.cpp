#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <thread>

#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/tick_record.h"
#include "app/tools/sweep.h"

namespace skein::app {
namespace {

std::string cell(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}

bool write_csv(const std::string& path, const std::vector<RunOutcome>& outcomes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << "seed,perturbation,collisions,min_distance,obstacle_gap,final_error,recovery,formation_first,failure\n";
  for (const RunOutcome& o : outcomes) {
    std::string failure = o.failure;
    std::replace(failure.begin(), failure.end(), ',', ';');
    file << fmt::format("{},{},{},{},{},{},{},{},{}\n", o.seed, cell(o.perturbation), o.collisions,
                        cell(o.min_distance), cell(o.obstacle_gap), cell(o.final_error),
                        cell(o.recovery.value_or(none)),
                        o.formation_first ? (*o.formation_first ? "true" : "false") : "", failure);
  }
  file.flush();
  if (!file) print_error(fmt::format("skein: {}: cannot be written: {}\n", path, std::strerror(errno)));
  return static_cast<bool>(file);
}

/// A word as a shell takes it.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string run_command(const Study& study, std::uint64_t seed) {
  const auto changes = variation(study, seed);
  if (!changes) return changes.error();
  std::string text = "skein run " + quoted(study.experiment);
  for (const auto* list : {&study.sets, &*changes})
    for (const std::string& set : *list) text += " --set " + quoted(set);
  return text;
}

}  // namespace

int sweep(const SweepRequest& request) {
  auto study = load_study(request.file);
  if (!study) {
    for (const Problem& problem : study.error()) print_error(fmt::format("{}\n", problem.message()));
    return wrong_input;
  }
  study->sets.insert(study->sets.end(), request.sets.begin(), request.sets.end());
  if (request.runs) study->runs = *request.runs;
  if (request.seed) study->seed = *request.seed;
  if (request.only) study->seed = *request.only, study->runs = 1;

  const bool shown = !request.quiet && isatty(STDERR_FILENO) != 0;
  std::size_t told = 0;
  const auto progress = [&](std::size_t runs) {
    if (shown && runs != told) print_error(fmt::format("\r\033[K{} of {} runs", told = runs, study->runs));
    return !interrupted();
  };
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const std::vector<RunOutcome> outcomes = sweep(*study, request.threads > 0 ? request.threads : cores, progress);
  std::vector<RunOutcome> control;
  if (!study->control.empty() && !interrupted())
    control = sweep(*study, request.threads > 0 ? request.threads : cores, progress, true);
  std::vector<std::pair<std::string, SweepSummary>> compared;
  for (const auto& [name, sets] : study->compare) {
    if (interrupted()) break;
    Study other = *study;
    other.sets.insert(other.sets.end(), sets.begin(), sets.end());
    compared.emplace_back(name,
                          summarise(other, sweep(other, request.threads > 0 ? request.threads : cores, progress)));
  }
  if (shown) print_error("\r\033[K");

  if (!request.csv.empty() && !write_csv(request.csv, outcomes)) return wrong_input;
  const SweepSummary summary = summarise(*study, outcomes, control);
  if (request.only && !request.quiet && !request.json) fmt::print("command: {}\n", run_command(*study, *request.only));
  if (!request.quiet) fmt::print("{}", request.json ? as_json(summary, compared) + "\n" : as_lines(summary));
  if (!compared.empty() && !request.quiet && !request.json) {
    compared.emplace(compared.begin(), summary.name, summary);
    fmt::print("{}", as_table(compared));
  }

  std::vector<std::string> sentences = failed_expectations(study->expect, summary);
  if (summary.runs < study->runs)
    sentences.insert(sentences.begin(), fmt::format("stopped after {} of {} runs", summary.runs, study->runs));
  if (summary.failed_runs > 0) {
    const auto first = std::find_if(outcomes.begin(), outcomes.end(), [](const auto& o) { return !o.failure.empty(); });
    sentences.push_back(
        fmt::format("{} runs could not be made; seed {}: {}", summary.failed_runs, first->seed, first->failure));
  }
  for (const std::string& sentence : sentences) complain(sentence);
  if (!sentences.empty() && !summary.bad_seeds.empty() && !request.only)
    print_error(fmt::format("skein: one of these again: skein sweep {} --only {}\n", quoted(request.file),
                            summary.bad_seeds.front()));
  return sentences.empty() ? done : expectation_failed;
}

}  // namespace skein::app
