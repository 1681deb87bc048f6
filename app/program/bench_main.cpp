// The program `skein-bench`: the benchmarks of every room, and of the window where there is one.
#include "app/bench/bench.h"
#include "app/run/version.h"
#include "commit.h"

#ifdef SKEIN_GUI
#include "ui/bench/bench_window.h"
#endif

int main(int argc, char** argv) {
  skein::app::set_commit(SKEIN_COMMIT);
#ifdef SKEIN_GUI
  const auto window = [](double seconds, double hours, int& count, char** words) {
    return skein::ui::bench_window(count, words, seconds, hours);
  };
  return skein::app::bench(argc, argv, window);
#else
  return skein::app::bench(argc, argv);
#endif
}
