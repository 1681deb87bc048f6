#include "app/runs/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/experiment/text_file.h"
#include "app/record/csv_columns.h"
#include "app/record/csv_reader.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/run/version.h"
#include "app/runs/run_folder.h"
#include "app/runs/sha256.h"
#include "app/session/session.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Step = Verification::Step;

/// Whether a file of this name may be left by a program that was killed while it drew the figures.
bool left_by_drawing(const std::string& name) {
  constexpr const char* draft = ".new";  // of write_file
  return name.starts_with("figure3.") || name.starts_with("figure4.") ||
         name == std::string(run_files::story) + draft || name == std::string(run_files::summary) + draft;
}

Step check_files(const std::string& folder, const Json& story, std::vector<std::string>& notes) {
  Step step{"files", true, {}};
  constexpr std::size_t most = 20;  // sentences
  std::size_t failed = 0;
  const auto fail = [&](const std::string& sentence) {
    step.holds = false;
    if (++failed <= most) step.finding += (failed > 1 ? "; " : "") + sentence;
  };
  if (!story.contains("files") || !story["files"].is_object()) {
    fail("run.json names no files: the run did not finish");
    return step;
  }
  std::set<std::string> known{run_files::story};
  for (const auto& [name, file] : story["files"].items()) {
    known.insert(name);
    const fs::path path(name);
    if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end()) {
      fail(fmt::format("{}: is not the name of a file in the folder", name));
      continue;
    }
    const auto hash = sha256_of_file((fs::path(folder) / name).string());
    if (!hash)
      fail(hash.error());
    else if (text_at(file, "sha256") != *hash)
      fail(fmt::format("{}: was changed after the run: its SHA-256 is {}", name, *hash));
  }
  const bool killed_while_drawing = story.value(figures_to_come, Json()) == true;
  std::string left;
  for (const std::string& name : files_of_run(folder)) {
    if (known.contains(name)) continue;
    if (killed_while_drawing && left_by_drawing(name))
      left += (left.empty() ? "" : ", ") + name;
    else
      fail(fmt::format("{}: does not belong to the run", name));
  }
  if (killed_while_drawing)
    notes.push_back(fmt::format("the program was killed while it drew the run's figures: `skein report` draws them{}",
                                left.empty() ? "" : "; not verified, and perhaps not complete: " + left));
  std::error_code error;
  constexpr auto others = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator one(folder, others, error), end; one != end; one.increment(error)) {
    std::error_code gone, closed;
    const std::string name = one->path().lexically_relative(folder).string();
    if (one->is_regular_file(gone)) continue;
    if (one->symlink_status(gone).type() != fs::file_type::directory)
      fail(fmt::format("{}: does not belong to the run: it is a link, a device or a FIFO", name));
    else if (const fs::directory_iterator inside(one->path(), closed); closed)
      fail(fmt::format("{}: cannot be looked into: {}", name, closed.message()));
  }
  if (error) fail(fmt::format("{}: cannot be read: {}", folder, error.message()));
  if (failed > most) step.finding += fmt::format("; and {} more files", failed - most);
  if (step.holds) step.finding = fmt::format("{} files have their hashes in run.json", known.size() - 1);
  return step;
}

Step check_experiment(const std::string& folder, const std::string& csv) {
  std::ifstream in(csv, std::ios::binary);
  const auto reader = CsvReader::open(in, csv);
  if (!reader) return {"experiment", false, reader.error()};
  const auto text = read_text((fs::path(folder) / run_files::as_run).string());
  if (!text) return {"experiment", false, text.error().front().message()};
  if (!reader->head().intact)
    return {"experiment", false, "the experiment within run.csv has been changed since it was recorded"};
  if (reader->head().source != *text)
    return {"experiment", false, "experiment.toml is not the experiment within run.csv"};
  return {"experiment", true, "run.csv embeds experiment.toml"};
}

/// A film with losses, or after a frame that it lacks, proves no pose to the bit, but shows that the poses were
/// measured.
std::string from_film(const ReplayResult& result) {
  if (!result.filmed) return {};
  std::string exact = result.lossless ? fmt::format(", from the {} frames of the film", result.frames) : std::string();
  if (result.poses_approximate == 0) return exact;
  return fmt::format("{}; the film, which {}, gives {} of {} {}poses, {:.3f} mm (rms), at most {:.3f} mm, apart", exact,
                     result.lossless ? "lacks frames" : "is not lossless",
                     result.poses_approximate - result.poses_missing, result.poses_approximate,
                     result.lossless ? "later " : "", 1000.0 * result.pose_error_rms, 1000.0 * result.pose_error_max);
}

Step check_commands(const std::string& folder, const std::string& csv, std::vector<std::string>& notes) {
  std::ifstream in(csv, std::ios::binary);
  const fs::path film = fs::path(folder) / run_files::film;
  std::error_code ignored;
  const auto result = replay(in, csv, fs::is_regular_file(film, ignored) ? film.string() : "");
  if (!result) return {"commands", false, result.error()};
  notes.insert(notes.end(), result->warnings.begin(), result->warnings.end());
  if (result->different > 0 || result->poses_different > 0)
    return {"commands", false,
            fmt::format("{} of {} commands and {} of {} poses differ, first at {}", result->different, result->commands,
                        result->poses_different, result->poses, result->first)};
  if (result->other_film())
    return {"commands", false,
            fmt::format("the film shows none of the run's poses, or others: it is that of another run{}",
                        from_film(*result))};
  return {"commands", true,
          fmt::format("{} commands of {} ticks are the same, bit for bit{}", result->commands, result->ticks,
                      from_film(*result))};
}

