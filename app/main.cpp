// The program `skein`: the one file that sees both the rooms and, where there is one, the window.
#include "app/command_line.h"

#ifdef SKEIN_GUI
#include "ui/window.h"
#endif

int main(int argc, char** argv) {
#ifdef SKEIN_GUI
  return skein::app::command_line(argc, argv, [](const skein::app::WindowRequest& request, int& count, char** words) {
    return skein::ui::show_window(request.experiment, {count, words, request.start_at_once});
  });
#else
  return skein::app::command_line(argc, argv, {});
#endif
}
