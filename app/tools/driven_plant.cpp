#include "app/tools/driven_plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/experiment/hardware.h"
#include "app/run/interrupted.h"

namespace skein::app {
namespace {

Experiment all_stop(Experiment experiment) {
  experiment.failure.link_lost = FailureSpec::LinkLost::all_stop;
  return experiment;
}

}  // namespace

Experiment with_links_of(Experiment experiment, const std::vector<std::size_t>& robots) {
  for (std::size_t i = 0; i < experiment.robots.size(); ++i)
    if (std::find(robots.begin(), robots.end(), i) == robots.end()) experiment.robots[i].link = RobotSpec::Link::sim;
  return experiment;
}

DrivenPlant::DrivenPlant(Experiment experiment, Warn warn)
    : experiment_(all_stop(std::move(experiment))), warn_(std::move(warn)), clock_(has_hardware(experiment_)) {}

tl::expected<std::unique_ptr<DrivenPlant>, std::string> DrivenPlant::open(Experiment experiment,
                                                                          const SessionOptions& options, Warn warn) {
  std::unique_ptr<DrivenPlant> driven(new DrivenPlant(std::move(experiment), std::move(warn)));
  const auto addresses = real_robots(driven->experiment_);
  if (!addresses) return tl::unexpected(addresses.error());
  tl::expected<SafetyNet, std::string>& net = driven->net_;
  if (!addresses->empty()) net = SafetyNet::spread({driven->experiment_.name, *addresses});
  if (!net) driven->warn_(unguarded_sentence(net.error()));
  if (!addresses->empty()) driven->awake_.emplace(driven->experiment_.name).hold(true);
  DrivenPlant& self = *driven;
  SessionOptions with = options;
  if (!with.keep_on) with.keep_on = [&self] { return self.keep_on(); };
  auto plant = Plant::open(driven->experiment_, driven->clock_, with);
  if (!plant) {
    if (net) net->done(std::vector<StopResult>{});  // those that were reached have been stopped
    return tl::unexpected(plant.error());
  }
  driven->plant_ = std::move(*plant);
  if (net)
    net->on_stop([&self](const std::string&) { self.stop(); },
                 [&self] { return stop_results(self.experiment_, self.plant_->robots()); });
  return driven;
}

DrivenPlant::~DrivenPlant() {
  close();
}

void DrivenPlant::stop() noexcept {
  stop_asked_ = true;
  plant_->stop();
}

bool DrivenPlant::keep_on() {
  if (net_)
    for (const std::string& sentence : net_->alarms()) warn_(sentence);
  if (awake_)
    if (const auto alarm = awake_->alarm()) warn_(*alarm);
  return !interrupted() && !stop_asked_.load();
}

bool DrivenPlant::close() {
  if (closed_) return *closed_;
  if (net_) net_->on_stop({}, {});
  if (!plant_) return *(closed_ = true);  // it could not be opened; after an exception the guard stops what was reached
  plant_->close();
  const std::vector<RobotStatus> robots = plant_->robots();
  if (net_) net_->done(stop_results(experiment_, robots));
  awake_.reset();
  closed_ = true;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (robots[i].stop_acknowledged) continue;
    warn_(robot_name(experiment_, i) + " has NOT acknowledged its stop and may still be driving");
    closed_ = false;
  }
  return *closed_;
}

}  // namespace skein::app
