#include "app/session/tick_timer.h"

#include <algorithm>
#include <cmath>

namespace skein::app {
namespace {

constexpr double pull = 0.05;  // of a period: what a deadline moves towards the frames in a tick, and waits for one
constexpr double tolerance = 0.02;  // of a period: how far a camera's may be from it
constexpr int free_ticks = 25;      // at first: the deadline may jump, since hardly anybody drives yet

}  // namespace

bool TickTimer::follows_frames() const noexcept {
  if (frames_ <= memory) return false;
  auto sorted = intervals_;
  const auto middle = sorted.begin() + memory / 2;
  std::nth_element(sorted.begin(), middle, sorted.end());
  return std::abs(*middle - period_) <= tolerance * period_;
}

TickTimer::Window TickTimer::window() const noexcept {
  if (!in_step_) return {deadline_, deadline_, deadline_, deadline_};
  return {deadline_ - 2.0 * pull * period_, deadline_ - pull * period_, deadline_, deadline_ + pull * period_};
}

double TickTimer::Window::due(double ready_at) const noexcept {
  return ready_at >= since ? std::clamp(ready_at, earliest, latest) : latest;
}

void TickTimer::frame(double captured_at, double ready_at) noexcept {
  if (frames_ > 0) intervals_[frames_ % memory] = captured_at - captured_at_;
  ++frames_;
  captured_at_ = captured_at;
  ready_at_ = ready_at;
}

int TickTimer::ticked(double now) noexcept {
  ++ticks_;
  in_step_ = false;
  if (follows_frames()) {
    // Of the frame that comes closest to the deadline, by the newest one and their interval.
    const double error = std::remainder(ready_at_ - deadline_, period_);
    in_step_ = std::abs(error) <= pull * period_;
    const double most = ticks_ < free_ticks ? 0.5 : pull;
    deadline_ += std::clamp(error, -most * period_, most * period_);
  }
  const int elapsed = 1 + static_cast<int>(std::max(0.0, std::floor((now - deadline_) / period_)));
  deadline_ += elapsed * period_;
  return elapsed;
}

}  // namespace skein::app
