#include "comms/emulator/radio.h"

#include <algorithm>
#include <cmath>

namespace skein::comms {
namespace {

constexpr std::size_t packet_bytes = 17;  // of a DM1 packet
// Of a Gaussian: a round trip is in its slowest thousandth when one of its two ways is in its slowest 0.05 %.
constexpr double sigmas = 3.29;

}  // namespace

RadioAdapter::RadioAdapter(const RadioParameters& parameters, std::uint64_t seed)
    : parameters_(parameters), random_(seed, 77) {
  active_at_.fill(-1e9);
}

/// The first time from `at` on at which no burst is on.
double RadioAdapter::clear_of_bursts(double at) {
  const auto mean = [this](double seconds) { return -seconds * std::log(1.0 - random_.uniform()); };
  while (burst_ends_ <= at) {
    burst_begins_ = burst_ends_ + mean(parameters_.burst_every);
    burst_ends_ = burst_begins_ + mean(parameters_.burst);
  }
  return at >= burst_begins_ ? burst_ends_ : at;
}

double RadioAdapter::arrival(std::size_t robot, bool to_robot, std::size_t bytes, double now) {
  const double way = 0.5 * parameters_.median;
  const double sigma = std::log((parameters_.p999 - way) / way) / sigmas;
  double ready = now + way * std::exp(sigma * random_.gaussian());
  if (now - active_at_[robot] > parameters_.sniff_after) {
    const double interval = parameters_.sniff_interval;
    ready = std::max(ready, std::ceil(now / interval) * interval);
  }
  active_at_[robot] = now;
  const auto packets = (bytes + packet_bytes - 1) / packet_bytes;
  const double begins = clear_of_bursts(std::max(now, free_at_));
  free_at_ = begins + static_cast<double>(packets) * parameters_.slot_pair;
  double& newest = newest_[robot][to_robot ? 0 : 1];
  newest = std::max({newest, ready, free_at_});
  return newest;
}

}  // namespace skein::comms
