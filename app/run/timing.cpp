#include "app/run/timing.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace skein::app {

std::string ask_for_priority(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  // Threads that a library starts in this one are ordinary threads.
  const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted);
  if (error == 0) return {};
  return std::string(std::strerror(error)) + "; `skein doctor` has the remedy";
}

CpuLatencyLimit::CpuLatencyLimit(const Interface& kernel) {
  // A processor leaves its first idle state within 2 us. A virtual machine's "haltpoll" leaves its only one when the
  // host has time for it, whatever it claims: only 0, no idle state at all, keeps it from there.
  std::string driver;
  std::ifstream(kernel.driver) >> driver;
  const std::int32_t limit = driver == "haltpoll" ? 0 : 3;
  device_ = ::open(kernel.device, O_WRONLY | O_CLOEXEC);
  if (device_ >= 0 && ::write(device_, &limit, sizeof limit) == static_cast<ssize_t>(sizeof limit))
    granted_ = limit;
  else
    refused_ = fmt::format("{}: {}; `skein doctor` has the remedy", kernel.device, std::strerror(errno));
}

CpuLatencyLimit::~CpuLatencyLimit() {
  if (device_ >= 0) ::close(device_);
}

}  // namespace skein::app
