#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "app/cli/command_line_studies.h"
#include "app/cli/same_file.h"
#include "app/experiment/text_file.h"
#include "app/record/csv_reader.h"
#include "app/record/report.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/shell_word.h"
#include "app/run/terminal_text.h"
#include "app/tools/outcome_file.h"
#include "app/tools/study_plan.h"
#include "app/tools/sweep_report.h"

namespace skein::app {
namespace {

tl::expected<void, std::string> write_table(const std::string& path, const Outcomes& outcomes) {
  std::ostringstream text;
  write_outcomes(text, outcomes);
  return write_file(path, text.view());
}

/// The options that make the study another one, each behind a blank. `set_word`: how a --set is written.
std::string words_of(const SweepRequest& request, std::string (*set_word)(const std::string&)) {
  std::string text;
  if (request.runs) text += fmt::format(" --runs {}", *request.runs);
  if (request.seed) text += fmt::format(" --seed {}", *request.seed);
  for (const std::string& set : request.sets) text += " --set " + set_word(set);
  return text;
}

/// The study as requested, for the commands that repeat a part of it.
std::string sweep_command(const SweepRequest& request) {
  return "skein sweep " + shell_word(request.file) + words_of(request, shell_word);
}

int print_plan(const SweepRequest& request, const Study& study, unsigned threads) {
  constexpr std::int64_t sample = 32;
  const StudyPlan plan = plan_study(study, sample, threads, [] { return !interrupted(); });
  if (interrupted()) return complain("interrupted: nothing can be said"), expectation_failed;
  // The batch script takes words apart at blanks, other than within single quotes.
  std::string words = words_of(request, [](const std::string& set) {
    return set.find_first_of(" \t\n") == std::string::npos ? set : "'" + set + "'";
  });
  if (!words.empty()) words.erase(0, 1);
  print_out(as_lines(plan, study, {shell_word(request.file), shell_word(words), sweep_command(request)}));
  return done;
}

std::string run_command(const Study& study, std::uint64_t seed) {
  const auto changes = variation(study, seed);
  if (!changes) return changes.error();
  std::string text = "skein run " + shell_word(study.experiment);
  for (const auto* list : {&study.sets, &*changes})
    for (const std::string& set : *list) text += " --set " + shell_word(set);
  return text;
}

}  // namespace

tl::expected<void, std::string> check_table(const std::string& path, const Study& study) {
  if (path.empty()) return {};
  for (const std::string& input : {study.file, study.experiment})
    if (same_file(path, input))
      return tl::unexpected(fmt::format("{}: is a file that the study is read from, allowed: another name", path));
  // A FIFO is not opened: that would wait for its other end.
  if (std::error_code unknown; std::filesystem::is_regular_file(path, unknown))
    if (std::ifstream there(path); CsvReader::open(there, path))
      return tl::unexpected(fmt::format("{}: is the record of a run, allowed: another name", path));
  return check_can_write(path);
}

unsigned usable_cores() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  if (sched_getaffinity(0, sizeof cores, &cores) == 0 && CPU_COUNT(&cores) > 0)
    return static_cast<unsigned>(CPU_COUNT(&cores));
  return std::max(1U, std::thread::hardware_concurrency());
}

