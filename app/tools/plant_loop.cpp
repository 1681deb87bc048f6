#include "app/tools/plant_loop.h"

#include <algorithm>
#include <thread>

namespace skein::app {

PlantLoop::PlantLoop(Plant& plant, SessionClock& clock, const Experiment& experiment, std::function<bool()> keep_on)
    : plant_(plant),
      clock_(clock),
      period_(experiment.period()),
      keep_on_(std::move(keep_on)),
      by_camera_(experiment.cameras() * plant.tags().size()),
      newest_(plant.tags().size()),
      truth_(experiment.robots.size()),
      wheels_(experiment.robots.size()),
      records_(experiment.robots.size()),
      next_tick_(clock.now()) {}

tl::expected<void, std::string> PlantLoop::tick() {
  if (keep_on_ && !keep_on_()) {
    plant_.stop();
    return tl::unexpected(std::string("stopped"));
  }
  next_tick_ += period_;
  if (clock_.wall()) {
    next_tick_ = std::max(next_tick_, clock_.now());
    std::this_thread::sleep_until(clock_.at(next_tick_));
  } else {
    clock_.set(next_tick_);
  }
  plant_.measure(clock_.now(), by_camera_, truth_, frame_);
  for (std::size_t k = 0; k < by_camera_.size(); ++k)
    if (core::Measurement& newest = newest_[k % newest_.size()]; by_camera_[k].captured_at > newest.captured_at)
      newest = by_camera_[k];
  plant_.act(wheels_);
  if (auto why = plant_.failure()) {
    plant_.stop();
    return tl::unexpected(std::move(*why));
  }
  plant_.fill_links(records_);
  return {};
}

void PlantLoop::stand() {
  std::fill(wheels_.begin(), wheels_.end(), core::WheelSpeeds{});
}

}  // namespace skein::app
