#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/tools/sweep.h"

namespace skein::app {

/// The outcomes of a study's runs and, if it has them, of its control and of what it is compared with ([compare]); each
/// in the order of the seeds.
struct Outcomes {
  std::vector<RunOutcome> study, control;
  struct Compared {
    std::string name;
    std::vector<RunOutcome> runs;
  };
  std::vector<Compared> compared;  ///< in the order of the file

  /// Each list with its name, "study" first.
  std::vector<std::pair<std::string, std::vector<RunOutcome>*>> variants();
  std::vector<std::pair<std::string, const std::vector<RunOutcome>*>> variants() const;
};

/// The summaries of the runs with which the study is compared.
std::vector<std::pair<std::string, SweepSummary>> summaries_of_compared(const Study& study, const Outcomes& outcomes);

/// A table of outcomes, one row per run, the study's first: CSV with a header row, doubles as the shortest text that
/// reads back to the same bits.
void write_outcomes(std::ostream& out, const Outcomes& outcomes);

/// "3/16", or "auto": this task's place in a Slurm array, among the tasks of a Slurm step or of an MPI job, or in all
/// of these at once. The error says what is allowed, or that there is no such job.
tl::expected<Part, std::string> parse_part(const std::string& text);

/// The path of a part.
std::string part_file(const std::string& directory, const Part& part);

/// Writes a part atomically. It begins with the study's fingerprint: everything that determines the outcomes, including
/// the program's version.
tl::expected<void, std::string> save_part(const std::string& directory, const Study& study, const Part& part,
                                          const Outcomes& outcomes);

/// Reads a part. The error says why it is not a part of this study: missing, torn, of another study or program.
tl::expected<Outcomes, std::string> load_part(const std::string& directory, const Study& study, const Part& part);

/// All parts of a study in a directory; their names have the number of parts. Missing and foreign parts are listed in
/// `missing`, each with its reason; then the outcomes are incomplete.
struct Merged {
  Outcomes outcomes;
  std::int64_t parts = 0;
  struct Missing {
    Part part;
    std::string why;
  };
  std::vector<Missing> missing;
};
tl::expected<Merged, std::string> merge_parts(const std::string& directory, const Study& study);

}  // namespace skein::app
