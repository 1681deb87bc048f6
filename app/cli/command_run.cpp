#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/same_file.h"
#include "app/exchange/publisher.h"
#include "app/experiment/certificate.h"
#include "app/experiment/experiment_file.h"
#include "app/experiment/hardware.h"
#include "app/experiment/rehearsal.h"
#include "app/experiment/text_file.h"
#include "app/guard/safety_net.h"
#include "app/record/csv_file.h"
#include "app/record/report.h"
#include "app/record/statistics.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/resources.h"
#include "app/runs/kept_run.h"
#include "app/runs/run_end.h"
#include "app/runs/run_folder.h"
#include "app/session/camera_film.h"
#include "app/session/experiment_cameras.h"
#include "app/session/session.h"
#include "app/session/tag_crops.h"

namespace skein::app {
namespace {

/// Tells a person at a terminal how far the run is; says nothing into a pipe.
class Progress final : public RecordSink {
 public:
  Progress(const Experiment& experiment, bool quiet)
      : duration_(experiment.duration), shown_(!quiet && isatty(STDERR_FILENO) != 0) {}
  ~Progress() override {
    if (shown_) print_error_as_is("\r\033[K");
  }
  void record(const TickRecord& record) override {
    if (!shown_ || record.tick % 25 != 0) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    print_error_as_is(fmt::format("\r\033[K{:.1f} s of {:g} s, tracking error {:.1f} mm", record.t, duration_,
                                  1e3 * record.tracking_error()));
  }

