#pragma once

#include <limits>

namespace skein::vision {

/// How long a tag has not been seen, to ask once why. Times are those of any clock. [s]
class TagAbsence {
 public:
  static constexpr double patience = 0.5;  ///< before it is asked why [s]

  /// Until then nothing counts as absent; a tag that was never seen may be, if it is expected from a time on.
  void seen(double t) { seen_ = t, asked_ = false; }
  bool lasts(double t) const { return t - seen_ > patience; }
  /// It lasts, and it has not been asked why since the tag was seen.
  bool due(double t) const { return lasts(t) && !asked_; }
  void ask() { asked_ = true; }
  bool asked() const { return asked_; }

 private:
  double seen_ = std::numeric_limits<double>::infinity();
  bool asked_ = false;
};

}  // namespace skein::vision
