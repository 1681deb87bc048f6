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
  // The end of the terminal and whatever else would end the program without a word is SIGTERM.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGXCPU, SIGPOLL})
    ::sigaction(signal, &action, nullptr);
  // A reader of our output that has gone, a file that has grown too large, a terminal that lets nobody write from the
  // background: errors of writing, not the end of a run, nor its standstill.
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGTTOU, SIGTTIN}) std::signal(signal, SIG_IGN);
  // Whoever started the program may have held signals back, and that is inherited: it could not be stopped.
  sigset_t all;
  sigfillset(&all);
  ::sigprocmask(SIG_UNBLOCK, &all, nullptr);
}

void interrupt() noexcept {
  interrupted_flag.store(true);
}

bool interrupted() noexcept {
  return interrupted_flag.load();
}

}  // namespace skein::app
