#include "vision/diagnosis/stamp_watch.h"

#include <fmt/format.h>

#include <algorithm>

namespace skein::vision {

bool StampWatch::update(double captured_at, double arrived_at) {
  const double age = arrived_at - captured_at;
  const bool advances = !newest_ || captured_at > *newest_, fresh = age <= oldest_;
  newest_ = std::max(captured_at, newest_.value_or(captured_at));
  if (!well_at_ || (advances && fresh)) well_at_ = arrived_at;
  const bool before = !fault_.empty();
  if (advances && fresh)
    fault_.clear();
  else if (!before && arrived_at - *well_at_ > patience)
    fault_ = advances ? fmt::format(
                            "its frames are {:.2f} s old when they arrive, by their time stamps and "
                            "camera.latency, and estimation.bridge is {:g} s",
                            age, oldest_)
                      : "its time stamps do not advance, or were set back";
  return before != !fault_.empty();
}

}  // namespace skein::vision
