#pragma once

#include "app/experiment/window_request.h"

class QApplication;

namespace skein::ui {

/// Style, smallest font, names and icon of the program: before its first window.
void prepare(QApplication& application);

/// Opens the operator's window; returns the program's exit status when it is closed.
int show_window(const app::WindowRequest& request, int& argc, char** argv);

}  // namespace skein::ui
