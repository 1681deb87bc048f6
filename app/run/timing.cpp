#include "app/run/timing.h"

#include <pthread.h>

#include <cerrno>
#include <cstring>

namespace skein::app {

std::string ask_for_priority(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted);
  if (error == 0) return {};
  return std::string(std::strerror(error)) + "; `skein doctor` has the remedy";
}

}  // namespace skein::app
