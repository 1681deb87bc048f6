#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace skein::app {

/// Checks that the record of a kept run follows from its inputs, bit for bit.
struct Verification {
  struct Step {
    std::string what;  ///< "story", "files", "experiment", "commands", "run_again"
    bool holds = false;
    std::string finding;  ///< a sentence: what was compared, or the first difference, or why it is not possible
  };
  std::vector<Step> steps;
  std::vector<std::string> notes;

  bool holds() const noexcept;
};

/// The checks of the run in a folder:
///  - story: run.json is as it was written (not of runs from before it had a hash of its own)
///  - files: each exists with its hash in run.json; there are no others
///  - experiment: the record embeds the experiment of the folder
///  - commands: the recorded measurements and operator's commands, run through the same ticks again, give every
///    command (as `skein replay`); with a film, the measurements come from its frames
///  - run_again: for a run on the virtual clock, running the experiment again gives every byte of the record
/// The error: there is no run, or run.json is of another format.
tl::expected<Verification, std::string> verify_run(const std::string& folder);

}  // namespace skein::app