 private:
  double duration_;
  bool shown_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace

std::optional<Experiment> load(const ExperimentRequest& request) {
  auto experiment = request.file.empty() ? parse_experiment(paper_experiment().source, "platoon.toml", request.sets)
                                         : load_experiment(request.file, request.sets);
  if (experiment && request.rehearse) experiment = rehearsal(*experiment);
  if (experiment) return std::move(*experiment);
  print_error(messages(experiment.error()) + "\n");
  std::error_code unknown;
  if (const auto missing = missing_resources(); missing && !std::filesystem::exists(request.file, unknown))
    complain(*missing);
  return {};
}

bool can_read_calibrations(const Experiment& experiment) {
  const auto readable = check_calibrations(experiment);
  if (!readable) complain_lines(readable.error());
  return readable.has_value();
}

int run(const RunRequest& request) {
  const auto experiment = load(request.experiment);
  if (!experiment) return wrong_input;
  const bool real = has_hardware(*experiment);
  if (real && request.speed == "max") {
    complain("--speed max: a run with real robots or cameras cannot be faster than real time; allowed here: realtime");
    return wrong_input;
  }
  if (!request.video.empty() && experiment->camera.kind() == CameraKind::absent) {
    complain("--video: there is no camera to record (camera.source = \"none\"); allowed: an experiment with a camera");
    return wrong_input;
  }
  if (!can_read_calibrations(*experiment)) return wrong_input;
  const bool live = !request.publish.empty() && request.speed.empty();
  const auto clock = real || request.speed == "realtime" || live ? Session::Clock::wall : Session::Clock::virtual_;
  if (!request.report.empty())
    if (auto possible = check_report(request.report); !possible) {
      complain(possible.error());
      return wrong_input;
    }

  Statistics statistics(*experiment);
  Progress progress(*experiment, request.quiet);
  SessionOptions options;
  options.sinks = {&statistics, &progress};
  options.video = request.video;
  options.guard = true;
  options.keep_on = [] { return !interrupted(); };
  TagCrops crops;
  options.crops = &crops;
  std::vector<std::unique_ptr<CsvFile>> files;
  std::error_code ignored;
  // What the run is read from is not written over, whatever is forced.
  std::vector<std::string> inputs{request.experiment.file};
  const std::string text = request.experiment.file.empty() ? "" : read_text(request.experiment.file).value_or("");
  for (std::string& file : files_named_by(text, request.experiment.sets, *experiment))
    inputs.push_back(std::move(file));
  const auto is_input = [&](const std::string& path) {
    bool read =
        std::any_of(inputs.begin(), inputs.end(), [&](const std::string& input) { return same_file(path, input); });
    for (std::size_t k = 0; k < experiment->cameras(); ++k)
      read = read || belongs_to_source(path, experiment->camera_at(k).source);
    if (!read) return false;
    complain(path + ": is a file that the run is read from, allowed: another file");
    return true;
  };
  const bool films = !request.video.empty();
  for (const std::string& film : films ? film_paths(*experiment, request.video) : std::vector<std::string>()) {
    if (is_input(film)) return wrong_input;
    if (!request.force && std::filesystem::is_regular_file(film, ignored)) {
      complain(fmt::format("{}: already exists, and no run is overwritten; use the free name {}, or --force", film,
                           free_name(request.video)));
      return wrong_input;
    }
    if (const auto possible = check_can_write(film); !possible) {
      complain(possible.error());
      return wrong_input;
    }
  }
  const auto record_to = [&](const std::string& path) {
    if (is_input(path)) return false;
    try {
      files.push_back(std::make_unique<CsvFile>(path, *experiment, CsvOptions{.rules = {.force = request.force}}));
      options.sinks.push_back(files.back().get());
      return true;
    } catch (const std::exception& error) {
      complain(error.what());
      return false;
    }
  };
  std::string of_report = request.report.empty() ? "" : request.report + "/run.csv";
  // The report's own file, by two names: it is written once.
  if (same_place(request.csv, of_report)) of_report.clear();
  for (const std::string& path : {request.csv, of_report})
    if (!path.empty() && !record_to(path)) return wrong_input;

  std::unique_ptr<Publisher> publisher;
  if (!request.publish.empty()) {
    auto opened = Publisher::open(request.publish, *experiment);
    if (!opened) {
      complain(opened.error());
      return wrong_input;
    }
    publisher = std::move(*opened);
    options.sinks.push_back(publisher.get());
  }

  // Last, so that what is refused leaves no kept run that only began.
  std::optional<KeptRun> kept;
  if (request.keep) {
    const auto directory = runs_directory(request.runs_directory);
    if (!directory) return complain(directory.error()), wrong_input;
    auto begun = KeptRun::begin(
        {*directory, request.experiment.file, request.experiment.sets, request.words, clock == Session::Clock::wall},
        *experiment);
    if (!begun) {
      complain(begun.error());
      return wrong_input;
    }
    kept = std::move(*begun);
    if (const auto little = little_room(*directory)) complain(*little);
    if (const auto wrong = wrong_clock()) complain("this machine's clock " + *wrong + ": the kept run bears that date");
    if (!record_to(kept->csv())) return wrong_input;
  }
  const auto keep = [&](const Statistics::Summary& summary, int status, std::vector<std::string> problems,
                        const std::string& film) {
    if (const auto ended = kept->end(summary, {status, std::move(problems), film, {}, crops.all()}); !ended)
      complain(fmt::format("{}: the run is kept, but incomplete: {}", kept->folder(), ended.error()));
    return kept->complete();
  };
  std::vector<std::string> for_crops;
  if (!request.crops.empty()) for_crops.push_back(request.crops);
  if (kept) for_crops.push_back(kept->folder());
  crops.begin(std::move(for_crops));
  auto session = Session::open(*experiment, clock, options);
  if (!session) {
    complain_lines(session.error());
    Statistics::Summary nothing = statistics.summary();
    nothing.failure = session.error();
    files.clear();  // without a row they leave nothing
    if (kept) keep(nothing, device_failed, {session.error()}, "");
    return device_failed;
  }
  if (const auto why = (*session)->unguarded()) complain(unguarded_sentence(*why));
  const auto tell_alarms = [&] {
    for (const std::string& sentence : (*session)->alarms()) complain(sentence);
  };
  const Phase end = (*session)->run([&] {
    tell_alarms();
    return !interrupted();
  });
  (*session)->close();
  tell_alarms();

  Statistics::Summary summary = statistics.summary();
  complete(summary, facts_of(**session, end), *experiment);
  const vision::SourceStatus camera = (*session)->camera();
  if (camera.outages > 0)
    complain(
        fmt::format("the camera failed {} time{}: {}", camera.outages, camera.outages == 1 ? "" : "s", camera.reason));
  if (publisher) {
    const Publisher::Counts counts = publisher->finish();
    summary.published = {counts.sent, counts.dropped};
  }
  for (const auto& file : files) {
    try {
      file->finish();
    } catch (const std::exception& error) {  // whether the robots stand must be reported all the same
      if (summary.failure.empty()) summary.failure = error.what();
    }
  }

  int status_of_report = done;
  if (!request.report.empty())
    if (auto written = write_report(request.report, *experiment, summary); !written) {
      complain(written.error());
      status_of_report = wrong_input;
    }
  if (kept) summary.kept = kept->folder();
  if (!request.quiet) print_out(request.json ? as_json(summary) + "\n" : as_lines(summary), reader_patience);

  const RunVerdict verdict = verdict_of(summary, *experiment);
  for (const std::string& sentence : verdict.problems) complain(sentence);
  // Last, when all results are known.
  if (kept && !keep(summary, verdict.exit_status, verdict.problems, request.video) && status_of_report == done)
    status_of_report = device_failed;
  return verdict.exit_status != done ? verdict.exit_status : status_of_report;
}

}  // namespace skein::app
