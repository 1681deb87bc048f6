#pragma once

#include <functional>

#include "app/experiment/window_request.h"

namespace skein::app {

/// Opens the window and returns the program's exit status (app/run/exit_status.h); empty in a program that was built
/// without one.
using ShowWindow = std::function<int(const WindowRequest& request, int& argc, char** argv)>;

/// The program `skein`: reads and executes the command line. Never throws.
int command_line(int argc, char** argv, const ShowWindow& show_window);

}  // namespace skein::app
