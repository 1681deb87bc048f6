#include "comms/emulator/radio_faults.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/simulation/random.h"
#include "core/words.h"

namespace skein::comms {
namespace {

/// Any fault of a kind, as bad as a bad day in a lab makes it.
Fault random_fault(FaultKind kind, core::Random& random) {
  const auto between = [&random](double low, double high) { return low + (high - low) * random.uniform(); };
  Fault fault{.kind = kind};
  switch (kind) {
    case FaultKind::latency:
      fault.duration = between(1.0, 5.0);
      fault.median = between(0.005, 0.08);
      fault.p99 = fault.median * between(1.5, 6.0);
      break;
    case FaultKind::loss:
      fault.duration = between(1.0, 5.0);
      fault.share = between(0.02, 0.4);
      break;
    case FaultKind::burst:
      fault.duration = between(0.05, 1.5);
      break;
    case FaultKind::corruption:
      fault.duration = between(1.0, 3.0);
      fault.share = between(0.001, 0.05);
      break;
    case FaultKind::disconnect:
      fault.duration = between(0.1, 4.0);
      break;
    case FaultKind::reboot:
      fault.duration = between(0.3, 2.0);
      break;
    case FaultKind::stuck:
      fault.duration = 0.0;
      break;
    case FaultKind::stall:
      fault.duration = between(0.5, 1.5);
      break;
    case FaultKind::battery:
      fault.volts = between(3.3, 4.2);
      fault.sag = between(0.0, 0.5);
      fault.duration = between(5.0, 60.0);
      break;
    case FaultKind::ring:
    case FaultKind::swapped_wheels:
    case FaultKind::silent_encoders:
      fault.duration = between(2.0, 10.0);
      break;
  }
  return fault;
}

}  // namespace

std::vector<Fault> random_faults(std::size_t robots, double duration, double mean_interval, std::uint64_t seed) {
  constexpr auto kinds = core::all_of<FaultKind>();
  std::vector<Fault> faults;
  for (std::size_t robot = 0; robot < robots; ++robot) {
    core::Random random(seed, robot);
    double at = 0.0;
    while ((at -= mean_interval * std::log(1.0 - random.uniform())) < duration) {
      const auto kind = kinds[static_cast<std::size_t>(random.uniform() * static_cast<double>(kinds.size()))];
      Fault fault = random_fault(kind, random);
      fault.robot = robot;
      fault.at = at;
      fault.duration = std::min(fault.duration, duration - at);
      faults.push_back(fault);
    }
  }
  return faults;
}

std::vector<Fault> faults_of(const std::vector<Fault>& faults, std::size_t robot) {
  std::vector<Fault> its;
  std::copy_if(faults.begin(), faults.end(), std::back_inserter(its),
               [robot](const Fault& fault) { return fault.robot.value_or(robot) == robot; });
  std::stable_sort(its.begin(), its.end(), [](const Fault& a, const Fault& b) { return a.at < b.at; });
  return its;
}

}  // namespace skein::comms
