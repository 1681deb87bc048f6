#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "app/tools/study.h"

namespace skein::app {

/// What a study will cost, from some of its runs, measured on this machine. Times are of the processor, so that other
/// programs on it count little.
struct StudyPlan {
  std::int64_t runs = 0;     ///< of the study
  std::int64_t drives = 0;   ///< for each of them: itself, its control, and what it is compared with
  std::int64_t sampled = 0;  ///< runs measured; fewer than asked for: it was ended
  unsigned threads = 1;      ///< at work at once for `busy`
  double alone = 0.0;        ///< a run with all its drives, mean, while one thread is at work [s]
  double busy = 0.0;         ///< the same while `threads` are [s]
  double interval = 0.0;     ///< half of the 95 % interval of `busy`, from the scatter of the runs [s]

  double core_hours() const noexcept { return static_cast<double>(runs) * busy / 3600.0; }
  /// The number of parts: each takes at most an hour of a core, which is the loss if it is killed; and there is work
  /// for 64 cores, if each then still gets a minute of it. At most 1000, the default limit of a Slurm array.
  std::int64_t parts() const noexcept;
};

/// Drives the first `sample` runs twice: one after the other, and on `threads` threads at once. `keep_going` is asked
/// before each run, by several threads.
StudyPlan plan_study(const Study& study, std::int64_t sample, unsigned threads,
                     const std::function<bool()>& keep_going);

/// How a study is named in a shell.
struct StudyWords {
  std::string file;     ///< one word of the shell
  std::string options;  ///< those that make the study another one, as one word of the shell
  std::string command;  ///< `skein sweep` of the study with these options
};

/// As `key: value` lines: hours on 1, 16 and 64 cores like this one, and the commands for Slurm and --merge.
std::string as_lines(const StudyPlan& plan, const Study& study, const StudyWords& words);

}  // namespace skein::app
