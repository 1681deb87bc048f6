#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/experiment/experiment.h"

namespace skein::app {

/// The state of one check.
struct Finding {
  enum class State {
    well,
    note,  ///< optional, or needed by some runs only
    ill,   ///< to be fixed before robots drive
  };
  State state = State::well;
  std::string what;    ///< "real-time priority"
  std::string found;   ///< in a few words
  std::string remedy;  ///< what to do; empty if it is well
  /// The commands that `skein doctor --fix` executes, as root; empty: only the user can fix it.
  std::vector<std::vector<std::string>> fix{};
};

struct Examination {
  double seconds = 10.0;  ///< duration of the timing test; 0: without it
  /// Experiments that are to run on it, with their files' names.
  std::vector<std::pair<std::string, Experiment>> experiments{};
};

}  // namespace skein::app
