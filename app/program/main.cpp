// The program `skein`: the one file that sees both the command line and, where there is one, the window.
#include "app/cli/command_line.h"
#include "app/run/version.h"
#include "commit.h"

#ifdef SKEIN_GUI
#include "ui/window.h"
#endif

int main(int argc, char** argv) {
  skein::app::set_commit(SKEIN_COMMIT);
#ifdef SKEIN_GUI
  return skein::app::command_line(argc, argv, skein::ui::show_window);
#else
  return skein::app::command_line(argc, argv, {});
#endif
}
