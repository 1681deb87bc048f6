#include "app/session/bare_thread.h"

#include <algorithm>
#include <chrono>

#include "app/run/timing.h"

namespace skein::app {

BareThread::BareThread(double period, int priority)
    : thread_([this, period, priority](const std::stop_token& stop) { wait_for_deadlines(stop, period, priority); }) {}

int BareThread::priority() const {
  knows_.wait(false);
  return priority_;
}

std::string BareThread::no_priority() const {
  knows_.wait(false);
  return no_priority_;
}

const Histogram& BareThread::so_far() noexcept {
  newest_.take();
  return newest_.value();
}

Histogram BareThread::end() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return late_;
}

void BareThread::wait_for_deadlines(const std::stop_token& stop, double period, int priority) {
  using Clock = std::chrono::steady_clock;
  if (priority > 0) no_priority_ = ask_for_priority(priority);
  priority_ = priority > 0 && no_priority_.empty() ? priority : 0;
  knows_.store(true);
  knows_.notify_all();
  const auto step = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period));
  auto deadline = Clock::now() + step + step / 2;
  while (!stop.stop_requested()) {
    std::this_thread::sleep_until(deadline);
    const auto now = Clock::now();
    late_.add(std::max(0.0, std::chrono::duration<double>(now - deadline).count()));
    newest_.draft() = late_;
    newest_.publish();
    deadline += step * (1 + (now - deadline) / step);
  }
}

}  // namespace skein::app
