#pragma once

#include <optional>
#include <string>

namespace skein::vision {

/// Whether a camera's frames come as often as it was asked for. Many cameras lower their rate in the dark without
/// reporting it, and a camera whose bus is full leaves frames out. For one thread.
class RateWatch {
 public:
  /// Of the rate asked for.
  static constexpr double least_share = 0.95;

  /// `wanted`: [frames/s]
  explicit RateWatch(double wanted) : wanted_(wanted) {}

  /// A frame was captured at time `t` [s]. Returns a message for the operator, without a full stop, once frames have
  /// come too seldom for three seconds, and not again until they have come often enough; otherwise empty.
  std::string update(double t);

 private:
  double wanted_;
  std::optional<double> since_;  // of the frames that are counted
  int frames_ = 0;
  int slow_ = 0;  // seconds in a row
};

}  // namespace skein::vision
