#include "vision/diagnosis/rate_watch.h"

#include <fmt/format.h>

namespace skein::vision {

std::string RateWatch::update(double t) {
  constexpr double counted_for = 1.0, gap = 1.0;                    // [s]
  constexpr int long_enough = 3;                                    // counts: a pause falls into two of them at most
  if (!since_ || t < *since_ || t - *since_ > counted_for + gap) {  // the first frame, or the first after an outage
    since_ = t;
    frames_ = 0;
    return {};
  }
  ++frames_;
  if (t - *since_ < counted_for) return {};
  const double rate = frames_ / (t - *since_);
  since_ = t;
  frames_ = 0;
  slow_ = rate < least_share * wanted_ ? slow_ + 1 : 0;
  if (slow_ != long_enough) return {};
  return fmt::format(
      "{:.3g} frames/s come, not {:.3g}: a long or automatic exposure, a full bus, or a busy machine? skein camera "
      "doctor tells",
      rate, wanted_);
}

}  // namespace skein::vision
