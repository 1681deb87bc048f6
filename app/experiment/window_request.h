#pragma once

#include <string>

#include "app/experiment/experiment.h"

namespace skein::app {

/// The inputs for opening the operator's window.
struct WindowRequest {
  Experiment experiment;  ///< no robots: its file has errors, which the window shows in its editor
  std::string file;       ///< the experiment's file; empty: none was given, run the paper's experiment
  std::string recording;  ///< a recorded run (CSV) to replay instead; empty: none
};

}  // namespace skein::app
