#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/guard/kept_awake.h"
#include "app/guard/safety_net.h"
#include "app/run/session_clock.h"
#include "app/session/plant.h"

namespace skein::app {

/// The experiment with the links of these robots alone: the others need not be switched on, but their tags are still
/// known.
Experiment with_links_of(Experiment experiment, const std::vector<std::size_t>& robots);

/// The robots and cameras of an experiment for a tool that drives robots itself, without a run: the guard watches
/// over real ones, the machine is kept awake, and Ctrl-C, `skein stop` and a lost link stop them all.
class DrivenPlant {
 public:
  /// Gets sentences that the operator must see, on the thread that opens, drives and closes: nothing would stop the
  /// robots if this program were killed, or a robot has not acknowledged its stop.
  using Warn = std::function<void(const std::string& sentence)>;
  /// The error: a robot's address is wrong, a robot cannot be reached, a camera cannot be opened.
  static tl::expected<std::unique_ptr<DrivenPlant>, std::string> open(Experiment experiment,
                                                                      const SessionOptions& options, Warn warn);
  ~DrivenPlant();  ///< closes
  DrivenPlant(const DrivenPlant&) = delete;
  DrivenPlant& operator=(const DrivenPlant&) = delete;

  const Experiment& experiment() const noexcept { return experiment_; }
  SessionClock& clock() noexcept { return clock_; }
  Plant& plant() noexcept { return *plant_; }
  /// Stops every robot at once and for good; keep_on() is false from then on. Any thread.
  void stop() noexcept;
  /// To be called in every tick. False: a stop was requested.
  bool keep_on();

  /// Stops every robot. False: one has not acknowledged it; a warning was given.
  bool close();

 private:
  DrivenPlant(Experiment experiment, Warn warn);

  const Experiment experiment_;
  const Warn warn_;
  SessionClock clock_;
  tl::expected<SafetyNet, std::string> net_;
  std::optional<KeptAwake> awake_;  // real robots drive
  std::atomic<bool> stop_asked_{false};
  std::unique_ptr<Plant> plant_;
  std::optional<bool> closed_;  // what close() returned
};

}  // namespace skein::app
