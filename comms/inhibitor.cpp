#include "comms/inhibitor.h"

#include <system_error>
#include <utility>

namespace skein::comms {

Inhibitor::Inhibitor(Ask ask, std::string what) : ask_(std::move(ask)), what_(std::move(what)) {
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    problem_ = error.what();
  }
}

Inhibitor::~Inhibitor() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    wanted_ = false;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Inhibitor::hold(bool on) noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(wanted_, on) == on) return;
    asked_ = false;
  }
  changed_.notify_all();
}

bool Inhibitor::held() const {
  const std::lock_guard lock(mutex_);
  return lock_ != nullptr;
}

std::string Inhibitor::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void Inhibitor::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ends_ || (wanted_ ? !lock_ && !asked_ : lock_ != nullptr); });
    if (!wanted_) lock_.reset();
    if (ends_) return;
    if (!wanted_) continue;
    asked_ = true;  // once each time that it is wanted
    lock.unlock();
    Answer answer = ask_(what_);
    lock.lock();
    lock_ = std::move(answer.held);
    if (!answer.problem.empty()) problem_ = answer.problem;
  }
}

}  // namespace skein::comms