int sweep(const SweepRequest& request) {
  auto study = load_study(request.file);
  if (!study) {
    print_error(messages(study.error()) + "\n");
    return wrong_input;
  }
  study->sets.insert(study->sets.end(), request.sets.begin(), request.sets.end());
  if (request.runs) study->runs = *request.runs;
  if (request.seed) study->seed = *request.seed;
  if (request.only) study->seed = *request.only, study->runs = 1;
  if (const auto problems = check_study(*study); !problems.empty()) {
    print_error(messages(problems) + "\n");
    return wrong_input;
  }

  if (!request.report.empty())
    if (const auto possible = check_report(request.report); !possible) return complain(possible.error()), wrong_input;
  Part part;
  if (!request.part.empty()) {
    const auto parsed = parse_part(request.part);
    if (!parsed) return complain(parsed.error()), wrong_input;
    part = *parsed;
    const std::string file = part_file(request.into, part);
    if (load_part(request.into, *study, part)) {
      if (!request.quiet) fmt::print("part: {} of {}\nkept: {} (already there)\n", part.index, part.of, shown(file));
      return done;
    }
    std::error_code error;
    std::filesystem::create_directories(request.into, error);
    if (error)
      return complain(fmt::format("{}: cannot be written: {} cannot be made: {}", file, request.into, error.message())),
             wrong_input;
    if (std::filesystem::is_directory(file, error))
      return complain(fmt::format("{}: cannot be written: it is a folder", file)), wrong_input;
    // Not the part's own name: another process may be making the same part.
    if (!check_can_write(fmt::format("{}.{}.draft", file, getpid())))
      return complain(fmt::format("{}: cannot be written: {}", file, std::strerror(errno))), wrong_input;
  }
  if (const auto possible = check_table(request.csv, *study); !possible) return complain(possible.error()), wrong_input;

  const bool live = !request.quiet && isatty(STDERR_FILENO) != 0;
  const std::int64_t runs = (study->runs - part.index + part.of) / part.of;
  std::size_t told = 0;
  const auto progress = [&](std::size_t made) {
    if (live && made != told) print_error_as_is(fmt::format("\r\033[K{} of {} runs", told = made, runs));
    return !interrupted();
  };
  const unsigned threads = request.threads > 0 ? request.threads : usable_cores();
  if (request.plan) return print_plan(request, *study, threads);
  Outcomes outcomes;
  if (!request.merge.empty()) {
    auto merged = merge_parts(request.merge, *study);
    if (!merged) return complain(merged.error()), wrong_input;
    for (const auto& [missing, why] : merged->missing)
      complain(fmt::format("part {} of {}: {}: {} --part {}/{} --into {}", missing.index, missing.of, why,
                           sweep_command(request), missing.index, missing.of, shell_word(request.merge)));
    if (!merged->missing.empty()) {
      complain(fmt::format("{} of {} parts are missing: compute them, and merge again", merged->missing.size(),
                           merged->parts));
      return expectation_failed;
    }
    outcomes = std::move(merged->outcomes);
  } else {
    outcomes.study = sweep(*study, threads, progress, false, part);
    if (!study->control.empty() && !interrupted()) outcomes.control = sweep(*study, threads, progress, true, part);
    for (const auto& [name, sets] : study->compare)
      if (!interrupted())
        outcomes.compared.push_back({name, sweep(compared_study(*study, name), threads, progress, false, part)});
  }
  if (live) print_error_as_is("\r\033[K");

  if (!request.part.empty()) {
    if (interrupted())
      return complain(fmt::format("part {} of {} was interrupted: none of it is kept", part.index, part.of)),
             expectation_failed;
    if (const auto saved = save_part(request.into, *study, part, outcomes); !saved)
      return complain(saved.error()), wrong_input;
    if (!request.quiet)
      fmt::print("part: {} of {}\nruns: {}\nkept: {}\n", part.index, part.of, outcomes.study.size(),
                 shown(part_file(request.into, part)));
    return done;
  }
  // The results are told also where a file cannot be written or a figure cannot be drawn.
  int status = done;
  const auto note = [&](const tl::expected<void, std::string>& written) {
    if (written) return;
    complain(written.error());
    status = wrong_input;
  };
  if (!request.csv.empty()) note(write_table(request.csv, outcomes));
  if (!request.report.empty()) note(write_sweep_report(request.report, *study, outcomes));
  const SweepSummary summary = summarise(*study, outcomes.study, outcomes.control);
  auto compared = summaries_of_compared(*study, outcomes);
  if (request.only && !request.quiet && !request.json)
    fmt::print("command: {}\n", shown(run_command(*study, *request.only)));
  if (!request.quiet)
    fmt::print("{}", request.json ? as_json(summary, compared) + "\n"
                                  : shown_lines(as_lines(summary) + as_table_by_robots(summary)));
  if (!compared.empty() && !request.quiet && !request.json) {
    compared.emplace(compared.begin(), summary.name, summary);
    fmt::print("{}", shown_lines(as_table(compared)));
  }

  std::vector<std::string> sentences = failed_expectations(study->expect, summary);
  if (summary.runs < study->runs)
    sentences.insert(sentences.begin(), fmt::format("stopped after {} of {} runs", summary.runs, study->runs));
  for (const auto& [name, made] : outcomes.variants()) {
    const auto fails = [](const RunOutcome& o) { return !o.failure.empty(); };
    const auto first = std::find_if(made->begin(), made->end(), fails);
    if (first == made->end()) continue;
    sentences.push_back(fmt::format("{}{} runs failed; seed {}: {}", name == "study" ? "" : name + ": ",
                                    std::count_if(made->begin(), made->end(), fails), first->seed, first->failure));
  }
  for (const std::string& sentence : sentences) complain(sentence);
  SweepRequest again;  // one run: neither their number nor the first seed
  again.file = request.file, again.sets = request.sets;
  if (!sentences.empty() && !summary.bad_seeds.empty() && !request.only)
    complain(fmt::format("to repeat one of these: {} --only {}", sweep_command(again), summary.bad_seeds.front()));
  return status != done || sentences.empty() ? status : expectation_failed;
}

}  // namespace skein::app
