// The program `skein`: the one file that sees both the command line and, where there is one, the window.
#include "app/cli/command_line.h"

#ifdef SKEIN_GUI
#include "ui/window.h"
#endif

int main(int argc, char** argv) {
#ifdef SKEIN_GUI
  const auto bench = [](double seconds, int& count, char** words) {
    return skein::ui::bench_window(count, words, seconds);
  };
  return skein::app::command_line(argc, argv, skein::ui::show_window, bench);
#else
  return skein::app::command_line(argc, argv, {});
#endif
}
