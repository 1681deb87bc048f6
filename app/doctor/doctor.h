#pragma once

#include <string>
#include <vector>

#include "app/doctor/machine.h"
#include "app/experiment/experiment.h"

namespace skein::app {

/// What stands between a machine and a good run, or does not.
struct Finding {
  enum class State {
    well,
    note,  ///< a run goes well without it, or only some runs need it
    ill,   ///< to be mended before robots drive
  };
  State state = State::well;
  std::string what;    ///< "real-time priority"
  std::string found;   ///< in a few words
  std::string remedy;  ///< what to do; empty where it is well
  /// What `skein doctor --fix` executes, as root; empty: only a person can mend it.
  std::vector<std::vector<std::string>> fix{};
};

struct Examination {
  double seconds = 10.0;  ///< of the test of how well the machine keeps time; 0: without it
  /// Experiments that are to run on it, with their files' names.
  std::vector<std::pair<std::string, Experiment>> experiments{};
};

/// Everything that is looked at, in the order in which it is mended. Takes `seconds` and a little more.
std::vector<Finding> examine(const Machine& machine, const Examination& examination);

/// A line: "well  real-time priority: up to 25".
std::string as_line(const Finding& finding);

}  // namespace skein::app
