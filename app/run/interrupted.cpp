#include "app/run/interrupted.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>

namespace skein::app {
namespace {

std::atomic<int> came{0};  // the first of the signals; 0: none

/// The end of the terminal and whatever else would end the program without a word is SIGTERM.
constexpr std::array endings{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGXCPU, SIGPOLL};

void on_signal(int signal) {
  int none = 0;
  came.compare_exchange_strong(none, signal);
}

}  // namespace

void ignore_output_signals() noexcept {
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGTTOU, SIGTTIN}) std::signal(signal, SIG_IGN);
}

void catch_interrupts() noexcept {
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (const int signal : endings) ::sigaction(signal, &action, nullptr);
  ignore_output_signals();
  // The program that started this one may have blocked signals, which is inherited: this program could not be stopped.
  sigset_t all;
  sigfillset(&all);
  ::sigprocmask(SIG_UNBLOCK, &all, nullptr);
}

void end_by_interrupts() noexcept {
  for (const int signal : endings) std::signal(signal, SIG_DFL);
  if (const int signal = came.load(); signal != 0) std::raise(signal);  // it has come already
}

bool interrupt_when_closed(int pipe) noexcept {
  // The kernel sends SIGIO (SIGPOLL): no thread needs to wait for it. Nothing is written to the pipe.
  const int flags = ::fcntl(pipe, F_GETFL);
  if (flags < 0 || ::fcntl(pipe, F_SETFD, FD_CLOEXEC) < 0 || ::fcntl(pipe, F_SETOWN, ::getpid()) < 0 ||
      ::fcntl(pipe, F_SETFL, flags | O_ASYNC) < 0)
    return false;
  pollfd already{pipe, POLLIN, 0};
  if (::poll(&already, 1, 0) > 0) interrupt();
  return true;
}

void interrupt() noexcept {
  on_signal(SIGTERM);
}

bool interrupted() noexcept {
  return came.load() != 0;
}

}  // namespace skein::app