/// Compares what a run writes with a file, line by line. The first line, which names the program, may differ.
class Comparison final : public RecordSink {
 public:
  Comparison(std::istream& recorded, const Experiment& experiment, bool pair_gains)
      : recorded_(recorded), writer_(text_, experiment, pair_gains) {
    compare();
  }
  void record(const TickRecord& record) override {
    if (difference_) return;
    writer_.record(record);
    compare();
  }
  /// The number of the first line that differs; none: not one.
  std::optional<std::int64_t> difference() {
    if (std::string line; !difference_ && std::getline(recorded_, line)) difference_ = lines_ + 1;
    return difference_;
  }
  std::int64_t lines() const noexcept { return lines_; }

 private:
  void compare() {
    std::istringstream again(text_.str());
    text_.str({});
    for (std::string line, recorded; !difference_ && std::getline(again, line); ++lines_) {
      const bool there = static_cast<bool>(std::getline(recorded_, recorded));
      if (!there || (line != recorded && !line.starts_with(version_line))) difference_ = lines_ + 1;
    }
  }
  std::istream& recorded_;
  std::ostringstream text_;
  CsvWriter writer_;
  std::int64_t lines_ = 0;
  std::optional<std::int64_t> difference_;
};

Step run_again(const std::string& folder, const std::string& csv) {
  const auto experiment = load_experiment((fs::path(folder) / run_files::as_run).string());
  if (!experiment) return {"run_again", false, experiment.error().front().message()};
  Experiment here = *experiment;
  // A calibration from elsewhere is in the folder under a name of its own: what lies there now is not of this run.
  for (std::size_t k = 0; k < here.cameras(); ++k) {
    std::string& calibration = k == 0 ? here.camera.calibration : here.camera.also[k - 1].calibration;
    if (calibration.empty()) continue;
    const std::string kept = calibration_in_folder(calibration, k);
    if (std::error_code ignored; fs::exists(fs::path(folder) / kept, ignored)) calibration = kept;
  }
  std::ifstream in(csv, std::ios::binary);
  const bool pair_gains = [&] {
    std::ifstream head(csv, std::ios::binary);
    const auto reader = CsvReader::open(head, csv);
    return reader &&
           std::find(reader->columns().begin(), reader->columns().end(), "k_xx_1_2") != reader->columns().end();
  }();
  Comparison comparison(in, here, pair_gains);
  auto session = Session::open(here, Session::Clock::virtual_, {.sinks = {&comparison}});
  if (!session) return {"run_again", false, session.error()};
  (*session)->run();
  (*session)->close();
  if (const auto line = comparison.difference())
    return {"run_again", false, fmt::format("run again, line {} of run.csv differs", *line)};
  return {"run_again", true,
          fmt::format("run again, {} lines of run.csv are the same, bit for bit", comparison.lines())};
}

}  // namespace

bool Verification::holds() const noexcept {
  return std::all_of(steps.begin(), steps.end(), [](const Step& step) { return step.holds; });
}

tl::expected<Verification, std::string> verify_run(const std::string& folder) {
  const auto story = read_story(folder);
  if (!story) return tl::unexpected(story.error());
  if (const auto format = story->find("format");
      format == story->end() || !format->is_number_integer() || format->get<std::int64_t>() != story_format)
    return tl::unexpected(
        fmt::format("{}/{}: found format {}, allowed: {}; what another version of skein kept, that version verifies",
                    folder, run_files::story, format == story->end() ? "none" : format->dump(), story_format));
  const std::string csv = (fs::path(folder) / run_files::record).string();
  Verification result;
  if (const auto whole = seal_holds(*story))
    result.steps.push_back({"story", *whole,
                            *whole ? "run.json is as it was written"
                                   : "run.json: was changed after the run: it has not the SHA-256 that it names"});
  else
    result.notes.emplace_back(
        "run.json has no SHA-256 of its own, as those of earlier versions: what it says is not verified");
  result.steps.push_back(check_files(folder, *story, result.notes));
  auto readable = check_is_file(csv);
  errno = 0;
  if (readable && !std::ifstream(csv))
    readable = tl::unexpected(fmt::format("{}: cannot be opened: {}", csv, std::strerror(errno)));
  if (!readable) {
    result.steps.push_back({"experiment", false, readable.error()});
    return result;
  }
  result.steps.push_back(check_experiment(folder, csv));
  result.steps.push_back(check_commands(folder, csv, result.notes));
  const bool repeats = text_at(*story, "clock") == "virtual" && text_at(*story, "state") == "finished";
  if (repeats)
    result.steps.push_back(run_again(folder, csv));
  else
    result.notes.emplace_back(fmt::format("{}: it follows from its measurements and the operator's commands",
                                          text_at(*story, "state") == "begun" ? "the run did not finish"
                                          : text_at(*story, "state") == "failed"
                                              ? "the run failed"
                                              : "the run was in real time, or was stopped by hand"));
  // Another program may compute otherwise: then a difference is no sign of a changed record.
  const std::string kept_by =
      fmt::format("{} ({})", text_at(*story, "program", "version"), text_at(*story, "program", "commit"));
  if (const std::string here = fmt::format("{} ({})", version, commit()); !result.holds() && kept_by != here)
    result.notes.push_back(
        fmt::format("kept by skein {}, verified by {}: a difference may come from the program", kept_by, here));
  return result;
}

}  // namespace skein::app
