#include "vision/diagnosis/stamp_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace skein::vision {

bool StampWatch::update(double captured_at, double arrived_at) {
  const double age = arrived_at - captured_at;
  const bool advances = !newest_ || captured_at > *newest_, well = advances && age <= oldest_;
  newest_ = std::max(captured_at, newest_.value_or(captured_at));
  if (!well_at_ || well) well_at_ = arrived_at;
  const bool before = !fault_.empty(), again = !std::exchange(well_, well) && !well;
  if (well)
    fault_.clear();
  else if (!before && again && arrived_at - *well_at_ > patience)
    fault_ = advances ? fmt::format(
                            "its frames are {:.2f} s old when they arrive, by their time stamps and "
                            "camera.latency, and estimation.bridge is {:g} s",
                            age, oldest_)
                      : "its time stamps do not advance, or were set back";
  return before != !fault_.empty();
}

std::string StampWatch::update_ahead(double by, double arrived_at) {
  constexpr double no_clock_keeps = 1e-3;  // [s]
  if (!ahead_.update(arrived_at, by > no_clock_keeps)) return {};
  return fmt::format(
      "its time stamps are {:.0f} ms later than the arrival of their frames: its clock is ahead, or camera.latency "
      "does not fit (skein camera latency measures it). A frame counts as captured when it arrives, which is too late: "
      "robots that drive are not where they are taken to be",
      1e3 * by);
}

}  // namespace skein::vision
