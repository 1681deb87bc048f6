#include "app/run/interrupted.h"

#include <atomic>
#include <csignal>

namespace skein::app {
namespace {

std::atomic<bool> interrupted_flag{false};

void on_signal(int) {
  interrupted_flag.store(true);
}

}  // namespace

void catch_interrupts() noexcept {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);  // a reader of our output that has gone is a write error, not the end of a run
}

bool interrupted() noexcept {
  return interrupted_flag.load();
}

}  // namespace skein::app
