#pragma once

#include <limits>

namespace skein::vision {

/// How long a tag has been missing, so that the reason is looked for once. Times are those of any clock. [s]
class TagAbsence {
 public:
  static constexpr double patience = 0.5;  ///< before the reason is looked for [s]

  /// Before the first call nothing counts as absent. For a tag that was never seen, call it with the time from which
  /// the tag is expected.
  void seen(double t) { seen_ = t, asked_ = false; }
  bool lasts(double t) const { return t - seen_ > patience; }
  /// The absence lasts, and the reason has not been looked for since the tag was last seen.
  bool due(double t) const { return lasts(t) && !asked_; }
  void ask() { asked_ = true; }
  bool asked() const { return asked_; }

 private:
  double seen_ = std::numeric_limits<double>::infinity();
  bool asked_ = false;
};

}  // namespace skein::vision
