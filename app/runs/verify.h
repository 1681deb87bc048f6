#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace skein::app {

/// Whether the record of a kept run is what its inputs give, bit for bit.
struct Verification {
  struct Step {
    std::string what;  ///< "files", "experiment", "commands", "run_again"
    bool holds = false;
    std::string finding;  ///< a sentence: what was compared, or what differs first, or why it cannot be done
  };
  std::vector<Step> steps;
  std::vector<std::string> notes;

  bool holds() const noexcept;
};

/// Of the run in a folder:
///  - files: each is there, and has the hash that run.json says; there are no others
///  - experiment: the record embeds the experiment of the folder
///  - commands: the recorded measurements and operator's commands, put through the same tick once more, give every
///  command
///    (as `skein replay`); with a film, the measurements come from its frames
///  - run_again: for a run on the virtual clock, the experiment run once more gives every byte of the record
/// The error: there is no run.
tl::expected<Verification, std::string> verify_run(const std::string& folder);

}  // namespace skein::app
