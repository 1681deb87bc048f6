#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "app/cli/command_line_studies.h"
#include "app/cli/same_file.h"
#include "app/experiment/text_file.h"
#include "app/record/report.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/tools/tune.h"

namespace skein::app {

int tune(const TuneRequest& request) {
  auto study = load_study(request.file);
  if (!study) {
    for (const Problem& problem : study.error()) print_error(fmt::format("{}\n", problem.message()));
    return wrong_input;
  }
  study->sets.insert(study->sets.end(), request.sets.begin(), request.sets.end());
  if (request.runs) study->runs = *request.runs;
  if (request.seed) study->seed = *request.seed;
  if (study->tune && request.candidates) study->tune->candidates = *request.candidates;
  if (study->tune && request.held_out) study->tune->held_out = *request.held_out;
  if (const auto problems = check_study(*study, study->tune ? study->tune->held_out : 0); !problems.empty()) {
    print_error(messages(problems) + "\n");
    return wrong_input;
  }
  // An hour's work must not end with a file that cannot be written.
  if (!request.report.empty())
    if (const auto possible = check_report(request.report); !possible) return complain(possible.error()), wrong_input;
  std::error_code unknown;
  if (!request.save.empty() && std::filesystem::exists(request.save, unknown))
    return complain(fmt::format("--save {}: there is such a file: name a new one", request.save)), wrong_input;
  if (same_place(request.save, request.csv))
    return complain(fmt::format("--save {}: is the file of --csv as well, allowed: another name", request.save)),
           wrong_input;
  for (const std::string& path : {request.save, request.csv})
    if (const auto possible = check_table(path, *study); !possible) return complain(possible.error()), wrong_input;

  const bool shown = !request.quiet && isatty(STDERR_FILENO) != 0;
  std::int64_t told = 0;
  const auto progress = [&](std::int64_t made) {
    if (shown && made != told)
      print_error_as_is(fmt::format("\r\033[K{} of at most {} runs", told = made, most_runs(*study)));
    return !interrupted();
  };
  const auto tuned = tune(*study, request.threads > 0 ? request.threads : usable_cores(), progress);
  if (shown) print_error_as_is("\r\033[K");
  if (!tuned) {
    complain(fmt::format("{}: {}", request.file, tuned.error()));
    return interrupted() ? expectation_failed : wrong_input;
  }

  // The results first: they are there also where one of the files cannot be written or the figure cannot be drawn.
  int status = tuned->front.empty() ? expectation_failed : done;
  const auto note = [&](const tl::expected<void, std::string>& written) {
    if (written) return;
    complain(written.error());
    status = wrong_input;
  };
  if (!request.quiet)
    print_out(
        fmt::format("study: {}\nexperiment: {}\nruns: {}\ncandidates: {}\nuncertified: {}\nunaffordable: {}\n"
                    "front: {} points\n\n{}verdict: {}\n",
                    study->name, study->experiment, tuned->runs, tuned->candidates, tuned->uncertified,
                    tuned->unaffordable, tuned->front.size(), as_table(*study, *tuned), verdict(*tuned)));
  if (tuned->front.empty()) complain(verdict(*tuned));
  if (!request.csv.empty()) note(write_file(request.csv, as_csv(*study, *tuned)));
  if (!request.save.empty() && !tuned->front.empty())
    note(experiment_with(*study, tuned->front[tuned->chosen], request.save).and_then([&](const std::string& text) {
      return write_file(request.save, text);
    }));
  if (!request.report.empty()) note(write_front(request.report, *study, *tuned));
  return status;
}

}  // namespace skein::app
