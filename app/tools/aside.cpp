#include "app/tools/aside.h"

#include <sys/resource.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

namespace skein::app {
namespace {

struct Count {
  bool none_within(std::chrono::duration<double> patience) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, patience, [this] { return running == 0; });
  }

  std::mutex mutex;
  std::condition_variable changed;
  int running = 0;
};

/// Waits at the end of the program: before what the libraries keep is taken down, which the work may use.
class Running {
 public:
  ~Running() { count_->none_within(std::chrono::seconds(2)); }
  const std::shared_ptr<Count>& count() const { return count_; }

 private:
  std::shared_ptr<Count> count_ = std::make_shared<Count>();  // the threads', too, which may outlive this
};

const std::shared_ptr<Count>& count_of_running() {
  static const Running running;
  return running.count();
}

/// Of a thread; it begins with that of the thread that starts it.
int niceness(Aside priority) {
  switch (priority) {
    case Aside::behind:
      return 5;
    case Aside::beside:
      return ::getpriority(PRIO_PROCESS, 0);
  }
  return 0;
}

}  // namespace

void run_aside(std::function<void()> work, Aside priority) {
  const std::shared_ptr<Count>& count = count_of_running();
  {
    const std::lock_guard lock(count->mutex);
    ++count->running;
  }
  std::thread([count, priority, work = std::move(work)]() mutable {
    ::setpriority(PRIO_PROCESS, 0, niceness(priority));  // of this thread
    work();
    work = nullptr;  // and all that it owns
    const std::lock_guard lock(count->mutex);
    --count->running;
    count->changed.notify_all();
  }).detach();
}

bool aside_is_over(double patience) {
  return count_of_running()->none_within(std::chrono::duration<double>(patience));
}

}  // namespace skein::app
