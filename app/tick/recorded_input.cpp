#include "app/tick/recorded_input.h"

#include <algorithm>
#include <cmath>

namespace skein::app {

RecordedInput::RecordedInput(const Experiment& experiment)
    : cameras_(experiment.cameras()),
      measurements_(cameras_ * experiment.robots.size()),
      delays_(experiment.robots.size()),
      links_(experiment.robots.size()),
      laws_(experiment.controller.law.own() ? experiment.robots.size() : 0) {
  input_.events.reserve(EventList::room_for(experiment.robots.size()));
}

const TickInput& RecordedInput::of(const TickRecord& row) {
  if (cameras_ > 1) {
    measurements_ = row.by_camera;
  } else {
    for (std::size_t i = 0; i < measurements_.size(); ++i) measurements_[i] = row.robots[i].measurement;
  }
  commands_.clear();
  for (const Event& event : row.events)
    if (const auto command = command_of(event)) commands_.push_back(*command);
  for (std::size_t i = 0; i < delays_.size(); ++i)
    delays_[i] = std::isnan(row.robots[i].actuation_delay) ? 0.0 : row.robots[i].actuation_delay;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    links_[i] = row.robots[i].link.input;
    links_[i].linked = !std::isnan(links_[i].blind_way);
  }
  for (std::size_t i = 0; i < laws_.size(); ++i) laws_[i] = row.robots[i].law;
  input_.now = row.now;
  input_.elapsed = static_cast<int>(std::max<std::int64_t>(1, row.tick - last_tick_));
  for (const Event& event : row.events)  // while staging, no tick is counted
    if (const auto* const missed = std::get_if<events::DeadlineMissed>(&event)) input_.elapsed = missed->ticks + 1;
  input_.stop = row.events.contains<events::Stop>();
  input_.measurements = measurements_;
  input_.delays = delays_;
  input_.links = links_;
  input_.commands = commands_;
  input_.recorded = true;
  input_.law = laws_;
  input_.events.clear();
  for (const Event& event : row.events)
    if (is<events::Perturb, events::Move, events::Kick>(event)) input_.events.add(event);
  last_tick_ = row.tick;
  return input_;
}

}  // namespace skein::app
