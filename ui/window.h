#pragma once

#include "app/experiment.h"

class QApplication;

namespace skein::ui {

struct WindowOptions {
  int& argc;
  char** argv;
  bool start_at_once = false;  ///< the run begins as soon as the robots stand, with a hint of what to do with them
};

/// Style, smallest font, names and icon of the program: before its first window.
void prepare(QApplication& application);

/// Opens the operator's window on an experiment; returns the program's exit status when it is closed.
int show_window(app::Experiment experiment, const WindowOptions& options);

/// Measures the window, with half an hour of data in it, and the control thread beside it, and prints figures with
/// their targets. `seconds`: how long each measurement takes.
int bench_window(int& argc, char** argv, double seconds);

}  // namespace skein::ui
