#pragma once

#include <string>

#include "app/experiment/experiment.h"

namespace skein::app {

/// What the operator's window needs to open.
struct WindowRequest {
  Experiment experiment;  ///< no robots: its file has errors, which the window shows in its editor
  std::string file;       ///< it was read from; empty: none was named, show the paper's experiment running
  std::string recording;  ///< a recorded run (CSV) to be played instead; empty: none
};

}  // namespace skein::app
