#pragma once

#include <optional>

namespace skein::vision {

/// A fault that is reported to the operator only if it lasts, and only once until it has gone.
class LastingFault {
 public:
  /// `long_enough`: [s]
  explicit LastingFault(double long_enough = 2.0) : long_enough_(long_enough) {}

  /// `there`: whether the fault is present at time `t` [s]. true: report it now.
  bool update(double t, bool there) {
    if (!there) {
      since_.reset();
      told_ = false;
      return false;
    }
    if (!since_ || t < *since_) since_ = t;
    if (told_ || t - *since_ < long_enough_) return false;
    told_ = true;
    return true;
  }

 private:
  double long_enough_;
  std::optional<double> since_;
  bool told_ = false;
};

}  // namespace skein::vision
