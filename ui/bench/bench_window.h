#pragma once

namespace skein::ui {

/// Measures the window, with half an hour of data in it, and the control thread beside it, and prints figures with
/// their targets. `seconds`: how long each measurement takes. Returns an exit status.
int bench_window(int& argc, char** argv, double seconds);

}  // namespace skein::ui
