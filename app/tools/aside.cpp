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
  std::mutex mutex;
  std::condition_variable changed;
  int running = 0;
};

/// Waits at the end of the program: before what the libraries keep is taken down, which the work may use.
class Running {
 public:
  ~Running() {
    constexpr std::chrono::seconds patience(2);
    std::unique_lock lock(count_->mutex);
    count_->changed.wait_for(lock, patience, [this] { return count_->running == 0; });
  }
  const std::shared_ptr<Count>& count() const { return count_; }

 private:
  std::shared_ptr<Count> count_ = std::make_shared<Count>();  // the threads', too, which may outlive this
};

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
  static const Running running;
  const std::shared_ptr<Count> count = running.count();
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

}  // namespace skein::app
