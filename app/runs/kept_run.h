#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/record/statistics.h"
#include "app/session/tag_crops.h"

namespace skein::app {

/// The inputs of a run.
struct KeepRequest {
  std::string directory;           ///< of all runs
  std::string experiment;          ///< its file; empty: there is none
  std::vector<std::string> sets;   ///< --set: what was changed against the file
  std::vector<std::string> words;  ///< the command line
  bool real_time = false;
  std::string text{};  ///< as it was written, if there is no file; empty: the paper's experiment, which is built in
  std::chrono::system_clock::time_point (*clock)() = nullptr;  ///< the time of the day; null: the machine's
};

/// What a clock of the day says by which no run is named and found rightly: kept runs are ordered in nanoseconds, which
/// end in the year 2262. Empty: nothing is wrong with it.
std::optional<std::string> wrong_clock();

/// The folder of a kept run, with all its inputs and outputs (docs/runs.md lists the files). Its run.json is written at
/// the beginning, and again at the end with the results and the hash of every file, so that a run that was killed in
/// between is recognised. One thread.
class KeptRun {
 public:
  /// Creates the folder and copies the run's inputs. The error says what cannot be written or read.
  static tl::expected<KeptRun, std::string> begin(const KeepRequest& request, const Experiment& experiment);

  const std::string& folder() const noexcept { return folder_; }
  std::string csv() const { return folder_ + "/run.csv"; }

  struct End {
    int exit_status = 0;
    std::vector<std::string> problems;  ///< sentences: failed expectations, errors
    std::string film;                   ///< of the run, of which the folder gets one; empty: none
    std::vector<std::string> sets{};    ///< --set for what the operator changed during the run
    std::vector<TagCrop> crops{};       ///< tags that were not seen; their files are in the folder already
  };
  /// Summary, film, hashes, and last the figures. The error says what is missing; everything else is written.
  tl::expected<void, std::string> end(const Statistics::Summary& summary, const End& how);
  /// Whether run.json has the results and hashes, after end(): figures may be missing all the same.
  bool complete() const noexcept { return complete_; }

 private:
  KeptRun(std::string folder, const Experiment& experiment, std::string head,
          std::chrono::system_clock::time_point began)
      : folder_(std::move(folder)), experiment_(experiment), head_(std::move(head)), began_(began) {}
  std::string folder_;
  Experiment experiment_;
  std::string head_;  // run.json as it was written at the beginning
  std::chrono::system_clock::time_point began_;
  std::chrono::steady_clock::time_point since_ =
      std::chrono::steady_clock::now();  // began_, on a clock that nobody sets
  bool complete_ = false;
};

/// Removes the films of a run, one for each camera: the run's folder has copies.
void remove_film(const Experiment& experiment, const std::string& film);

/// Makes files in the folder of an ended run part of the run: their hashes go into its run.json. The error names what
/// cannot be read or written; a run that has not ended, or whose run.json was changed, accepts no files.
tl::expected<void, std::string> add_to_kept_run(const std::string& folder, const std::vector<std::string>& files);

/// The same for a file that was written somewhere: only if that is in the run's folder, and if the run still verifies.
/// `folder` empty: there is no kept run.
tl::expected<void, std::string> add_if_inside(const std::string& folder, const std::string& file);

/// Whether this file is one of a kept run's own, to which no hash of a later file may be given: it was there when the
/// run ended. `folder` empty: there is no kept run.
bool is_of_run(const std::string& folder, const std::string& file);

/// The files that an experiment's text, with --set, names: calibrations, robots, trajectories, those of its own
/// controller.
std::vector<std::string> files_named_by(const std::string& text, const std::vector<std::string>& sets,
                                        const Experiment& experiment);

/// The experiment's keys as `skein runs find` knows them: "controller.v_max" and the like with the value of this
/// experiment, the coupling gains (the largest of all pairs), the number of robots. Values are as in a file; keys at
/// the top of the file are below "experiment.".
std::map<std::string, std::string> experiment_facts(const Experiment& experiment);

}  // namespace skein::app
