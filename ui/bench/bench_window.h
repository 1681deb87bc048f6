#pragma once

namespace skein::ui {

/// Measures the window, with half an hour of data in it, and the control thread beside it, and prints figures with
/// their targets. `seconds`: how long each measurement takes. `hours`: above 0: measures the window's memory during a
/// run of this length instead, which takes a fiftieth of that time. Returns an exit status.
int bench_window(int& argc, char** argv, double seconds, double hours);

}  // namespace skein::ui
